//! The contact state of a constrained vertex, and how it changes: stick, slide, release.
//!
//! A solve whose outcome changes the active set is not the last of its step and need not converge: it is stopped as soon as every change is
//! certain.

use super::fingertip::Tip;
use pliant_solver::{System, TrialStep, Vec3};

/// A vertex in contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// Index of the vertex's node.
    pub node: u32,
    /// Index of the tip, and of a second one in a pinch.
    pub tips: (usize, Option<usize>),
    /// Unit normal out of the tip.
    pub normal: Vec3,
    /// Unit normal out of the second tip.
    pub other: Vec3,
    /// Prescribed velocities along the normals, m/s.
    pub target: [f64; 2],
    /// Velocity along the first normal with which a vertex bounces off, m/s.
    pub rebound: f64,
    /// Contact state.
    pub state: State,
    /// Whether it stuck in the previous step.
    pub stuck_before: bool,
    /// It was caught on its way, and is not released in the same step.
    pub caught: bool,
    /// Friction while it slides, N.
    pub friction: Vec3,
    /// It sticks again in this step, because it slid the way friction pushed it.
    pub returned: bool,
}

/// Contact state of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// Moves with the tip.
    Sticks,
    /// Slides along the tip, with friction.
    Slides,
    /// Released in this step.
    Free,
}

/// Whether something changes and every change is certain. All must be: a change without another that belongs to the same step would be made
/// in vain.
pub(super) fn is_settled(mut next: impl Iterator<Item = Option<(Held, bool)>>) -> bool {
    let mut changes = false;
    next.all(|next| {
        changes |= next.is_some();
        next.is_none_or(|(_, certain)| certain)
    }) && changes
}

/// Largest relative error bound of a normal force from which friction is computed.
const MAX_FORCE_ERROR: f64 = 0.1;

impl Held {
    /// The next state under a trial step, if it changes, and whether the change is certain.
    pub fn judge(&self, tip: &Tip, system: &System, trial: &TrialStep<'_>) -> Option<(Self, bool)> {
        let node = self.node as usize;
        let off = |u: Vec3| trial.error_bound.map_or([0.0; 2], |bound| bound(system, node, u));
        let slip = (trial.velocity)(system, node) - tip.velocity_at(system.nodes.x[node]);
        self.next(tip, (trial.reaction)(node), slip, &off)
    }

    /// The same for a constraint force `lambda`, N, and a velocity relative to the tip, `slip`, m/s; `off` bounds the errors of both along a
    /// direction.
    fn next(&self, tip: &Tip, lambda: Vec3, slip: Vec3, off: &dyn Fn(Vec3) -> [f64; 2]) -> Option<(Self, bool)> {
        if self.caught || self.state == State::Free {
            return None;
        }
        // A pinch is pushed from both sides: it is held by whichever pushes.
        let (pushes, pushes_off) = match self.tips.1 {
            None => (lambda.dot(&self.normal), off(self.normal)[0]),
            Some(_) => {
                let (a, b) = (lambda.dot(&self.normal), lambda.dot(&self.other));
                let most = if self.normal.dot(&self.other) < 0.0 { a.abs().max(b.abs()) } else { a.max(b) };
                (most, off(self.normal)[0].max(off(self.other)[0]))
            }
        };
        let sticks = self.state == State::Sticks && self.tips.1.is_none();
        let along = lambda - pushes * self.normal;
        let size = along.norm();
        let along_off = || if size > 0.0 { off(along / size)[0] } else { 0.0 };
        if pushes < 0.0 {
            // What pulls may be what keeps it from sliding, in a taut sheet: then it is let slide first.
            let state = if sticks && size > -pushes { State::Slides } else { State::Free };
            let known = !sticks || (size + pushes).abs() >= pushes_off + along_off();
            return Some((Self { state, ..*self }, pushes < -pushes_off && known));
        }
        if self.tips.1.is_some() {
            return None;
        }
        if sticks {
            let most = if self.stuck_before { tip.friction.fixed } else { tip.friction.sliding };
            (size > most * pushes).then(|| {
                let is_more = size - along_off() > most * (pushes + pushes_off);
                let certain = is_more && pushes_off <= MAX_FORCE_ERROR * pushes;
                let friction = tip.friction.sliding * pushes / size * along;
                (Self { state: State::Slides, friction, ..*self }, certain)
            })
        } else if !self.returned {
            let with = slip.dot(&self.friction);
            // Friction does not push: where it would, the vertex sticks.
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
    use crate::contact::Friction;
    use crate::shape::OrientedShape;

    const NOTHING: Vec3 = Vec3::new(0.0, 0.0, 0.0);

    fn tip() -> Tip {
        Tip {
            position: NOTHING,
            velocity: NOTHING,
            spin: NOTHING,
            shape: OrientedShape::sphere(8e-3),
            friction: Friction { fixed: 0.5, sliding: 0.4 },
            restitution: 0.0,
            holds: true,
            force: NOTHING,
            held: 0,
        }
    }

    const HELD: Held = Held {
        node: 0,
        tips: (0, None),
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

    /// What it comes to, and whether that is certain, where reaction and velocity are off by at most each of `errors`.
    fn next<const N: usize>(held: Held, lambda: Vec3, after: Vec3, errors: [f64; N]) -> [Option<(State, bool)>; N] {
        errors
            .map(|error| held.next(&tip(), lambda, after, &|_| [error; 2]).map(|(held, certain)| (held.state, certain)))
    }

    #[test]
    fn what_changes_is_certain_where_it_is_more_than_the_doubt() {
        let (free, slides, sticks) = (State::Free, State::Slides, State::Sticks);
        assert_eq!(next(HELD, Vec3::z(), Vec3::zeros(), [0.0, 2.0]), [None; 2], "what is pushed stays");
        let pulled = next(HELD, Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), [0.0, 0.99, 1.01]);
        assert_eq!(pulled, [true, true, false].map(|certain| Some((free, certain))));
        // It may be pulled less, and be let slide.
        assert_eq!(next(HELD, Vec3::new(0.9, 0.0, -1.0), Vec3::zeros(), [0.06]), [Some((free, false))]);
        let taut = next(HELD, Vec3::new(3.1, 0.0, -1.0), Vec3::zeros(), [0.0, 0.99, 1.06]);
        assert_eq!(taut, [true, true, false].map(|certain| Some((slides, certain))), "friction may be what pulls");
        assert_eq!(
            next(Held { state: slides, ..HELD }, Vec3::new(1.1, 0.0, -1.0), Vec3::zeros(), [0.0]),
            [Some((free, true))]
        );
        // Of 1 N a half sticks. Both may be off; and friction follows from what pushes, which has to be known to a tenth.
        let torn = next(HELD, Vec3::new(0.6, 0.0, 1.0), Vec3::zeros(), [0.0, 0.06, 0.07]);
        assert_eq!(torn, [true, true, false].map(|certain| Some((slides, certain))));
        assert_eq!(
            next(HELD, Vec3::new(5.0, 0.0, 1.0), Vec3::zeros(), [0.09, 0.11]),
            [Some((slides, true)), Some((slides, false))]
        );
        let (held, _) = HELD.next(&tip(), Vec3::new(0.6, 0.0, 1.0), Vec3::zeros(), &|_| [0.0; 2]).unwrap();
        assert_eq!(held.friction, Vec3::new(0.4, 0.0, 0.0));
        assert_eq!(next(held, Vec3::z(), Vec3::new(-1.0, 0.0, 0.0), [0.0]), [None], "it goes on sliding");
        let back = next(held, Vec3::z(), Vec3::new(0.1, 0.0, 0.0), [0.0, 0.09, 0.11]);
        assert_eq!(back, [true, true, false].map(|certain| Some((sticks, certain))));
        let pinched = Held { tips: (0, Some(1)), other: Vec3::new(0.0, 0.6, 0.8), ..HELD };
        assert_eq!(
            next(pinched, Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), [0.7, 0.9]),
            [Some((free, true)), Some((free, false))]
        );
        let all = |of: &[Option<bool>]| is_settled(of.iter().map(|certain| certain.map(|certain| (HELD, certain))));
        assert!(all(&[None, Some(true), Some(true)]) && !all(&[Some(true), None, Some(false)]) && !all(&[None, None]));
        for settled in [Held { state: free, ..HELD }, Held { caught: true, ..HELD }] {
            assert_eq!(next(settled, Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), [0.0]), [None]);
        }
    }
}
