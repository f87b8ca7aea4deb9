//! Sweeping of a body up to a blade: straight on, around what the mesh refuses, or with a bridge where there is no way around.

use super::body_stroke::{AlongSlit, BodyStroke, Bridge, travel};
use super::cut_step::AdvanceError;
use super::detour::{Detoured, force, go_around};
use super::knife::crumb_volume;
use super::slit::{Origin, Slit, Surroundings};
use super::stroke_end::is_outside;
use crate::body::{Body, Discretization, LatticeError};
use pliant_cut::{Advance, Blade, Refused, Stroke};
use pliant_solver::Vec3;

/// Where a body is cut up to.
pub struct SweepTarget {
    /// The blade in the rest shape, m.
    pub blade: Blade,
    /// Distance between advances, m.
    pub stride: f64,
    /// Unit vector of the cutting direction in the rest shape; zero before the first cut.
    pub heading: Vec3,
    /// Whether no longer strip will follow that a refused one could wait for.
    pub last: bool,
}

/// What several advances have cut together.
#[derive(Default)]
pub struct Swept {
    /// Cut area, m^2.
    pub area: f64,
    /// Cut length, m.
    pub length: f64,
    /// Whether the mesh changed.
    pub has_cut: bool,
}

/// Distance from the last advance, in strides, up to which a refused cut waits for the blade to move on.
const WAIT_STRIDES: f64 = 3.0;

/// Distances from a slit, in cell edges, between which a strip through its walls is tried.
const THROUGH: [f64; 3] = [0.05, 0.1, 0.2];
/// Shares of the way to a blade at which it is seen whether what it goes along with has an end there.
const ON_WAY: [f64; 2] = [0.35, 0.7];

/// A blade on the way from one to another.
pub(super) fn between(from: &Blade, to: &Blade, share: f64) -> Blade {
    Blade { tip: from.tip.lerp(&to.tip, share), heel: from.heel.lerp(&to.heel, share) }
}

impl Swept {
    /// Adds what was cut after it.
    fn add(&mut self, onward: &Self) {
        self.area += onward.area;
        self.length += onward.length;
        self.has_cut |= onward.has_cut;
    }

    /// Has the body adopt an advance of its mesh.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn take(&mut self, body: &mut Body, advance: &Advance) -> Result<(), LatticeError> {
        self.area += advance.area;
        self.length += advance.length;
        if !advance.has_cut() {
            return Ok(());
        }
        self.has_cut = true;
        body.take_cut(advance)
    }
}

impl BodyStroke {
    /// Cuts a body up to `to`, as far as its mesh allows. `None` if a refused strip waits for a longer one. If the material of a sheet refuses the cut elements,
    /// the sheet is as it was.
    ///
    /// # Errors
    /// Returns why the mesh refuses every strip, or the error of a plugin.
    pub fn sweep(&mut self, body: &mut Body, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let before = body.discretization.sheet().is_some().then(|| body.save());
        let swept = self.sweep_anyhow(body, to);
        if let (Err(AdvanceError::Failed(_)), Some(before)) = (&swept, &before) {
            body.restore(before).map_err(AdvanceError::Failed)?;
        }
        swept
    }

    fn sweep_anyhow(&mut self, body: &mut Body, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let (Some(mesh), Discretization::Lattice(lattice)) = (&body.cut, &body.discretization) else {
            return self.sweep_material(body, to);
        };
        // A seam that was stitched is cut again.
        if lattice.is_healed() {
            return self.sweep_material(body, to);
        }
        let (before, edge) = (self.stroke.blade(), lattice.edge());
        let origin = match &self.slit {
            Some(_) => Origin::Slit,
            None if self.previous.is_none() || is_outside(mesh, &before) => Origin::Air,
            None => Origin::Material,
        };
        let at = |blade: &Blade| Surroundings::of(mesh, origin, [&before, blade], self.middle, edge);
        let is_material = |share: &f64| matches!(at(&between(&before, &to.blade, *share)), Surroundings::Material);
        let cuts = matches!(origin, Origin::Material);
        let ends_before = !cuts && ON_WAY.iter().any(is_material);
        match (self.slit.take(), if ends_before { Surroundings::Material } else { at(&to.blade) }) {
            (Some(last), Surroundings::Material) => self.leave_slit(body, last, to),
            (None, Surroundings::Slit(slit)) if cuts => self.enter_slit(body, slit, to),
            (last, Surroundings::Slit(mut slit)) => {
                self.go_along(slit.blade)?;
                slit.behind = last.map_or(slit.blade, |last| last.blade);
                self.note_slit(&slit, last.map_or(0.0, |last| (slit.place - last.place).norm()));
                self.slit = Some(slit);
                Ok(Some(Swept::default()))
            }
            (Some(_), Surroundings::Air) => {
                self.go_along(to.blade)?;
                self.along.iter_mut().for_each(|along| along.has_left = true);
                Ok(Some(Swept::default()))
            }
            (None, _) => self.sweep_material(body, to),
        }
    }

    /// Notes that the blade is in a slit, in which it has gone `way` (m) since the last advance.
    fn note_slit(&mut self, slit: &Slit, way: f64) {
        let along = self.along.get_or_insert(AlongSlit { place: slit.place, way: 0.0, has_left: false });
        (along.way, along.has_left) = (along.way + way, false);
    }

    /// Goes to a blade without cutting.
    fn go_along(&mut self, blade: Blade) -> Result<(), AdvanceError> {
        self.stroke = Stroke::begin(blade).map_err(AdvanceError::Refused)?;
        self.previous = None;
        // Whether what it goes along with was cut right through is not known.
        self.section.iter_mut().for_each(|section| section.spans = false);
        Ok(())
    }

    /// Cuts up to a slit and through its wall.
    fn enter_slit(&mut self, body: &mut Body, slit: Slit, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let distance = THROUGH[0] * body.discretization.edge();
        let Some(mesh) = &body.cut else { return Ok(None) };
        let (way_in, mut all) = (slit.way_in(mesh, &self.stroke.blade(), distance, to.stride), Swept::default());
        if way_in.is_empty() {
            self.go_along(slit.blade)?;
            self.slit = Some(slit);
        }
        for blade in way_in {
            let Some(swept) = self.sweep_material(body, &SweepTarget { blade, ..*to })? else { break };
            all.add(&swept);
            // Where the mesh refuses the strip through the wall the cut goes on beside it.
            self.slit = (self.stroke.blade() == blade).then_some(slit);
            if self.slit.is_none() {
                break;
            }
        }
        self.section.iter_mut().for_each(|section| section.spans = false);
        if let Some(slit) = self.slit {
            self.note_slit(&slit, 0.0);
        }
        Ok(Some(all))
    }

    /// Cuts up to `to` from the slit that the blade was in, by a strip through its walls first.
    fn leave_slit(&mut self, body: &mut Body, slit: Slit, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let (mut swept, edge) = (Swept::default(), body.discretization.edge());
        self.go_along(slit.blade)?;
        for distance in THROUGH {
            let [start, via] = slit.strip_through(&to.blade, distance * edge);
            let (Ok(mut trial), Some(mesh)) = (Stroke::begin(start), &mut body.cut) else { continue };
            if let Ok(advance) = mesh.advance_cleanly(&mut trial, via, crumb_volume(to.stride)) {
                (self.stroke, self.previous) = (trial, Some(start));
                swept.take(body, &advance).map_err(AdvanceError::Failed)?;
                break;
            }
        }
        if !swept.has_cut {
            self.bridge.get_or_insert(Bridge { place: self.middle.on(&slit.blade), width: to.stride });
        }
        if let Some(onward) = self.sweep_material(body, to)? {
            swept.add(&onward);
        }
        Ok(Some(swept))
    }

    /// Cuts up to `to` through material.
    fn sweep_material(&mut self, body: &mut Body, to: &SweepTarget) -> Result<Option<Swept>, AdvanceError> {
        let Some(mesh) = &mut body.cut else { return Ok(None) };
        let before = self.stroke.blade();
        let is_solid = body.discretization.lattice().is_some();
        // A blade that is held by its resistance turns with the hand all the same, and may go back on one side of the body.
        let front = || mesh.front(&before, &to.blade, self.middle.on(&before), to.heading);
        let blade = if is_solid { front() } else { to.blade };
        let to = &SweepTarget { blade, ..*to };
        // Elements of a sheet are its triangles: what does not meet the end of a cut there is seen to by wider snapping.
        let straight = match &body.discretization {
            Discretization::Lattice(_) => mesh.advance_cleanly(&mut self.stroke, to.blade, crumb_volume(to.stride)),
            Discretization::Sheet(_) => mesh.advance(&mut self.stroke, to.blade),
        };
        let mut swept = Swept::default();
        match straight {
            Ok(advance) => {
                self.previous = Some(before);
                swept.take(body, &advance).map_err(AdvanceError::Failed)?;
            }
            // A longer strip is often cut where this one would leave a sliver.
            Err(_) if !to.last && travel(&before, &to.blade) < WAIT_STRIDES * to.stride => return Ok(None),
            Err(refused) => self.sweep_around(body, to, refused, &mut swept)?,
        }
        Ok(Some(swept))
    }

    /// Cuts up to `to` where the straight strip is `refused`, and remembers the first place where that may have left a bridge.
    fn sweep_around(
        &mut self,
        body: &mut Body,
        to: &SweepTarget,
        refused: Refused,
        swept: &mut Swept,
    ) -> Result<(), AdvanceError> {
        let before = self.stroke.blade();
        let bridge = Bridge { place: self.middle.on(&before), width: to.stride };
        match go_around(body, self, &to.blade, to.stride, swept).map_err(AdvanceError::Failed)? {
            Detoured::Onward => return Ok(()),
            Detoured::Through => {}
            Detoured::Nowhere => match force(body, self, &to.blade, to.stride, to.heading) {
                Ok(advance) => swept.take(body, &advance).map_err(AdvanceError::Failed)?,
                Err(_) => {
                    let width = travel(&before, &self.stroke.blade());
                    if width > 0.0 {
                        self.bridge.get_or_insert(Bridge { width, ..bridge });
                    }
                    return Err(AdvanceError::Refused(refused));
                }
            },
        }
        self.bridge.get_or_insert(bridge);
        Ok(())
    }
}
