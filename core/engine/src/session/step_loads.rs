//! Loads on the body that is being stepped.

use super::ToolSlot;
use pliant_solver::NodeSprings;

/// Springs on the body that is being stepped: those of each tool, and last those of the seams where the scene has any.
pub(super) struct StepLoads {
    springs: Vec<NodeSprings>,
    /// Springs of the seams of each other body, as of its last step; empty in a scene without seams.
    of_seams: Vec<NodeSprings>,
}

impl StepLoads {
    /// Springs of this number of tools, and of the seams of this number of bodies, 0 in a scene without seams.
    pub(super) fn new(tools: usize, sewn: usize) -> Self {
        let none = |count: usize| (0..count).map(|_| NodeSprings::default()).collect();
        Self { springs: none(tools + usize::from(sewn > 0)), of_seams: none(sewn) }
    }

    /// The springs of all tools and of the seams.
    pub(super) fn springs(&self) -> &[NodeSprings] {
        &self.springs
    }

    /// The springs of the seams; `None` in a scene without seams.
    pub(super) fn seams_mut(&mut self) -> Option<&mut NodeSprings> {
        self.springs.last_mut().filter(|_| !self.of_seams.is_empty())
    }

    /// Whether anything loads the body.
    pub(super) fn is_loaded(&self) -> bool {
        self.springs.iter().any(|springs| !springs.nodes.is_empty())
    }

    /// Exchanges the springs here with those that tools and seams have on body number `index`: before its step they are moved here, and after it they are returned, to
    /// the tools for the reaction, and for a matrix of that body that is assembled again.
    pub(super) fn exchange(&mut self, tools: &mut [ToolSlot], index: usize) {
        for (slot, springs) in tools.iter_mut().zip(&mut self.springs) {
            std::mem::swap(slot.tool.springs_mut(index), springs);
        }
        if self.of_seams.is_empty() {
            return;
        }
        // Bodies that were split off come last.
        self.of_seams.resize_with(self.of_seams.len().max(index + 1), NodeSprings::default);
        if let Some(here) = self.springs.last_mut() {
            std::mem::swap(here, &mut self.of_seams[index]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn springs_of_seams_are_those_of_the_body_that_is_stepped() {
        let mut loads = StepLoads::new(0, 2);
        let count = |loads: &StepLoads| loads.springs()[0].nodes.len();
        for index in [0, 1, 2] {
            loads.exchange(&mut [], index);
            assert_eq!(count(&loads), 0, "body {index} has none yet");
            loads.seams_mut().expect("seams").nodes = vec![0; index + 1];
            loads.exchange(&mut [], index);
        }
        for index in [2, 0, 1] {
            loads.exchange(&mut [], index);
            assert_eq!(count(&loads), index + 1, "as of its step");
            loads.exchange(&mut [], index);
        }
        assert!(StepLoads::new(3, 0).seams_mut().is_none());
    }
}
