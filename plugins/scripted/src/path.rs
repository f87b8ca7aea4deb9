//! Positions and buttons as functions of time.

use pliant_plugin_api::Fault;
use pliant_plugin_api::param::Table;

/// Interpolation between two keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear, with constant speed between the keyframes.
    Linear,
    /// Cubic, with zero velocity at both keyframes.
    Smooth,
}

/// A position at a time.
struct Keyframe {
    /// Time at which the hand is there, s.
    time: f64,
    /// Position in axes of the device, m; for a path of rotations a rotation vector, degrees.
    position: [f64; 3],
}

/// The buttons pressed from a time on.
struct ButtonChange {
    /// Time from which on they are pressed, s.
    time: f64,
    /// Pressed buttons: button i is bit i.
    mask: u32,
}

/// Position and buttons at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position, m, device axes; for a path of rotations a rotation vector, degrees.
    pub position: [f64; 3],
    /// Pressed buttons: button i is bit i.
    pub buttons: u32,
}

/// Keyframes and button changes, each with ascending times.
pub struct Path {
    /// Keyframes, at least one.
    keys: Vec<Keyframe>,
    /// Changes of the buttons; none are pressed before the first.
    buttons: Vec<ButtonChange>,
    /// Interpolation between keyframes.
    interpolation: Interpolation,
}

impl Path {
    /// A path of positions, from tables of (time, x, y, z) and (time, mask), s and m.
    ///
    /// # Errors
    /// Times that do not ascend, or a mask that is not a whole number.
    pub fn from_keys(keys: &Table, buttons: Option<&Table>, interpolation: Interpolation) -> Result<Self, Fault> {
        let keys: Vec<_> = keys.rows().map(|r| Keyframe { time: r[0], position: [r[1], r[2], r[3]] }).collect();
        let rows: Vec<&[f64]> = buttons.into_iter().flat_map(Table::rows).collect();
        check_ascending(keys.iter().map(|k| k.time), "`path`")?;
        check_ascending(rows.iter().map(|r| r[0]), "`buttons`")?;
        let change = |r: &&[f64]| Ok(ButtonChange { time: r[0], mask: parse_mask(r[1])? });
        let buttons = rows.iter().map(change).collect::<Result<_, String>>().map_err(Fault::bad_argument)?;
        Ok(Self { keys, buttons, interpolation })
    }

    /// A path of rotation vectors, from a table of (time, x, y, z), s and degrees.
    ///
    /// # Errors
    /// Times that do not ascend.
    pub fn of_rotations(keys: &Table, interpolation: Interpolation) -> Result<Self, Fault> {
        let keys: Vec<_> = keys.rows().map(|r| Keyframe { time: r[0], position: [r[1], r[2], r[3]] }).collect();
        check_ascending(keys.iter().map(|k| k.time), "`rotation`")?;
        Ok(Self { keys, buttons: Vec::new(), interpolation })
    }

    /// A path of positions, from a CSV file with rows time,x,y,z or time,x,y,z,mask (s and m). A header line, empty lines and lines that start with `#` are
    /// skipped.
    ///
    /// # Errors
    /// A file that cannot be read, or an invalid row, by its line number.
    pub fn from_file(file: &str, interpolation: Interpolation) -> Result<Self, Fault> {
        let text = std::fs::read_to_string(file).map_err(|e| Fault::io(format!("{file}: {e}")))?;
        let (mut keys, mut buttons) = (Vec::new(), Vec::new());
        for (i, line) in text.lines().enumerate() {
            let wrong = |what: &str| {
                Fault::bad_argument(format!("{file}:{}: {what}; allowed is time,x,y,z or time,x,y,z,mask", i + 1))
            };
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            let numbers: Result<Vec<f64>, _> = fields.iter().map(|f| f.parse::<f64>()).collect();
            let numbers = match numbers {
                Ok(numbers) => numbers,
                Err(_) if keys.is_empty() && fields.iter().all(|f| f.parse::<f64>().is_err()) => continue,
                Err(_) => return Err(wrong("not a number")),
            };
            if !(4..=5).contains(&numbers.len()) || !numbers.iter().all(|n| n.is_finite()) {
                return Err(wrong("not 4 or 5 finite numbers"));
            }
            let time = numbers[0];
            keys.push(Keyframe { time, position: [numbers[1], numbers[2], numbers[3]] });
            if let Some(&mask) = numbers.get(4) {
                buttons.push(ButtonChange { time, mask: parse_mask(mask).map_err(|e| wrong(&e))? });
            }
        }
        if keys.is_empty() {
            return Err(Fault::bad_argument(format!("{file}: no row of numbers")));
        }
        check_ascending(keys.iter().map(|k| k.time), file)?;
        Ok(Self { keys, buttons, interpolation })
    }

    /// Position and buttons at a time (s). Before the first keyframe and after the last, the position is theirs.
    pub fn sample(&self, time: f64) -> Sample {
        let changes = self.buttons.partition_point(|b| b.time <= time);
        let buttons = changes.checked_sub(1).map_or(0, |i| self.buttons[i].mask);
        let next = self.keys.partition_point(|k| k.time <= time);
        let position = match (next.checked_sub(1), self.keys.get(next)) {
            (None, _) => self.keys[0].position,
            (Some(last), None) => self.keys[last].position,
            (Some(last), Some(next)) => {
                let last = &self.keys[last];
                let t = (time - last.time) / (next.time - last.time);
                let s = match self.interpolation {
                    Interpolation::Linear => t,
                    Interpolation::Smooth => t * t * (3.0 - 2.0 * t),
                };
                std::array::from_fn(|c| last.position[c] + s * (next.position[c] - last.position[c]))
            }
        };
        Sample { position, buttons }
    }

    /// Least and greatest corner of the box around all keyframes, m.
    pub fn bounds(&self) -> [f64; 6] {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY, -f64::INFINITY];
        for Keyframe { position: p, .. } in &self.keys {
            for c in 0..3 {
                bounds[c] = bounds[c].min(p[c]);
                bounds[3 + c] = bounds[3 + c].max(p[c]);
            }
        }
        bounds
    }
}

/// A button mask from a number.
fn parse_mask(value: f64) -> Result<u32, String> {
    let is_mask = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    if is_mask {
        Ok(value as u32)
    } else {
        Err(format!("button mask {value} is not a whole number from 0 to 2^32 - 1"))
    }
}

/// Checks that times ascend; `what` is the table or file in the message, which has the number of the row.
fn check_ascending(times: impl Iterator<Item = f64>, what: &str) -> Result<(), Fault> {
    let mut last = f64::NEG_INFINITY;
    for (i, t) in times.enumerate() {
        if t <= last {
            return Err(Fault::bad_argument(format!(
                "{what}: row {} is at {t} s, not after {last} s; allowed are ascending times",
                i + 1
            )));
        }
        last = t;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: usize, values: &[f64]) -> Table {
        Table { columns, values: values.to_vec() }
    }

    #[test]
    fn keyframes_are_interpolated() {
        let keys = table(4, &[1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 2.0, 4.0]);
        let buttons = table(2, &[1.5, 1.0, 1.8, 0.0]);
        let linear = Path::from_keys(&keys, Some(&buttons), Interpolation::Linear).unwrap();
        let sample = |position, buttons| Sample { position, buttons };
        assert_eq!(linear.sample(0.0), sample([0.0; 3], 0));
        assert_eq!(linear.sample(1.5), sample([0.5, 1.0, 2.0], 1));
        assert_eq!(linear.sample(1.75), sample([0.75, 1.5, 3.0], 1));
        assert_eq!(linear.sample(9.0), sample([1.0, 2.0, 4.0], 0));
        let smooth = Path::from_keys(&keys, None, Interpolation::Smooth).unwrap();
        assert_eq!(smooth.sample(1.5).position, [0.5, 1.0, 2.0]);
        assert!((smooth.sample(1.25).position[0] - 0.15625).abs() < 1e-15);
        assert_eq!(linear.bounds(), [0.0, 0.0, 0.0, 1.0, 2.0, 4.0]);
    }

    #[test]
    fn times_that_do_not_ascend_are_refused() {
        let keys = table(4, &[1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 4.0]);
        let refused = Path::from_keys(&keys, None, Interpolation::Linear).err().unwrap();
        assert!(refused.reason.contains("row 2"), "{refused}");
    }
}
