//! Opening of the models of a scene's bodies, in its order.

use super::Opening;
use crate::body::{Body, Model, Subdivision};
use crate::memory::document_bytes;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::session::level_choice::LevelChosen;
use crate::session::shared::SharedModel;
use crate::session::{EventKind, SessionError, fixings, place};
use pliant_mesh::check::{Severity, Use};
use std::sync::Arc;

/// Moving bodies, and the models of those that stand, by name.
type Bodies = (Vec<Body>, Vec<(String, Arc<Model>)>);

impl Opening<'_> {
    /// The model of each body, with its name.
    pub(super) fn models(&mut self, scene: &Scene) -> Result<Vec<(String, SharedModel)>, SessionError> {
        let mut models = Vec::new();
        for (i, body) in scene.body.iter().enumerate() {
            let instead = self.options.mesh.as_deref().filter(|_| i == 0);
            let smallest = self.tool_radii.smallest;
            let key = || place::model_key(body, self.source, instead, smallest);
            let name = body.name.get_ref();
            self.memory.add_body(name);
            let model = self.shared.model(key, || place::model(body, self.source, instead, &self.memory, smallest))?;
            if let Some(Subdivision { levels, why }) = &model.model.subdivision {
                self.subdivisions.push(LevelChosen { body: name.clone(), level: *levels, why: why.clone() });
            }
            self.memory.update(i, |body| body.model = document_bytes(&model.model.document));
            self.report_defects(name, &model.model);
            models.push((name.clone(), model));
        }
        Ok(models)
    }

    /// The moving bodies, and the models of those that stand.
    pub(super) fn bodies(
        &mut self,
        scene: &Scene,
        plan: &Plan,
        models: Vec<(String, SharedModel)>,
    ) -> Result<Bodies, SessionError> {
        let (mut bodies, mut standing) = (Vec::new(), Vec::new());
        for (i, (name, model)) in models.into_iter().enumerate() {
            if plan.moving[i] {
                bodies.push(self.body(&scene.body[i], i, name, model, &scene.edit, plan.cuts())?);
            } else {
                fixings::check_groups(&scene.body[i], self.source, &model.model)?;
                standing.push((name, model.model));
            }
        }
        Ok((bodies, standing))
    }

    /// Reports defects of a model that is embedded in a grid, as events; none of them prevents the simulation.
    fn report_defects(&mut self, name: &str, model: &Model) {
        let welded = model.document.welds().len();
        if welded > 0 {
            self.events.add(EventKind::Welded, 0.0, || {
                format!(
                    "body `{name}`: {welded} vertices on borders lie where others do and are taken as one with them; `weld = false` leaves the borders apart"
                )
            });
        }
        let turned = model.document.turned_over();
        if let Some(first) = turned.first() {
            let line = model.document.face(*first as usize).map_or(0, |face| face.line);
            self.events.add(EventKind::Model, 0.0, || {
                format!(
                    "body `{name}`: {} of {} faces are turned over, the first in line {line}; they are taken the other way round, and stay as they are in the file",
                    turned.len(),
                    model.document.face_count()
                )
            });
        }
        for finding in &model.findings {
            if finding.severity(Use::Embedded) != Severity::Note {
                self.events.add(EventKind::Model, 0.0, || format!("body `{name}`: {finding}"));
            }
        }
    }
}
