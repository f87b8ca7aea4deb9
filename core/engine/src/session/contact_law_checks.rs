//! Checks of the contact laws of tools when a scene is opened: which contacts can use them, and which laws nothing uses.

use super::warning::{Warning, WarningCode};
use super::{ContactChoice, Session, SessionError};
use crate::plan::LeftOut;
use crate::scene::{PluginScene, Scene, Source};
use crate::tool::Tool;
use toml::Spanned;

/// The contact law that a scene gives a tool, by the name of the tool.
fn given<'a>(scene: &'a Scene, tool: &str) -> Option<&'a Spanned<PluginScene>> {
    scene.tool.iter().find(|t| t.name.get_ref() == tool)?.contact_law.as_ref()
}

impl Session {
    /// Leaves out laws of tools that touch nothing, and refuses a law on a solid that its tool meets by triangles.
    ///
    /// # Errors
    /// Returns an error at the law, with the contacts that can use it.
    pub(super) fn check_contact_laws(&mut self, scene: &Scene, source: &Source) -> Result<(), SessionError> {
        let bodies = self.bodies.len();
        for (at, slot) in self.tools.iter_mut().enumerate() {
            let Some(law) = &slot.law else { continue };
            let id = law.info().id.clone();
            let mut edits = self.plan.edits.iter().filter(|edit| edit.tool == at);
            if !edits.any(|edit| edit.kind.begin(edit, &slot.tool, bodies).is_fingertip()) {
                (slot.law, slot.tool.law) = (None, None);
                let what = format!("contact law `{id}` of tool `{}`", slot.tool.name);
                self.plan.left_out.push(LeftOut { what, why: "no edit touches with the tool".into() });
                continue;
            }
            for body in &self.bodies {
                let edge = body.discretization.edge();
                if body.discretization.lattice().is_none() {
                    continue;
                }
                let (shape, tool) = (&slot.tool.proxy.shape, &slot.tool.name);
                if law.is_adhesive() || law.reach() > 0.0 {
                    let span = given(scene, tool).map_or(0..0, |law| law.get_ref().plugin.span());
                    let text = format!(
                        "contact law `{id}` of tool `{tool}` on solid `{}`: it attracts or acts at a distance, and a tool lets go of a solid where \
                         it does not press; allowed is such a law on sheets",
                        body.name
                    );
                    return Err(source.error(span, text).into());
                }
                if !Tool::meets_samples(shape, edge) {
                    let span = given(scene, tool).map_or(0..0, |law| law.get_ref().plugin.span());
                    let [edge, size] = [edge, shape.shape().feature_size()].map(|length| 1e3 * length);
                    let text = format!(
                        "contact law `{id}` of tool `{tool}` on solid `{}`: its cells of {edge:.3} mm are wider than the smallest feature of the \
                         tool, {size:.3} mm, which then meets triangles and not samples with an area; allowed is a law on a solid with \
                         finer cells (`level`), with a larger tool, or on a sheet",
                        body.name
                    );
                    return Err(source.error(span, text).into());
                }
                let why = "a contact law acts at samples of the surface".into();
                let (tool, body) = (tool.clone(), body.name.clone());
                self.choices.contacts.push(ContactChoice { tool, body, by: "samples", law: Some(id.clone()), why });
            }
        }
        Ok(())
    }

    /// Warnings about laws on sheets so coarse that a tool may pass between the vertices at which they act.
    pub(super) fn find_contact_law_warnings(&self, scene: &Scene, source: &Source) -> Vec<Warning> {
        let mut found = Vec::new();
        for slot in self.tools.iter().filter(|slot| slot.law.is_some() && slot.mirror.is_none()) {
            let (tool, size) = (&slot.tool.name, slot.tool.proxy.shape.shape().feature_size());
            for body in self.bodies.iter().filter(|body| body.discretization.sheet().is_some()) {
                let edge = body.discretization.edge();
                if edge <= size {
                    continue;
                }
                let span = given(scene, tool).map_or(0..0, |law| law.get_ref().plugin.span());
                let message = format!(
                    "tool `{tool}` has a contact law, which acts at vertices, and edges of sheet `{}` are {:.3} mm long, more than the {:.3} mm of \
                     the tool: it may pass between vertices; `subdivide` the sheet, or take a larger tool",
                    body.name,
                    1e3 * edge,
                    1e3 * size
                );
                found.push(Warning { code: WarningCode::CoarseSheet, place: source.error(span, "").place(), message });
            }
        }
        found
    }
}
