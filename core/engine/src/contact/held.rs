//! The contact state of a constrained vertex and its transitions: stick, slide, release.
//!
//! A solve that changes the active set is followed by another one in the same step, so it need not converge: it is stopped as soon as every
//! change is certain within the solver's error bound.

use super::proxy::Friction;
use pliant_solver::{System, TrialStep, Vec3};

/// The tips or obstacles that a node touches, by their indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touched {
    /// Index of the tip or obstacle.
    pub first: usize,
    /// Index of the second one, if the node is pinched by two tips or lies between two obstacles.
    pub second: Option<usize>,
}

impl Touched {
    /// A single tip or obstacle.
    pub fn one(first: usize) -> Self {
        Self { first, second: None }
    }
}

/// A vertex in contact with one tip, or pinched by two.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertexContact {
    /// Index of the vertex's node.
    pub node: u32,
    /// The tip or obstacle, and the second one if there are two.
    pub touched: Touched,
    /// Unit outward normal of the tip.
    pub normal: Vec3,
    /// Unit outward normal of the second tip; zero without one.
    pub other: Vec3,
    /// Prescribed velocities along the two normals, m/s.
    pub target: [f64; 2],
    /// Normal velocity after a bounce, relative to the tip, m/s; 0 without a bounce.
    pub rebound: f64,
    /// Whether the contact sticks, slides or is open.
    pub state: State,
    /// Whether it stuck in the previous step, so that the static coefficient of friction applies.
    pub stuck_before: bool,
    /// Whether continuous collision detection found it; it is then not released in the same step.
    pub caught: bool,
    /// Friction force while it slides, N.
    pub friction: Vec3,
    /// Whether it has returned from sliding to sticking in this step; it does so at most once.
    pub returned: bool,
}

/// Contact state of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// Moves with the tip.
    Sticks,
    /// Slides along the tip with friction; only its normal velocity is prescribed.
    Slides,
    /// Released in this step.
    Free,
}

/// Whether at least one contact changes its state and every change is certain. `next` holds, for each contact, its next state and whether that
/// is certain, or `None` if the state stays. All changes are needed: a solve with only some of them would have to be repeated.
pub(super) fn is_settled(mut next: impl Iterator<Item = Option<(VertexContact, bool)>>) -> bool {
    let mut changes = false;
    next.all(|next| {
        changes |= next.is_some();
        next.is_none_or(|(_, certain)| certain)
    }) && changes
}

/// Approach speed below which a vertex does not bounce, m/s.
pub(super) const MIN_REBOUND_SPEED: f64 = 0.02;
/// Largest relative error of a normal force that friction may be computed from.
const MAX_FORCE_ERROR: f64 = 0.1;

impl VertexContact {
    /// The contact after a state transition under a trial step and whether the transition is certain; `None` if the state stays. The other
    /// surface has these coefficients of friction and moves at `drive` (m/s) at the vertex.
    pub fn transition(
        &self,
        friction: Friction,
        drive: Vec3,
        system: &System,
        trial: &TrialStep<'_>,
    ) -> Option<(Self, bool)> {
        let node = self.node as usize;
        let off = |u: Vec3| trial.error_bound.map_or([0.0; 2], |bound| bound(system, node, u));
        let slip = (trial.velocity)(system, node) - drive;
        self.next(friction, (trial.reaction)(node), slip, &off)
    }

    /// Friction of a sliding vertex of `mass` (kg) in the next step of `dt` (s), N, from its normal force in `reaction` (N) and its velocity `slip`
    /// relative to the other surface (m/s); `None` if it would accelerate the vertex, which then sticks. The direction turns towards the slip no
    /// faster than the vertex's inertia allows; otherwise a light vertex of a taut sheet would oscillate across its path.
    pub fn next_friction(&self, friction: Friction, reaction: Vec3, slip: Vec3, mass: f64, dt: f64) -> Option<Vec3> {
        let slip = slip - slip.dot(&self.normal) * self.normal;
        let (speed, push) = (slip.norm(), reaction.dot(&self.normal).max(0.0));
        if slip.dot(&self.friction) > 0.0 || speed == 0.0 {
            return None;
        }
        let (limit, norm) = (friction.kinetic_coefficient * push, self.friction.norm());
        let turned = if norm > 0.0 { limit / norm * self.friction } else { Vec3::zeros() };
        let turned = turned - mass / dt * slip;
        Some(limit / turned.norm() * turned)
    }

    /// Transition for the constraint force `lambda` (N) and the velocity `slip` relative to the tip (m/s). `off` bounds the errors of both, in
    /// this order, along a unit vector.
    fn next(
        &self,
        friction: Friction,
        lambda: Vec3,
        slip: Vec3,
        off: &dyn Fn(Vec3) -> [f64; 2],
    ) -> Option<(Self, bool)> {
        if self.caught || self.state == State::Free {
            return None;
        }
        // A pinched vertex stays constrained while either tip pushes it.
        let (pushes, pushes_off) = match self.touched.second {
            None => (lambda.dot(&self.normal), off(self.normal)[0]),
            Some(_) => {
                let (a, b) = (lambda.dot(&self.normal), lambda.dot(&self.other));
                let most = if self.normal.dot(&self.other) < 0.0 { a.abs().max(b.abs()) } else { a.max(b) };
                (most, off(self.normal)[0].max(off(self.other)[0]))
            }
        };
        let sticks = self.state == State::Sticks && self.touched.second.is_none();
        let along = lambda - pushes * self.normal;
        let size = along.norm();
        let along_off = || if size > 0.0 { off(along / size)[0] } else { 0.0 };
        if pushes < 0.0 {
            // In a taut sheet a pulling normal force can come from the tangential constraint, so the vertex is first allowed to slide.
            let state = if sticks && size > -pushes { State::Slides } else { State::Free };
            let known = !sticks || (size + pushes).abs() >= pushes_off + along_off();
            return Some((Self { state, ..*self }, pushes < -pushes_off && known));
        }
        if self.touched.second.is_some() {
            return None;
        }
        if sticks {
            let most = if self.stuck_before { friction.static_coefficient } else { friction.kinetic_coefficient };
            (size > most * pushes).then(|| {
                let is_more = size - along_off() > most * (pushes + pushes_off);
                let certain = is_more && pushes_off <= MAX_FORCE_ERROR * pushes;
                let friction = friction.kinetic_coefficient * pushes / size * along;
                (Self { state: State::Slides, friction, ..*self }, certain)
            })
        } else if !self.returned {
            let with = slip.dot(&self.friction);
            // Friction opposes the slip; a friction force along the slip means that the vertex sticks.
            (with > 0.0).then(|| {
                let certain = with > off(self.normal)[1] * self.friction.norm();
                (Self { state: State::Sticks, friction: Vec3::zeros(), returned: true, ..*self }, certain)
            })
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOTHING: Vec3 = Vec3::new(0.0, 0.0, 0.0);

    const FRICTION: Friction = Friction { static_coefficient: 0.5, kinetic_coefficient: 0.4 };

    const HELD: VertexContact = VertexContact {
        node: 0,
        touched: Touched { first: 0, second: None },
        normal: Vec3::new(0.0, 0.0, 1.0),
        other: NOTHING,
        target: [0.0; 2],
        rebound: 0.0,
        state: State::Sticks,
        stuck_before: true,
        caught: false,
        friction: NOTHING,
        returned: false,
    };

    /// Next state and whether it is certain, for each of these error bounds of reaction and velocity.
    fn next<const N: usize>(
        held: VertexContact,
        lambda: Vec3,
        after: Vec3,
        errors: [f64; N],
    ) -> [Option<(State, bool)>; N] {
        errors.map(|error| {
            held.next(FRICTION, lambda, after, &|_| [error; 2]).map(|(held, certain)| (held.state, certain))
        })
    }

    #[test]
    fn a_transition_is_certain_if_it_exceeds_the_error_bound() {
        let (free, slides, sticks) = (State::Free, State::Slides, State::Sticks);
        assert_eq!(next(HELD, Vec3::z(), Vec3::zeros(), [0.0, 2.0]), [None; 2], "a pushed vertex stays");
        let pulled = next(HELD, Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), [0.0, 0.99, 1.01]);
        assert_eq!(pulled, [true, true, false].map(|certain| Some((free, certain))));
        // Within the error bound the pull may be smaller than the tangential force, which would lead to sliding.
        assert_eq!(next(HELD, Vec3::new(0.9, 0.0, -1.0), Vec3::zeros(), [0.06]), [Some((free, false))]);
        let taut = next(HELD, Vec3::new(3.1, 0.0, -1.0), Vec3::zeros(), [0.0, 0.99, 1.06]);
        assert_eq!(
            taut,
            [true, true, false].map(|certain| Some((slides, certain))),
            "the tangential constraint may cause the pull"
        );
        assert_eq!(
            next(VertexContact { state: slides, ..HELD }, Vec3::new(1.1, 0.0, -1.0), Vec3::zeros(), [0.0]),
            [Some((free, true))]
        );
        // At 1 N normal force, 0.5 N is the static limit. Both forces have errors, and friction needs the normal force to 10 %.
        let torn = next(HELD, Vec3::new(0.6, 0.0, 1.0), Vec3::zeros(), [0.0, 0.06, 0.07]);
        assert_eq!(torn, [true, true, false].map(|certain| Some((slides, certain))));
        assert_eq!(
            next(HELD, Vec3::new(5.0, 0.0, 1.0), Vec3::zeros(), [0.09, 0.11]),
            [Some((slides, true)), Some((slides, false))]
        );
        let (held, _) = HELD.next(FRICTION, Vec3::new(0.6, 0.0, 1.0), Vec3::zeros(), &|_| [0.0; 2]).unwrap();
        assert_eq!(held.friction, Vec3::new(0.4, 0.0, 0.0));
        assert_eq!(next(held, Vec3::z(), Vec3::new(-1.0, 0.0, 0.0), [0.0]), [None], "it keeps sliding");
        let back = next(held, Vec3::z(), Vec3::new(0.1, 0.0, 0.0), [0.0, 0.09, 0.11]);
        assert_eq!(back, [true, true, false].map(|certain| Some((sticks, certain))));
        let pinched =
            VertexContact { touched: Touched { first: 0, second: Some(1) }, other: Vec3::new(0.0, 0.6, 0.8), ..HELD };
        assert_eq!(
            next(pinched, Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), [0.7, 0.9]),
            [Some((free, true)), Some((free, false))]
        );
        let all = |of: &[Option<bool>]| is_settled(of.iter().map(|certain| certain.map(|certain| (HELD, certain))));
        assert!(all(&[None, Some(true), Some(true)]) && !all(&[Some(true), None, Some(false)]) && !all(&[None, None]));
        for settled in [VertexContact { state: free, ..HELD }, VertexContact { caught: true, ..HELD }] {
            assert_eq!(next(settled, Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), [0.0]), [None]);
        }
    }
}
