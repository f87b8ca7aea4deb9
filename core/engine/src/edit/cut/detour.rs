//! Ways around what a mesh refuses to cut.
//!
//! An advance is refused where its strip meets the mesh in a way that would leave slivers or that cannot be decided. Another strip close to it is
//! not: the drawn area is then swept with a small bend, and no neck is left. Where even that is refused at the end of the cut, a new stroke begins
//! behind it on one side and goes through it to the other, so that both cuts are one.

use super::body_stroke::{BodyStroke, travel};
use super::knife::crumb_volume;
use super::middle::Middle;
use super::sweep::Swept;
use crate::body::{Body, LatticeError};
use pliant_cut::{Advance, Blade, Refusal, Refused, Stroke};
use pliant_solver::Vec3;

/// A blade on the way to another one.
struct Detour {
    /// Where a new stroke begins; `None` to go on from the end of the present one.
    start: Option<Blade>,
    /// Where the strip ends, from which the next one leads on.
    via: Blade,
}

/// How far a blade came on detours, in ascending order of what it may leave behind.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detoured {
    /// Not at all.
    Nowhere,
    /// On from the end of its cut.
    Onward,
    /// Through its own cut, by a strip of another stroke. Where the two strips are twisted against each other a bridge may be left.
    Through,
}

/// Most detours on one way.
const MAX_DETOURS: usize = 8;
/// Most strips that are tried on one way, made or not: a bound of the time of a step.
const MAX_TRIALS: usize = 120;
/// Detours from the end of a cut: share of the way, and distances of tip and heel aside, in strides.
const BENDS: [[f64; 3]; 17] = [
    [0.5, 0.0, 0.0],
    [0.75, 0.0, 0.0],
    [0.25, 0.0, 0.0],
    [0.5, 0.1, 0.1],
    [0.5, -0.1, -0.1],
    [0.8, 0.2, 0.2],
    [0.8, -0.2, -0.2],
    [0.3, 0.2, 0.2],
    [0.3, -0.2, -0.2],
    [0.6, 0.15, -0.15],
    [0.6, -0.15, 0.15],
    [0.9, 0.3, 0.0],
    [0.9, -0.3, 0.0],
    [0.4, 0.0, 0.3],
    [0.4, 0.0, -0.3],
    [1.0, 0.5, 0.5],
    [1.0, -0.5, -0.5],
];
/// Number of further detours of that kind, from a sequence that fills their ranges evenly.
const MORE_BENDS: u32 = 40;
/// Largest distance aside of these, in strides.
const MORE_ASIDE: f64 = 0.8;
/// Steps of the sequence along its three axes: powers of the inverse of the root of x^4 = x + 1 (Roberts 2018, the R3 sequence).
const R3: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_1, 0.549_700_477_901_970_1];
/// Detours from the end of a cut: share of the way of the tip and of the heel.
const TILTS: [[f64; 2]; 6] = [[0.6, 0.4], [0.4, 0.6], [0.9, 0.5], [0.5, 0.9], [0.2, 0.7], [0.7, 0.2]];
/// A strip through a cut of one's own, from one side of it to the other, that meets it at half its length.
struct Crossing {
    /// Distance of its beginning behind the end of the cut, in strides.
    behind: f64,
    /// Distance of its end ahead of the end of the cut, in distances behind.
    ahead: f64,
    /// Distance of both to each side, in strides.
    aside: f64,
}

/// Strips through a cut, each tried in both directions. They pass the end of the cut on its other side, for an `ahead` of 0.25 by 0.6 of the distance aside:
/// vertices there are snapped to the cut from up to 0.02 of a cell away.
const CROSSINGS: [Crossing; 5] = [
    Crossing { behind: 1.0, ahead: 0.25, aside: 0.3 },
    Crossing { behind: 2.0, ahead: 0.25, aside: 0.3 },
    Crossing { behind: 2.0, ahead: 0.5, aside: 0.5 },
    Crossing { behind: 1.0, ahead: 0.25, aside: 0.15 },
    Crossing { behind: 3.0, ahead: 0.5, aside: 0.8 },
];
/// Distance of a new stroke behind the refused one, in strides.
const BEHIND: f64 = 0.2;
/// Distance from the last advance, in strides, from which a refused cut is begun again at the present position.
const RESTART_STRIDES: f64 = 4.0;

/// Cuts a solid to the blade `to` on another way than the straight one, which was refused. `stride` is in m. Returns how it came any farther; the stroke ends where it came to.
///
/// # Errors
/// Returns the error of the grid or material plugin.
pub fn go_around(
    body: &mut Body,
    stroke: &mut BodyStroke,
    to: &Blade,
    stride: f64,
    swept: &mut Swept,
) -> Result<Detoured, LatticeError> {
    let mut all = Detoured::Nowhere;
    if body.discretization.lattice().is_none() {
        return Ok(all);
    }
    let mut trials = MAX_TRIALS;
    for _ in 0..MAX_DETOURS {
        if stroke.stroke.blade() == *to {
            break;
        }
        let detoured = bend(body, stroke, to, stride, swept, &mut trials)?;
        if detoured == Detoured::Nowhere {
            break;
        }
        all = all.max(detoured);
    }
    Ok(all)
}

/// Makes the first detour that the mesh allows within the `trials` left, and goes on to `to` if it allows that too.
fn bend(
    body: &mut Body,
    stroke: &mut BodyStroke,
    to: &Blade,
    stride: f64,
    swept: &mut Swept,
    trials: &mut usize,
) -> Result<Detoured, LatticeError> {
    let (from, crumb) = (stroke.stroke.blade(), crumb_volume(stride));
    let detours = detours(stroke.middle, stroke.previous.as_ref(), &from, to, stride);
    for Detour { start, via } in detours {
        if *trials == 0 {
            break;
        }
        *trials -= 1;
        let Some(mesh) = &mut body.cut else { return Ok(Detoured::Nowhere) };
        let Ok(mut trial) = start.map_or_else(|| Ok(stroke.stroke.clone()), Stroke::begin) else { continue };
        let Ok(advance) = mesh.advance_cleanly(&mut trial, via, crumb) else { continue };
        (stroke.stroke, stroke.previous) = (trial, Some(start.unwrap_or(from)));
        let detoured = if start.is_some() { Detoured::Through } else { Detoured::Onward };
        swept.take(body, &advance)?;
        let Some(mesh) = &mut body.cut else { return Ok(detoured) };
        if let Ok(advance) = mesh.advance_cleanly(&mut stroke.stroke, *to, crumb) {
            stroke.previous = Some(via);
            swept.take(body, &advance)?;
        }
        return Ok(detoured);
    }
    Ok(Detoured::Nowhere)
}

/// The detours from one blade to another, in the order in which they are tried. `previous` is the blade before `from`.
fn detours(middle: Middle, previous: Option<&Blade>, from: &Blade, to: &Blade, stride: f64) -> Vec<Detour> {
    let way = middle.way(from, to);
    let Some(aside) = (from.heel - from.tip).cross(&way).try_normalize(0.0) else { return Vec::new() };
    let between =
        |tip: f64, heel: f64| Blade { tip: from.tip.lerp(&to.tip, tip), heel: from.heel.lerp(&to.heel, heel) };
    let bend = |[share, tip, heel]: [f64; 3]| {
        let blade = between(share, share);
        Blade { tip: blade.tip + tip * stride * aside, heel: blade.heel + heel * stride * aside }
    };
    let more = (1..=MORE_BENDS).map(|k| {
        let [share, tip, heel] = R3.map(|step| (f64::from(k) * step).fract());
        bend([0.3 + 0.7 * share, MORE_ASIDE * (2.0 * tip - 1.0), MORE_ASIDE * (2.0 * heel - 1.0)])
    });
    let tilts = TILTS.map(|[tip, heel]| between(tip, heel));
    let bends = BENDS.map(bend).into_iter().chain(tilts).chain(more).map(|via| Detour { start: None, via });
    // The strip runs beside the last one and beyond it, turned as that is: it goes through it all along the blade.
    let last = previous.map(|previous| (previous, travel(previous, from))).filter(|(_, length)| *length > 0.0);
    let crossings = last.into_iter().flat_map(|(previous, length)| {
        let on = |share: f64| Blade {
            tip: from.tip.lerp(&previous.tip, -share),
            heel: from.heel.lerp(&previous.heel, -share),
        };
        CROSSINGS.iter().flat_map(move |crossing| {
            let behind = (crossing.behind * stride / length).min(0.9);
            let ahead = (crossing.ahead * behind).min(travel(from, to) / length);
            [1.0, -1.0].map(|side| {
                let aside = side * crossing.aside * stride * aside;
                Detour { start: Some(on(-behind).moved(aside)), via: on(ahead).moved(-aside) }
            })
        })
    });
    bends.chain(crossings).collect()
}

/// Cuts on even if that leaves a bridge. A cut that cannot be continued at all begins anew just behind its end, and if that is refused too and the blade is
/// far away, where that is now: what lies between is not cut.
///
/// # Errors
/// Returns why the mesh refuses the advance from behind.
pub fn force(
    body: &mut Body,
    stroke: &mut BodyStroke,
    to: &Blade,
    stride: f64,
    heading: Vec3,
) -> Result<Advance, Refused> {
    let none = Refused { reason: Refusal::Invalid, entity: "mesh", value: 0.0 };
    let mesh = body.cut.as_mut().ok_or(none)?;
    let before = stroke.stroke.blade();
    if let Ok(advance) = mesh.advance(&mut stroke.stroke, *to) {
        stroke.previous = Some(before);
        return Ok(advance);
    }
    let behind = before.moved(-BEHIND * stride * heading);
    let mut again = Stroke::begin(behind)?;
    let advance = mesh.advance(&mut again, *to);
    if advance.is_ok() {
        (stroke.stroke, stroke.previous) = (again, Some(behind));
    } else if travel(&before, to) > RESTART_STRIDES * stride {
        (stroke.stroke, stroke.previous) = (Stroke::begin(*to)?, None);
    }
    advance
}
