//! Two fingers: where they want to be, and where what they feel lets them be.

use pliant_exoskeleton::wire::{EFFECTORS, Finger};

type V3 = [f64; 3];

/// Keyframes: s, then a place of each fingertip, m.
#[derive(Clone, Debug)]
pub struct Path(Vec<(f64, [V3; EFFECTORS])>);

impl Default for Path {
    /// Index and thumb close on what is between them, firmly, and pull it sideways. Tips of 8 mm that hardly met would hold a cloth
    /// only where a vertex of it happens to be between them.
    fn default() -> Self {
        let at = |x: f64, z: f64| [[x, 0.0, z], [x, 0.0, -z]];
        Self(vec![(0.0, at(0.0, 0.012)), (0.4, at(0.0, 0.0065)), (1.0, at(0.01, 0.0065))])
    }
}

impl Path {
    /// From rows of `time,x,y,z,x,y,z`: index, then thumb.
    ///
    /// # Errors
    /// A sentence with the line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut keys: Vec<(f64, [V3; EFFECTORS])> = Vec::new();
        for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#')) {
            let row: Vec<f64> = line.split(',').map_while(|c| c.trim().parse().ok()).collect();
            let later = |t: f64| keys.last().is_none_or(|(last, _)| t > *last);
            match row[..] {
                [t, a, b, c, d, e, f] if row.iter().all(|n| n.is_finite()) && later(t) => {
                    keys.push((t, [[a, b, c], [d, e, f]]));
                }
                _ => {
                    let allowed = "time,x,y,z,x,y,z in s and m, with times that rise";
                    return Err(format!("line {}: `{line}`; allowed is {allowed}", i + 1));
                }
            }
        }
        if keys.is_empty() { Err("no keyframe in it".into()) } else { Ok(Self(keys)) }
    }

    /// Where the fingers want to be at a time, s: straight between keyframes.
    pub fn at(&self, time: f64) -> [V3; EFFECTORS] {
        let after = self.0.partition_point(|(t, _)| *t <= time);
        match (after.checked_sub(1), self.0.get(after)) {
            (None, _) => self.0[0].1,
            (Some(i), None) => self.0[i].1,
            (Some(i), Some((t1, to))) => {
                let (t0, from) = &self.0[i];
                let s = (time - t0) / (t1 - t0);
                std::array::from_fn(|f| std::array::from_fn(|c| from[f][c] + s * (to[f][c] - from[f][c])))
            }
        }
    }
}

/// How a finger follows its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hand {
    /// Whatever it feels.
    Keyframed,
    /// As a mass on a spring and a damper, which what it feels pushes away.
    Simulated {
        /// kg, of the fingertip and what moves with it
        mass: f64,
        /// N/m, to where it wants to be
        stiffness: f64,
        /// N s/m, to the same
        damping: f64,
    },
}

/// Both fingers.
pub struct Fingers {
    path: Path,
    hand: Hand,
    quantum: f64,
    x: [V3; EFFECTORS],
    v: [V3; EFFECTORS],
    time: f64,
}

/// s, the longest step of the hand's own motion
const STEP: f64 = 2.5e-4;

impl Fingers {
    /// At the start of their path; positions are told in steps of `quantum`, m.
    pub fn new(path: Path, hand: Hand, quantum: f64) -> Self {
        let x = path.at(0.0);
        Self { path, hand, quantum, x, v: [[0.0; 3]; EFFECTORS], time: 0.0 }
    }

    /// Moves on by `dt` (s) under `force` (N).
    pub fn advance(&mut self, dt: f64, force: &[V3; EFFECTORS]) {
        if dt <= 0.0 {
            return;
        }
        let steps = (dt / STEP).ceil().clamp(1.0, 1e4);
        let h = dt / steps;
        for _ in 0..steps as usize {
            let before = self.path.at(self.time);
            self.time += h;
            let wanted = self.path.at(self.time);
            for f in 0..EFFECTORS {
                for c in 0..3 {
                    let speed = (wanted[f][c] - before[f][c]) / h;
                    match self.hand {
                        Hand::Keyframed => (self.x[f][c], self.v[f][c]) = (wanted[f][c], speed),
                        Hand::Simulated { mass, stiffness, damping } => {
                            // The damper is taken at the end of the step, so that no damping is too much.
                            let push = force[f][c] + stiffness * (wanted[f][c] - self.x[f][c]) + damping * speed;
                            self.v[f][c] = (self.v[f][c] + h / mass * push) / (1.0 + h * damping / mass);
                            self.x[f][c] += h * self.v[f][c];
                        }
                    }
                }
            }
        }
    }

    /// What the sensors say.
    pub fn sensed(&self) -> [Finger; EFFECTORS] {
        let quantised = |c: f64| if self.quantum > 0.0 { (c / self.quantum).round() * self.quantum } else { c };
        // The pads face each other: -z of the index, and the thumb is turned around y.
        let orientation = [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]];
        std::array::from_fn(|f| Finger {
            flags: 3,
            orientation: orientation[f],
            position: self.x[f].map(quantised),
            velocity: self.v[f],
            ..Finger::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_force_moves_a_hand_by_force_over_stiffness() {
        let hand = Hand::Simulated { mass: 0.045, stiffness: 150.0, damping: 3.0 };
        let mut fingers = Fingers::new(Path::parse("0,0,0,0,0,0,0").unwrap(), hand, 0.0);
        for _ in 0..2000 {
            fingers.advance(1e-3, &[[1.5, 0.0, 0.0], [0.0, -0.75, 0.0]]);
        }
        fingers.advance(0.0, &[[1.0; 3]; 2]);
        let [index, thumb] = fingers.sensed();
        assert!(index.velocity.iter().all(|c| c.is_finite()), "no time is no motion");
        assert!((index.position[0] - 0.01).abs() < 1e-9 && (thumb.position[1] + 0.005).abs() < 1e-9);
    }

    #[test]
    fn paths_that_are_none_are_refused_with_their_line() {
        for (text, line) in [("", "no keyframe"), ("0,0,0,0,0,0,0\n0,1,1,1,1,1,1", "line 2"), ("0,a,0", "line 1")] {
            assert!(Path::parse(text).unwrap_err().contains(line), "{text}");
        }
    }
}
