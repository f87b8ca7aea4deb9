//! The motion of the two fingertips: along a path, rigidly or pushed away from it by the rendered force.

use pliant_exoskeleton::wire::{EFFECTOR_COUNT, FINGER_SENSED, FINGER_VELOCITY, FingerState};

/// A vector for each fingertip: index, then thumb.
type FingertipVectors = [[f64; 3]; EFFECTOR_COUNT];

/// Longest step of the integration of [`HandModel::Simulated`], s.
const MAX_STEP: f64 = 2.5e-4;

/// Orientations of the fingertips, quaternions x y z w: the pads face each other along z, so the thumb is turned by half a turn about y.
const ORIENTATIONS: [[f64; 4]; EFFECTOR_COUNT] = [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]];

/// Positions of the fingertips at one time.
#[derive(Clone, Copy, Debug)]
struct Keyframe {
    /// s
    time: f64,
    /// m
    positions: FingertipVectors,
}

/// A path of both fingertips, piecewise linear in time.
#[derive(Clone, Debug)]
pub struct FingerPath {
    /// At least one, with ascending times.
    keyframes: Vec<Keyframe>,
}

impl Default for FingerPath {
    /// A pinch: index and thumb close along z, then move sideways. The tips have a radius of 8 mm in the scenes; they close to 13 mm, so
    /// that they overlap by 3 mm and hold a cloth between them everywhere, not only where one of its vertices lies on the axis.
    fn default() -> Self {
        let keyframe =
            |time, x: f64, half_gap: f64| Keyframe { time, positions: [[x, 0.0, half_gap], [x, 0.0, -half_gap]] };
        Self { keyframes: vec![keyframe(0.0, 0.0, 0.012), keyframe(0.4, 0.0, 0.0065), keyframe(1.0, 0.01, 0.0065)] }
    }
}

impl FingerPath {
    /// Parses rows of `time,x,y,z,x,y,z` in s and m: the positions of index and thumb. Empty lines and lines that begin with `#` are
    /// skipped.
    ///
    /// # Errors
    /// If a row has another format or times do not ascend; the message names the line. If there is no row.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut keyframes: Vec<Keyframe> = Vec::new();
        for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#')) {
            let row: Vec<f64> = line.split(',').map_while(|c| c.trim().parse().ok()).collect();
            let ascends = |time: f64| keyframes.last().is_none_or(|last| time > last.time);
            match row[..] {
                [time, x0, y0, z0, x1, y1, z1] if row.iter().all(|n| n.is_finite()) && ascends(time) => {
                    keyframes.push(Keyframe { time, positions: [[x0, y0, z0], [x1, y1, z1]] });
                }
                _ => {
                    let allowed = "time,x,y,z,x,y,z in s and m, with ascending times";
                    return Err(format!("line {}: `{line}`; allowed is {allowed}", i + 1));
                }
            }
        }
        if keyframes.is_empty() { Err("no keyframe in it".into()) } else { Ok(Self { keyframes }) }
    }

    /// Positions of the fingertips at a time (s), m: linear between keyframes, constant before the first and after the last.
    pub fn positions(&self, time: f64) -> FingertipVectors {
        let after = self.keyframes.partition_point(|k| k.time <= time);
        match (after.checked_sub(1), self.keyframes.get(after)) {
            (None, _) => self.keyframes[0].positions,
            (Some(before), None) => self.keyframes[before].positions,
            (Some(before), Some(to)) => {
                let from = &self.keyframes[before];
                let s = (time - from.time) / (to.time - from.time);
                std::array::from_fn(|finger| {
                    std::array::from_fn(|axis| {
                        let (a, b) = (from.positions[finger][axis], to.positions[finger][axis]);
                        a + s * (b - a)
                    })
                })
            }
        }
    }
}

/// How a fingertip follows its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandModel {
    /// Exactly, whatever force is rendered.
    Keyframed,
    /// As a mass that a spring and a damper pull along the path and that the rendered force pushes away from it.
    Simulated {
        /// Effective mass of the fingertip and what moves with it, kg.
        mass: f64,
        /// Stiffness of the spring to the path, N/m.
        stiffness: f64,
        /// Damping of the velocity relative to the path, N s/m.
        damping: f64,
    },
}

/// Both fingertips in motion.
pub struct Fingers {
    path: FingerPath,
    hand: HandModel,
    /// m; 0 for unquantised positions.
    position_quantum: f64,
    /// m
    positions: FingertipVectors,
    /// m/s
    velocities: FingertipVectors,
    /// s since the start of the path
    time: f64,
}

impl Fingers {
    /// Fingertips at rest at the start of a path. The sensors report positions in multiples of `position_quantum` (m).
    pub fn new(path: FingerPath, hand: HandModel, position_quantum: f64) -> Self {
        let positions = path.positions(0.0);
        Self { path, hand, position_quantum, positions, velocities: [[0.0; 3]; EFFECTOR_COUNT], time: 0.0 }
    }

    /// Advances the motion by `dt` (s) under the rendered `forces` (N).
    pub fn advance(&mut self, dt: f64, forces: &FingertipVectors) {
        if dt <= 0.0 {
            return;
        }
        // The upper bound limits the work after the process was suspended for long.
        let steps = (dt / MAX_STEP).ceil().clamp(1.0, 1e4);
        let h = dt / steps;
        for _ in 0..steps as usize {
            let old_target = self.path.positions(self.time);
            self.time += h;
            let new_target = self.path.positions(self.time);
            for finger in 0..EFFECTOR_COUNT {
                for axis in 0..3 {
                    let (position, velocity) = (&mut self.positions[finger][axis], &mut self.velocities[finger][axis]);
                    let target = new_target[finger][axis];
                    let target_velocity = (target - old_target[finger][axis]) / h;
                    match self.hand {
                        HandModel::Keyframed => (*position, *velocity) = (target, target_velocity),
                        HandModel::Simulated { mass, stiffness, damping } => {
                            let force =
                                forces[finger][axis] + stiffness * (target - *position) + damping * target_velocity;
                            // Symplectic Euler with implicit damping, which is stable for any damping.
                            *velocity = (*velocity + h / mass * force) / (1.0 + h * damping / mass);
                            *position += h * *velocity;
                        }
                    }
                }
            }
        }
    }

    /// What the sensors report. The rendered forces in it are 0.
    pub fn sensed(&self) -> [FingerState; EFFECTOR_COUNT] {
        let quantum = self.position_quantum;
        let quantised = |c: f64| if quantum > 0.0 { (c / quantum).round() * quantum } else { c };
        std::array::from_fn(|finger| FingerState {
            flags: FINGER_SENSED | FINGER_VELOCITY,
            orientation: ORIENTATIONS[finger],
            position: self.positions[finger].map(quantised),
            velocity: self.velocities[finger],
            ..FingerState::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_force_displaces_a_hand_by_force_over_stiffness() {
        let hand = HandModel::Simulated { mass: 0.045, stiffness: 150.0, damping: 3.0 };
        let mut fingers = Fingers::new(FingerPath::parse("0,0,0,0,0,0,0").unwrap(), hand, 0.0);
        for _ in 0..2000 {
            fingers.advance(1e-3, &[[1.5, 0.0, 0.0], [0.0, -0.75, 0.0]]);
        }
        fingers.advance(0.0, &[[1.0; 3]; 2]);
        let [index, thumb] = fingers.sensed();
        assert!(index.velocity.iter().all(|c| c.is_finite()), "a step of no length changes nothing");
        assert!((index.position[0] - 0.01).abs() < 1e-9 && (thumb.position[1] + 0.005).abs() < 1e-9);
    }

    #[test]
    fn malformed_paths_are_rejected_with_the_line() {
        for (text, line) in [("", "no keyframe"), ("0,0,0,0,0,0,0\n0,1,1,1,1,1,1", "line 2"), ("0,a,0", "line 1")] {
            assert!(FingerPath::parse(text).unwrap_err().contains(line), "{text}");
        }
    }
}
