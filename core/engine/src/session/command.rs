//! Requests to a session between two steps, as data: whoever records a session records them with its hands.

use super::Session;

/// A request to a session between two steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SessionCommand {
    /// [`Session::undo`].
    Undo,
    /// [`Session::redo`].
    Redo,
    /// Gives every tool another size and spring; the next contact has it.
    ResizeTools {
        /// m, radius of the tool's shape, above 0
        radius: f64,
        /// N/m, stiffness of the virtual coupling, above 0
        coupling: f64,
    },
    /// Gives every body another stiffness. It gets there at a limited rate, so that the force on a hand that holds it does not jump.
    SetStiffness {
        /// Factor of the stiffness that the scene gives, 0.001 to 1000
        factor: f64,
    },
}

impl Session {
    /// Does what is requested. Returns whether there was anything to do.
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
            SessionCommand::SetStiffness { factor } => self.want_stiffness(factor),
        }
    }
}
