//! Parsing and formatting of datagrams, without allocation.

use std::io::Write;

/// Bytes of the longest line.
pub(crate) const MAX_BYTES: usize = 256;

/// Content of a datagram to the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PoseLine {
    /// Position, m, device axes.
    pub(crate) position: [f64; 3],
    /// Button i is bit i.
    pub(crate) buttons: u32,
}

/// Parses `x y z` or `x y z mask`; `None` for anything else.
pub(crate) fn parse_pose(bytes: &[u8]) -> Option<PoseLine> {
    let text = std::str::from_utf8(bytes).ok().filter(|t| t.len() <= MAX_BYTES)?;
    let mut words = text.split_ascii_whitespace();
    let mut position = [0.0; 3];
    for c in &mut position {
        *c = words.next()?.parse::<f64>().ok().filter(|c| c.is_finite())?;
    }
    let buttons = match words.next() {
        None => 0,
        Some(word) => word.parse().ok()?,
    };
    words.next().is_none().then_some(PoseLine { position, buttons })
}

/// Writes `fx fy fz` (N) and returns the number of bytes.
pub(crate) fn format_force(force: [f64; 3], bytes: &mut [u8; MAX_BYTES]) -> usize {
    let [x, y, z] = force;
    let mut rest = &mut bytes[..];
    let written = writeln!(rest, "{x:.6} {y:.6} {z:.6}");
    let left = rest.len();
    if written.is_ok() { MAX_BYTES - left } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_three_numbers_and_an_optional_mask() {
        let line = |position, buttons| Some(PoseLine { position, buttons });
        assert_eq!(parse_pose(b"0.01 -2e-3 0\n"), line([0.01, -2e-3, 0.0], 0));
        assert_eq!(parse_pose(b" 1 2 3 5 "), line([1.0, 2.0, 3.0], 5));
        for wrong in ["", "1 2", "1 2 3 4 5", "1 2 nan", "1 2 inf", "a b c", "1 2 3 -1", "1 2 3 4.5", "1,2,3"] {
            assert_eq!(parse_pose(wrong.as_bytes()), None, "{wrong}");
        }
        assert_eq!(parse_pose(&[0xff, 0xfe]), None);
        assert_eq!(parse_pose(" 1".repeat(200).as_bytes()), None);
    }

    #[test]
    fn a_force_is_a_line() {
        let mut bytes = [0; MAX_BYTES];
        let length = format_force([0.5, -1.25, 0.0], &mut bytes);
        assert_eq!(&bytes[..length], b"0.500000 -1.250000 0.000000\n");
        assert!(format_force([1e9; 3], &mut bytes) > 0);
    }
}
