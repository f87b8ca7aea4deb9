//! Checks of the `[[stitch]]` entries of a scene, and which bodies they tie.

use super::{Plan, list};
use crate::scene::{Extent, IntegratorChoice, Scene, SceneError, Source, StitchScene};
use toml::Spanned;

/// Checks what is stitched together.
///
/// # Errors
/// Names that are no body's, one body twice, an obstacle, neither or both of `pairs` and `distance`, numbers out of range, bodies of which only a local region moves, and an
/// integrator that solves for no constraints.
pub(super) fn check(scene: &Scene, source: &Source) -> Result<(), SceneError> {
    let wrong = |span, text: String| Err(source.error(span, text));
    for entry in &scene.stitch {
        let StitchScene { bodies, pairs, distance, time } = entry.get_ref();
        for name in bodies {
            check_body(name, scene, source)?;
        }
        if bodies[0].get_ref() == bodies[1].get_ref() {
            let text = format!(
                "a `stitch` of body `{}` with itself; allowed are two bodies (seams of one sheet are in its `[[body.stitch]]`)",
                bodies[0].get_ref()
            );
            return wrong(bodies[1].span(), text);
        }
        match (pairs, distance) {
            (Some(pairs), None) if pairs.get_ref().is_empty() => {
                return wrong(pairs.span(), "`pairs` is empty; allowed is at least one pair of vertices".into());
            }
            (Some(_), None) | (None, Some(_)) => {}
            (None, None) | (Some(_), Some(_)) => {
                return wrong(entry.span(), "a `stitch` has one of `pairs` and `distance`".into());
            }
        }
        if let Some(given) = distance.as_ref().filter(|d| !(d.get_ref().si > 0.0 && d.get_ref().si.is_finite())) {
            let text = format!("distance of a stitch is {} m; allowed is a number above 0", given.get_ref().si);
            return wrong(given.span(), text);
        }
        if let Some(given) = time.as_ref().filter(|time| !(time.get_ref().si >= 0.0 && time.get_ref().si.is_finite())) {
            let text = format!("time of a stitch is {} s; allowed is 0 or more", given.get_ref().si);
            return wrong(given.span(), text);
        }
        check_integrator(scene.time.integrator, entry, source)?;
    }
    Ok(())
}

/// Checks that a name is that of a body that moves as a whole.
fn check_body(name: &Spanned<String>, scene: &Scene, source: &Source) -> Result<(), SceneError> {
    let given = name.get_ref();
    if let Some(body) = scene.body.iter().find(|body| body.name.get_ref() == given) {
        if body.extent() == Extent::Local {
            let text = format!(
                "a `stitch` of body `{given}`, of which only cells around tools move; allowed is `grid = {{ region = \"whole\" }}`"
            );
            return Err(source.error(name.span(), text));
        }
        return Ok(());
    }
    if scene.obstacle.iter().any(|obstacle| obstacle.name.get_ref() == given) {
        let text = format!(
            "`{given}` is an obstacle; allowed are two bodies: what is to be held in place has a `[[body.fixed]]`, also one with a `path`"
        );
        return Err(source.error(name.span(), text));
    }
    let known = list(scene.body.iter().map(|body| body.name.get_ref().as_str()));
    Err(source.error(name.span(), format!("no body `{given}`; allowed is {known}")))
}

/// Checks that the integrator solves for the impulses of ties.
fn check_integrator(
    integrator: IntegratorChoice,
    entry: &Spanned<StitchScene>,
    source: &Source,
) -> Result<(), SceneError> {
    match integrator.scheme() {
        Some(scheme) if !scheme.is_implicit() || !scheme.has_inertia() => {
            let text = format!(
                "a `stitch` with the integrator `{}`; allowed is an implicit one with inertia, as `backward-euler`: ties are solved with the matrices \
                 of the bodies' steps",
                scheme.name()
            );
            Err(source.error(entry.span(), text))
        }
        Some(_) | None => Ok(()),
    }
}

impl Plan {
    /// Finds whether bodies are stitched together.
    pub(super) fn find_stitched(&mut self, scene: &Scene) {
        self.is_stitched = !scene.stitch.is_empty();
        if !self.is_stitched {
            self.leave_out("ties between bodies", "the scene has no `[[stitch]]`");
        }
    }
}

/// Whether a body is stitched to another one.
pub(super) fn is_stitched(name: &Spanned<String>, scene: &Scene) -> bool {
    let has = |entry: &Spanned<StitchScene>| entry.get_ref().bodies.iter().any(|body| body.get_ref() == name.get_ref());
    scene.stitch.iter().any(has)
}
