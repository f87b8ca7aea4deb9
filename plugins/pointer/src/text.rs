//! Lines of numbers, read and written without taking memory.

use std::io::Write;

/// Bytes of the longest line.
pub(crate) const MOST_BYTES: usize = 256;

/// `x y z` or `x y z mask`; nothing else.
pub(crate) fn place(bytes: &[u8]) -> Option<([f64; 3], u32)> {
    let text = std::str::from_utf8(bytes).ok().filter(|t| t.len() <= MOST_BYTES)?;
    let mut words = text.split_ascii_whitespace();
    let mut place = [0.0; 3];
    for c in &mut place {
        *c = words.next()?.parse::<f64>().ok().filter(|c| c.is_finite())?;
    }
    let mask = match words.next() {
        None => 0,
        Some(word) => word.parse().ok()?,
    };
    words.next().is_none().then_some((place, mask))
}

/// `fx fy fz`; gives how many bytes.
pub(crate) fn force(force: [f64; 3], bytes: &mut [u8; MOST_BYTES]) -> usize {
    let [x, y, z] = force;
    let mut rest = &mut bytes[..];
    let written = writeln!(rest, "{x:.6} {y:.6} {z:.6}");
    let left = rest.len();
    if written.is_ok() { MOST_BYTES - left } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_three_numbers_and_perhaps_a_mask() {
        assert_eq!(place(b"0.01 -2e-3 0\n"), Some(([0.01, -2e-3, 0.0], 0)));
        assert_eq!(place(b" 1 2 3 5 "), Some(([1.0, 2.0, 3.0], 5)));
        for wrong in ["", "1 2", "1 2 3 4 5", "1 2 nan", "1 2 inf", "a b c", "1 2 3 -1", "1 2 3 4.5", "1,2,3"] {
            assert_eq!(place(wrong.as_bytes()), None, "{wrong}");
        }
        assert_eq!(place(&[0xff, 0xfe]), None);
        assert_eq!(place(" 1".repeat(200).as_bytes()), None);
    }

    #[test]
    fn a_force_is_a_line() {
        let mut bytes = [0; MOST_BYTES];
        let length = force([0.5, -1.25, 0.0], &mut bytes);
        assert_eq!(&bytes[..length], b"0.500000 -1.250000 0.000000\n");
        assert!(force([1e9; 3], &mut bytes) > 0);
    }
}
