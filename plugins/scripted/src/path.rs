//! Where the hand is, by time.

use pliant_plugin_api::Fault;
use pliant_plugin_api::param::Table;

/// What happens between two keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Constant speed.
    Linear,
    /// From rest to rest.
    Smooth,
}

/// Keyframes with rising times.
pub struct Path {
    /// s and m
    keys: Vec<(f64, [f64; 3])>,
    /// s and mask
    buttons: Vec<(f64, u32)>,
    interpolation: Interpolation,
}

impl Path {
    /// From tables of (time, x, y, z) and (time, mask).
    pub fn from_keys(keys: &Table, buttons: Option<&Table>, interpolation: Interpolation) -> Result<Self, Fault> {
        let keys: Vec<_> = keys.rows().map(|r| (r[0], [r[1], r[2], r[3]])).collect();
        let buttons: Vec<_> = buttons.into_iter().flat_map(Table::rows).map(|r| (r[0], r[1])).collect();
        rising(keys.iter().map(|k| k.0), "`path`")?;
        rising(buttons.iter().map(|b| b.0), "`buttons`")?;
        let buttons = buttons.into_iter().map(|(t, m)| Ok((t, mask(m)?))).collect::<Result<_, String>>();
        Ok(Self { keys, buttons: buttons.map_err(Fault::bad_argument)?, interpolation })
    }

    /// From a CSV file; a first line of words and lines that start with `#` are passed over.
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
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            let numbers: Result<Vec<f64>, _> = cells.iter().map(|c| c.parse::<f64>()).collect();
            let numbers = match numbers {
                Ok(numbers) => numbers,
                Err(_) if keys.is_empty() && cells.iter().all(|c| c.parse::<f64>().is_err()) => continue,
                Err(_) => return Err(wrong("not a number")),
            };
            if !(4..=5).contains(&numbers.len()) || !numbers.iter().all(|n| n.is_finite()) {
                return Err(wrong("not 4 or 5 finite numbers"));
            }
            keys.push((numbers[0], [numbers[1], numbers[2], numbers[3]]));
            if let Some(&m) = numbers.get(4) {
                buttons.push((numbers[0], mask(m).map_err(|e| wrong(&e))?));
            }
        }
        if keys.is_empty() {
            return Err(Fault::bad_argument(format!("{file}: no row of numbers")));
        }
        rising(keys.iter().map(|k| k.0), file)?;
        Ok(Self { keys, buttons, interpolation })
    }

    /// Position (m) and buttons at a time (s): those of the first and last keyframe outside of them.
    pub fn at(&self, time: f64) -> ([f64; 3], u32) {
        let pressed = self.buttons.partition_point(|(t, _)| *t <= time);
        let mask = pressed.checked_sub(1).map_or(0, |i| self.buttons[i].1);
        let after = self.keys.partition_point(|(t, _)| *t <= time);
        let position = match (after.checked_sub(1), self.keys.get(after)) {
            (None, _) => self.keys[0].1,
            (Some(i), None) => self.keys[i].1,
            (Some(i), Some(&(t1, p1))) => {
                let (t0, p0) = self.keys[i];
                let s = (time - t0) / (t1 - t0);
                let s = if self.interpolation == Interpolation::Smooth { s * s * (3.0 - 2.0 * s) } else { s };
                std::array::from_fn(|c| p0[c] + s * (p1[c] - p0[c]))
            }
        };
        (position, mask)
    }

    /// Least and greatest corner of the box around all keyframes, m.
    pub fn bounds(&self) -> [f64; 6] {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY, -f64::INFINITY];
        for (_, p) in &self.keys {
            for c in 0..3 {
                bounds[c] = bounds[c].min(p[c]);
                bounds[3 + c] = bounds[3 + c].max(p[c]);
            }
        }
        bounds
    }
}

fn mask(value: f64) -> Result<u32, String> {
    let whole = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    if whole { Ok(value as u32) } else { Err(format!("button mask {value} is not a whole number from 0 to 2^32 - 1")) }
}

fn rising(times: impl Iterator<Item = f64>, what: &str) -> Result<(), Fault> {
    let mut last = f64::NEG_INFINITY;
    for (i, t) in times.enumerate() {
        if t <= last {
            return Err(Fault::bad_argument(format!(
                "{what}: row {} is at {t} s, not after {last} s; allowed is times that rise",
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
    fn goes_through_its_keyframes() {
        let keys = table(4, &[1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 2.0, 4.0]);
        let buttons = table(2, &[1.5, 1.0, 1.8, 0.0]);
        let linear = Path::from_keys(&keys, Some(&buttons), Interpolation::Linear).unwrap();
        assert_eq!(linear.at(0.0), ([0.0; 3], 0));
        assert_eq!(linear.at(1.5), ([0.5, 1.0, 2.0], 1));
        assert_eq!(linear.at(1.75), ([0.75, 1.5, 3.0], 1));
        assert_eq!(linear.at(9.0), ([1.0, 2.0, 4.0], 0));
        let smooth = Path::from_keys(&keys, None, Interpolation::Smooth).unwrap();
        assert_eq!(smooth.at(1.5).0, [0.5, 1.0, 2.0]);
        assert!((smooth.at(1.25).0[0] - 0.15625).abs() < 1e-15);
        assert_eq!(linear.bounds(), [0.0, 0.0, 0.0, 1.0, 2.0, 4.0]);
    }

    #[test]
    fn times_that_do_not_rise_are_refused() {
        let keys = table(4, &[1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 4.0]);
        let refused = Path::from_keys(&keys, None, Interpolation::Linear).err().unwrap();
        assert!(refused.reason.contains("row 2"), "{refused}");
    }
}
