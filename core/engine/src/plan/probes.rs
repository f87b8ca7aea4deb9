//! Probes of a plan: what is measured of what, when and along which direction.

use super::{Plan, list};
use crate::probe::{QUANTITIES, Quantity, Subject};
use crate::scene::{ProbeScene, Scene, SceneError, Source};
use pliant_solver::Vec3;
use toml::Spanned;

/// A quantity that is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Name in the summary.
    pub name: String,
    /// Quantity that is read from the session.
    pub quantity: &'static Quantity,
    /// Index in [`Plan::tools`], or of the body or obstacle in the scene, depending on the quantity.
    pub of: usize,
    /// Part of the body, counted from 0; `None` for all of it.
    pub part: Option<u32>,
    /// Point to which the measured surface point is the nearest, m.
    pub at: Option<Vec3>,
    /// Unit vector along which the component of a vector is measured; `None` for its length.
    pub direction: Option<Vec3>,
    /// Time of the measurement, s; infinite for the end.
    pub time: f64,
    /// Whether the largest value up to that time is measured.
    pub greatest: bool,
    /// Expected value, SI.
    pub expected: Option<f64>,
    /// Allowed error relative to the expected value.
    pub tolerance: f64,
    /// Source of the expected value.
    pub source: String,
}

impl Plan {
    /// Lists the probes.
    pub(super) fn find_probes(&mut self, scene: &Scene, source: &Source) -> Result<(), SceneError> {
        let tools: Vec<&str> = self.tools.iter().map(|&t| scene.tool[t].name.get_ref().as_str()).collect();
        let bodies: Vec<&str> = scene.body.iter().map(|b| b.name.get_ref().as_str()).collect();
        let obstacles: Vec<&str> = scene.obstacle.iter().map(|o| o.name.get_ref().as_str()).collect();
        for probe in &scene.probe {
            let quantity = Quantity::find(&probe.quantity.get_ref().0).ok_or_else(|| {
                let known = list(QUANTITIES.iter().map(|quantity| quantity.name));
                let text = format!("quantity `{}`; allowed is {known}", probe.quantity.get_ref().0);
                source.error(probe.quantity.span(), text)
            })?;
            let (kind, names) = match quantity.subject {
                Subject::Tool => ("tool in use", &tools),
                Subject::Body => ("body", &bodies),
                Subject::Obstacle => ("obstacle", &obstacles),
            };
            let (whole, part) = match &probe.of {
                Some(name) if quantity.subject == Subject::Body && !names.contains(&name.get_ref().as_str()) => {
                    part_of(name, quantity, source)?
                }
                name => (name.as_ref().map(|name| name.get_ref().as_str()), None),
            };
            let of = match &probe.of {
                None if names.is_empty() => {
                    return Err(source.error(probe.name.span(), format!("a probe of a {kind}, and there is none")));
                }
                None => 0,
                Some(name) => names.iter().position(|n| Some(*n) == whole).ok_or_else(|| {
                    // The mirror image of a tool has its name.
                    let mut known: Vec<&str> = names.clone();
                    known.dedup();
                    let known = list(known.into_iter());
                    source.error(name.span(), format!("no {kind} `{}`; allowed is {known}", name.get_ref()))
                })?,
            };
            if quantity.needs_place && probe.at.is_none() {
                let text = format!("a probe of `{}` needs `at`, a point in the scene", quantity.name);
                return Err(source.error(probe.name.span(), text));
            }
            self.probes.push(Probe {
                name: probe.name.get_ref().clone(),
                quantity,
                of,
                part,
                at: probe.at.map(|p| p.map(|c| c.si).into()),
                direction: direction_of(probe, quantity, source)?,
                time: probe.time.as_ref().map_or(f64::INFINITY, |t| t.get_ref().si),
                greatest: probe.greatest,
                expected: probe.expected.as_ref().map(|e| *e.get_ref()),
                tolerance: *probe.tolerance.get_ref(),
                source: probe.source.clone(),
            });
        }
        Ok(())
    }
}

/// The body and the part, counted from 0, that `BODY.partN` names; the whole text and no part if it is no such name.
///
/// # Errors
/// A part 0, and a quantity that cannot be read of a part.
fn part_of<'a>(
    name: &'a Spanned<String>,
    quantity: &Quantity,
    source: &Source,
) -> Result<(Option<&'a str>, Option<u32>), SceneError> {
    let text = name.get_ref().as_str();
    let split = text.rsplit_once(".part").and_then(|(body, number)| Some((body, number.parse::<u32>().ok()?)));
    let Some((body, number)) = split else { return Ok((Some(text), None)) };
    if number == 0 {
        return Err(source.error(name.span(), format!("part 0 of body `{body}`; allowed is `{body}.part1` and on")));
    }
    if !quantity.reads_parts {
        let known = list(QUANTITIES.iter().filter(|quantity| quantity.reads_parts).map(|quantity| quantity.name));
        let text = format!("`{}` of a part of body `{body}`; allowed of a part is {known}", quantity.name);
        return Err(source.error(name.span(), text));
    }
    Ok((Some(body), Some(number - 1)))
}

/// The unit vector along which a probe measures; `None` for the length of a vector, and for a number.
///
/// # Errors
/// A direction of a quantity that has none, and one that is zero or not finite.
fn direction_of(probe: &ProbeScene, quantity: &Quantity, source: &Source) -> Result<Option<Vec3>, SceneError> {
    let Some(given) = &probe.direction else { return Ok(None) };
    let direction = Vec3::from(*given.get_ref());
    let length = direction.norm();
    if !(length.is_finite() && length > 0.0) {
        let text = format!("direction of a probe is {:?}; allowed is finite numbers, not all 0", given.get_ref());
        return Err(source.error(given.span(), text));
    }
    if !quantity.is_vector() {
        let known = list(QUANTITIES.iter().filter(|quantity| quantity.is_vector()).map(|quantity| quantity.name));
        let text = format!("direction of `{}`, which is a number; allowed is of {known}", quantity.name);
        return Err(source.error(given.span(), text));
    }
    Ok(Some(direction / length))
}
