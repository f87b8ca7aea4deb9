//! Loads on the body that is being stepped.

use super::ToolSlot;
use pliant_solver::NodeSprings;

/// Springs on the body that is being stepped: those of each tool, and last those of the seams where the scene has any.
pub(super) struct StepLoads {
    springs: Vec<NodeSprings>,
    has_seams: bool,
}

impl StepLoads {
    /// Springs of this number of tools, and of the seams.
    pub(super) fn new(tools: usize, has_seams: bool) -> Self {
        let springs = (0..tools + usize::from(has_seams)).map(|_| NodeSprings::default()).collect();
        Self { springs, has_seams }
    }

    /// The springs of all tools and of the seams.
    pub(super) fn springs(&self) -> &[NodeSprings] {
        &self.springs
    }

    /// The springs of the seams; `None` in a scene without seams.
    pub(super) fn seams_mut(&mut self) -> Option<&mut NodeSprings> {
        self.springs.last_mut().filter(|_| self.has_seams)
    }

    /// Whether anything loads the body.
    pub(super) fn is_loaded(&self) -> bool {
        self.springs.iter().any(|springs| !springs.nodes.is_empty())
    }

    /// Exchanges the springs here with those that tools have on body number `index`: before its step they are moved here, and after it they are returned to
    /// the tools, which read them for the reaction.
    pub(super) fn exchange(&mut self, tools: &mut [ToolSlot], index: usize) {
        for (slot, springs) in tools.iter_mut().zip(&mut self.springs) {
            std::mem::swap(slot.tool.springs_mut(index), springs);
        }
    }
}
