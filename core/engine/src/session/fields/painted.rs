//! Checks of `paint` edits against the materials of the bodies they may act on.

use super::check_factors;
use crate::body::Body;
use crate::edit::{Command, EditKind};
use crate::scene::{EditScene, Scene, SceneError, Source};
use crate::session::Session;
use crate::session::event::EventKind;
use pliant_host::{ParamSettings, PluginInfo};
use std::ops::Range;

/// Ratio by which a factor is lowered until an explicit integrator is stable with it.
const LOWER: f64 = 0.98;

/// An edit that paints a parameter.
struct PaintEdit<'a> {
    kind: &'static dyn EditKind,
    /// Key of the parameter.
    param: &'a str,
    /// Factor to reach.
    factor: f64,
    /// Where the scene names the parameter, or else the kind.
    span: Range<usize>,
}

/// The edits of a scene that paint.
fn paint_edits<'a>(edits: &'a [EditScene], source: &'a Source) -> impl Iterator<Item = PaintEdit<'a>> {
    edits.iter().filter_map(|edit| {
        let Some(Command::Tool(kind)) = Command::find(&edit.kind.get_ref().0) else { return None };
        let given = edit.param.as_ref().map(|param| param.get_ref().as_str());
        let factor = crate::plan::strength(edit, kind, source).ok().flatten();
        Some(PaintEdit {
            kind,
            param: given.or(kind.param())?,
            factor: factor.or(kind.strength().map(|strength| strength.default))?,
            span: edit.param.as_ref().map_or(edit.kind.span(), toml::Spanned::span),
        })
    })
}

/// Refuses a `paint` whose factor leads out of the range of the parameter of a material with these settings.
///
/// # Errors
/// The factor, the value it leads to and what is allowed.
pub(in crate::session) fn check_paint_range(
    edits: &[EditScene],
    source: &Source,
    info: &PluginInfo,
    settings: &ParamSettings,
) -> Result<(), SceneError> {
    for PaintEdit { kind, param, factor, span } in paint_edits(edits, source) {
        if !info.fields().any(|field| field.key == param) {
            continue; // refused by `check_paint_params` if no body has it
        }
        if let Err(why) = check_factors(param, [factor, 1.0], info, settings) {
            return Err(source.error(span, format!("{} of `{param}`: {why}", kind.name())));
        }
    }
    Ok(())
}

impl Session {
    /// Refuses a `paint` of a parameter that no material of the session lets vary.
    ///
    /// # Errors
    /// Names each body's material, and what it lets vary.
    pub(in crate::session) fn check_paint_params(&self, scene: &Scene, source: &Source) -> Result<(), SceneError> {
        for PaintEdit { kind, param, span, .. } in paint_edits(&scene.edit, source) {
            if self.bodies.is_empty() || self.bodies.iter().any(|body| body.params.iter().any(|key| key == param)) {
                continue;
            }
            let each: Vec<String> = self.bodies.iter().map(|body| refusal(body, param)).collect();
            return Err(source.error(span, format!("{}: {}", kind.name(), each.join("; "))));
        }
        Ok(())
    }

    /// Limits what may be painted on each body to what the integrator follows, and says where a `paint` asks for more.
    pub(in crate::session) fn limit_painting(&mut self, scene: &Scene, source: &Source) {
        let edits: Vec<PaintEdit<'_>> = paint_edits(&scene.edit, source).collect();
        let Some(strongest) = edits.iter().map(|edit| edit.factor.max(1.0 / edit.factor)).reduce(f64::max) else {
            return;
        };
        // As far as all painted parameters together can go.
        let mut most = strongest.powi(4);
        let asked = most;
        while most > 1.0 && !self.motion.limits.allow_stiffness(most, self.clock.dt) {
            most *= LOWER;
        }
        if most >= asked {
            return;
        }
        let most = most.max(1.0);
        self.bodies.iter_mut().for_each(|body| body.most_stiffening = most);
        let (scheme, substeps) = (self.motion.limits.scheme.name(), self.motion.limits.max_substeps);
        if edits.iter().any(|edit| edit.factor.max(1.0 / edit.factor) > most) {
            self.events.add(EventKind::Message, 0.0, || {
                format!(
                    "paint: stiffness over density goes up to {most:.2} times that of the scene, which {scheme} follows with {substeps} \
                     substeps; allow more with `most-substeps`, a smaller `dt` or `integrator = \"backward-euler\"`"
                )
            });
        }
    }
}

/// Why a parameter of a body's material cannot be painted.
pub(in crate::session) fn refusal(body: &Body, param: &str) -> String {
    let known = if body.params.is_empty() { "none of its parameters".into() } else { body.params.join(", ") };
    format!(
        "material `{}` of body `{}`: parameter `{param}` cannot vary over a body; allowed is {known}",
        body.system.material.name(),
        body.name
    )
}
