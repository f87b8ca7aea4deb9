//! The end of a stroke: what was drawn right through a body is cut through, or it is said what holds.
//!
//! While a hand draws, the blade lags behind it by the cutting resistance over the stiffness of the coupling, and the body gives way. Where the hand
//! stops, both would leave a neck: the resistance is that of the last advance, wider than the neck, and the surface springs back behind
//! the blade. So the blade first moves on against the resistance of what is left until the hand no longer pulls with more. Then, if it has come out of
//! the shape that the body had when the stroke began, it cuts up to there in the rest shape, if that is not farther than it has cut by itself.

use super::body_stroke::{BodyStroke, Section, euler_characteristic};
use super::cut_step::{CutAgain, CutStep, HeldBody};
use super::knife::{Knife, RotatedBlade, STRIDE};
use crate::body::{Body, LatticeError};
use crate::tool::Hand;
use nalgebra::Matrix3;
use pliant_cut::{Blade, CutMesh};
use pliant_solver::Vec3;

/// Most moves of a blade until it rests at the end of a stroke: all of them are in one step, and each is an advance. They are of a stride, or longer if the hand is
/// farther away than that many strides.
const MAX_MOVES: usize = 48;
/// A blade rests if it moves by less than this, in strides.
const AT_REST: f64 = 1e-3;

impl Knife {
    /// Finishes what was drawn through solids, after the last advance of the stroke.
    ///
    /// # Errors
    /// Returns the error of a plugin.
    pub(super) fn finish(
        &mut self,
        hand: &Hand,
        stiffness: f64,
        bodies: &mut [Body],
        step: &mut CutStep,
    ) -> Result<(), LatticeError> {
        let along = hand.rotation * self.edge.direction;
        self.come_to_rest(hand, &along, stiffness, bodies, step)?;
        step.again = self.strokes.iter().enumerate().find_map(|(body, stroke)| {
            let stroke = stroke.as_ref().filter(|stroke| stroke.was_cut)?;
            let along = stroke.along.filter(|along| along.has_left || stroke.way == 0.0)?;
            Some(CutAgain { body, place: along.place, way: along.way })
        });
        for (index, body) in bodies.iter_mut().enumerate() {
            let Some(stroke) = self.strokes[index].as_ref().filter(|stroke| stroke.way > 0.0) else { continue };
            let (drift, way, cut, middle) = (stroke.drift, stroke.way, stroke.stroke.blade(), stroke.middle);
            let drawn = |tip: Vec3| Blade { tip: tip - drift, heel: tip + self.edge.length * along - drift };
            let (reached, asked) = (drawn(self.tip), drawn(hand.position));
            if body.frozen.is_some() || body.discretization.lattice().is_none() {
                continue;
            }
            if !self.is_in(index, body, &asked) {
                self.report_bridge(index, body, &asked, step);
                continue;
            }
            // A body that the blade has pushed away more than it has cut is not severed.
            let is_neck = middle.way(&cut, &reached).norm() <= way;
            if is_neck && body.cut.as_ref().is_some_and(|mesh| is_outside(mesh, &reached)) {
                let advanced =
                    self.advance(index, RotatedBlade { blade: reached, rotation: Matrix3::identity() }, body, true);
                step.add(index, advanced)?;
            }
            if self.is_in(index, body, &asked)
                && let (Some(mesh), Some(stroke)) = (&body.cut, &self.strokes[index])
                && is_outside(mesh, &asked)
            {
                step.held = Some(self.held(index, stroke, &asked, stiffness * (hand.position - self.tip).norm()));
            }
        }
        Ok(())
    }

    /// Says where a neck is left by a cut that the mesh did not allow without a bridge, or that the blade was drawn right through without parting a
    /// cross-section.
    fn report_bridge(&self, index: usize, body: &Body, asked: &Blade, step: &mut CutStep) {
        let (Some(stroke), Some(mesh)) = (&self.strokes[index], &body.cut) else { return };
        if !is_outside(mesh, asked) {
            return;
        }
        let bridge = stroke.bridge.filter(|_| stroke.has_joined_walls(mesh));
        let is_whole = |section: &Section| section.spans && euler_characteristic(mesh.surface()) < section.euler + 2;
        let found = bridge.map(|bridge| (bridge.place, bridge.width));
        let found = found.or_else(|| stroke.section.filter(is_whole).map(|section| (section.place, stroke.way)));
        if let Some((place, width)) = found {
            step.held = Some(HeldBody { body: index, place, width, resistance: 0.0, pull: 0.0 });
        }
    }

    /// Moves the blade towards the hand until that pulls with no more than the resistance of what is left.
    fn come_to_rest(
        &mut self,
        hand: &Hand,
        along: &Vec3,
        stiffness: f64,
        bodies: &mut [Body],
        step: &mut CutStep,
    ) -> Result<(), LatticeError> {
        let shortest = (hand.position - self.tip).norm() / MAX_MOVES as f64;
        for _ in 0..MAX_MOVES {
            let Some(edge) = self.inside.as_ref().map(|inside| bodies[inside.body as usize].discretization.edge())
            else {
                return Ok(());
            };
            let before = self.tip;
            self.pull(hand, along, stiffness);
            let moved = self.tip - before;
            if moved.norm() <= AT_REST * STRIDE * edge {
                return Ok(());
            }
            // What the next stride resists with is known once it is cut.
            let moved = ((STRIDE * edge).max(shortest) / moved.norm()).min(1.0) * moved;
            self.tip = before + moved;
            let (mut resistance, mut is_in) = (None, false);
            for (index, body) in bodies.iter_mut().enumerate() {
                if body.frozen.is_some() || body.discretization.lattice().is_none() {
                    continue;
                }
                // Cells are cut, and nodes follow after the step: displacements are those of the last map to the rest shape.
                let Some(stroke) = &self.strokes[index] else { continue };
                let blade = stroke.mapped.moved(moved);
                let advanced = self.advance(index, RotatedBlade { blade, rotation: Matrix3::identity() }, body, true);
                let advances = step.advances;
                if let Some(force) = step.add(index, advanced)?
                    && step.advances > advances
                {
                    resistance = Some(resistance.unwrap_or(0.0_f64).max(force));
                }
                is_in |= self.is_in(index, body, &blade.moved(self.heading.unwrap_or_default()));
            }
            if !is_in {
                self.leave();
                return Ok(());
            }
            self.resistance = resistance.unwrap_or(self.resistance);
        }
        Ok(())
    }

    /// Whether there is material just ahead of where a stroke has cut up to, on its way to a blade in the rest shape.
    fn is_in(&self, index: usize, body: &Body, to: &Blade) -> bool {
        let (Some(stroke), Some(mesh)) = (&self.strokes[index], &body.cut) else { return false };
        let cut = stroke.stroke.blade();
        let ahead = stroke.middle.way(&cut, to).try_normalize(0.0).unwrap_or_default();
        !is_outside(mesh, &cut.moved(AT_REST * STRIDE * body.discretization.edge() * ahead))
    }

    fn held(&self, index: usize, stroke: &BodyStroke, asked: &Blade, pull: f64) -> HeldBody {
        let cut = stroke.stroke.blade();
        let place = self
            .inside
            .as_ref()
            .filter(|inside| inside.body as usize == index)
            .map_or_else(|| stroke.middle.on(&cut), |inside| inside.points[inside.points.len() / 2]);
        let width = stroke.middle.way(&cut, asked).norm();
        HeldBody { body: index, place, width, resistance: self.resistance, pull }
    }
}

/// Whether a blade in the rest shape passes through nothing of a body.
pub(super) fn is_outside(mesh: &CutMesh, blade: &Blade) -> bool {
    !mesh.is_crossed(blade.tip, blade.heel) && !mesh.encloses(blade.tip)
}
