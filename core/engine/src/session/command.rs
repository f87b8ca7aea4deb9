//! Requests to a session between two steps, as data: whoever records a session records them with its hands.

use super::Session;
use crate::body::{Axes, Division};
use crate::edit::Falloff;
use pliant_solver::Vec3;

/// A request to a session between two steps.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionCommand {
    /// Takes back the last edit ([`Session::undo`]).
    Undo,
    /// Makes the edit that was last taken back again ([`Session::redo`]).
    Redo,
    /// Gives every tool another size and spring; the next contact has it.
    ResizeTools {
        /// Radius of the tool's shape, m, above 0.
        radius: f64,
        /// Stiffness of the virtual coupling, N/m, above 0.
        coupling: f64,
    },
    /// Has the strokes that begin from now on act with another strength, but for those that paint, and with another falloff.
    SetBrush {
        /// Factor of the strength that the scene gives each edit, above 0.
        strength: f64,
        /// Decrease of the weight from the centre of the region to its radius.
        falloff: Falloff,
    },
    /// Gives every body another stiffness. It gets there at a limited rate, so that the force on a hand that holds it does not jump.
    SetStiffness {
        /// Factor of the stiffness that the scene gives, 0.001 to 1000
        factor: f64,
    },
    /// Mirrors hands along other axes, of those that the scene's `symmetry` has. The next strokes have it; what is under way and was done before stays as it is.
    SetSymmetry {
        /// Axes along which hands are mirrored; none for no symmetry.
        axes: Axes,
        /// A point on all mirror planes, m
        centre: Vec3,
    },
    /// [`Session::split`]: makes parts of a body bodies of their own.
    SplitBody {
        /// Index of the body among the moving bodies.
        body: u32,
        /// A triangle of the part that leaves the body; `None` if each part does.
        triangle: Option<u32>,
    },
    /// Adds a sculpt layer above the others. What is done from now on is recorded in it.
    AddLayer {
        /// Name for people; two layers may have the same.
        name: String,
    },
    /// Gives a sculpt layer another name.
    RenameLayer {
        /// Number of the layer, from 0 for the lowest.
        layer: u32,
        /// Name from now on, for people; two layers may have the same.
        name: String,
    },
    /// Records what is done from now on in a sculpt layer, which gets its full strength, or below all layers.
    RecordLayer {
        /// Number of the layer; `None` for the base.
        layer: Option<u32>,
    },
    /// Blends what is in a sculpt layer, at once. At less than 1 it no longer records.
    SetLayerStrength {
        /// Number of the layer, from 0 for the lowest.
        layer: u32,
        /// Factor of what is in it, 0 (hidden) to 1.
        strength: f64,
    },
    /// Makes a sculpt layer a part of the base, at its present strength.
    MergeLayer {
        /// Number of the layer.
        layer: u32,
    },
    /// Deletes a sculpt layer with what it does to the shape.
    DeleteLayer {
        /// Number of the layer.
        layer: u32,
    },
}

impl Session {
    /// Does what is requested. Returns whether there was anything to do; where it was refused, an event says why.
    pub fn apply(&mut self, command: SessionCommand) -> bool {
        match command {
            SessionCommand::Undo => self.undo(),
            SessionCommand::Redo => self.redo(),
            SessionCommand::ResizeTools { radius, coupling } => {
                for slot in &mut self.tools {
                    slot.tool.set_radius(radius);
                    slot.tool.coupling.stiffness = coupling;
                }
                !self.tools.is_empty()
            }
            SessionCommand::SetBrush { strength, falloff } => {
                for edit in &mut self.plan.edits {
                    (edit.strength_factor, edit.falloff) = (strength, falloff);
                }
                !self.plan.edits.is_empty()
            }
            SessionCommand::SetStiffness { factor } => self.want_stiffness(factor),
            SessionCommand::SetSymmetry { axes, centre } => self.want_symmetry(axes, centre),
            SessionCommand::SplitBody { body, triangle } => {
                let division = triangle.map_or(Division::EachPart, Division::PartOf);
                self.split(body as usize, division).is_ok()
            }
            SessionCommand::AddLayer { name } => self.add_layer(&name),
            SessionCommand::RenameLayer { layer, name } => self.rename_layer(layer, &name),
            SessionCommand::RecordLayer { layer } => self.record_layer(layer),
            SessionCommand::SetLayerStrength { layer, strength } => self.set_layer_strength(layer, strength),
            SessionCommand::MergeLayer { layer } => self.merge_layer(layer),
            SessionCommand::DeleteLayer { layer } => self.delete_layer(layer),
        }
    }
}
