//! Exact reading and writing of decimal numbers.

use std::io::{self, Write};

/// The number at the beginning of `text` and its length in bytes, if one exact multiplication or division suffices to read it.
///
/// A mantissa up to 2^53 and a power of ten up to 10^22 are exact in f64, so their product or quotient is rounded
/// once, as a correct reading must be (Clinger, 1990). `None` is not an error: [`parse`] decides.
#[inline]
pub(super) fn exact_prefix(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let mut at = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let mut mantissa = 0;
    let start = at;
    at = digits(text, at, &mut mantissa);
    let mut count = at - start;
    let mut exponent = 0_i64;
    if text.get(at) == Some(&b'.') {
        let start = at + 1;
        at = digits(text, start, &mut mantissa);
        count += at - start;
        exponent = -((at - start) as i64);
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let negative = text.get(at + 1) == Some(&b'-');
        let start = at + 1 + usize::from(matches!(text.get(at + 1), Some(b'-' | b'+')));
        let mut power = 0;
        at = digits(text, start, &mut power);
        if !(1..=4).contains(&(at - start)) {
            return None;
        }
        exponent += if negative { -(power as i64) } else { power as i64 };
    }
    // 19 digits cannot overflow 64 bits; more may have.
    if !(1..=19).contains(&count) || mantissa > 1 << 53 || exponent.unsigned_abs() > 22 {
        return None;
    }
    let power = POWERS[exponent.unsigned_abs() as usize];
    let size = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    Some((if negative { -size } else { size }, at))
}

/// Reads the whole `token` as a finite number.
pub(super) fn parse(token: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(token).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// Writes the shortest decimal that reads back as `value`, with at most 17 significant digits.
pub(super) fn write(value: f64, out: &mut impl Write) -> io::Result<()> {
    if value == 0.0 || (1e-5..1e16).contains(&value.abs()) {
        write!(out, "{value}")
    } else {
        write!(out, "{value:e}") // plain notation would spell out up to 300 zeros
    }
}

/// Appends the digits from index `at` to `value`. Returns the index after them.
#[inline]
fn digits(text: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(byte @ b'0'..=b'9') = text.get(at) {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
        at += 1;
    }
    at
}

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Reads as the parser does: the fast way if it takes the whole token.
    fn read(text: &str) -> Option<f64> {
        match exact_prefix(text.as_bytes()) {
            Some((value, length)) if length == text.len() => Some(value),
            _ => parse(text.as_bytes()),
        }
    }

    #[track_caller]
    fn check(text: &str) {
        let expected = text.parse::<f64>().ok().filter(|value| value.is_finite());
        assert_eq!(read(text).map(f64::to_bits), expected.map(f64::to_bits), "{text}");
    }

    #[test]
    fn reads_what_the_standard_library_reads() {
        for text in [
            "0",
            "-0",
            "+0",
            "-0.0",
            "1",
            "-1",
            "+1",
            ".5",
            "5.",
            "-.5",
            "+.5e1",
            "1e22",
            "1e23",
            "1e-22",
            "1e-23",
            ".",
            "9007199254740992",
            "9007199254740993",
            "9007199254740993e-22",
            "18446744073709551615",
            "1e999",
            "1e-999",
            "99999999999999999999",
            "0.000000000000000000000001",
            "1e",
            "1e+",
            "e5",
            "",
            "-",
            "+-1",
            "1.2.3",
            "1,5",
            "nan",
            "inf",
            "-Infinity",
            "1e00005",
            "1e5000000000",
            "0x10",
            "1d5",
            "1_000",
            "4.9e-324",
            "2.2250738585072014e-308",
        ] {
            check(text);
        }
    }

    #[test]
    fn random_decimals_read_bit_for_bit() {
        let mut random = Random(1);
        for _ in 0..200_000 {
            let places = random.below(24) as usize;
            let mantissa = random.next_u64() >> random.below(64);
            let exponent = random.below(60) as i64 - 30;
            check(&format!("{mantissa}e{exponent}"));
            let digits = format!("{mantissa:0>places$}");
            let (whole, part) = digits.split_at(digits.len() - places.min(digits.len()));
            check(&format!("-{whole}.{part}"));
            check(&format!("{:.*}", places, random.unit() - 0.5));
        }
    }

    #[test]
    fn written_numbers_are_short_and_read_back() {
        let mut random = Random(2);
        let bits = |_| f64::from_bits(random.next_u64());
        let mut values: Vec<f64> = (0..100_000).map(bits).filter(|value| value.is_finite()).collect();
        values.extend([0.0, -0.0, 0.1, 1.0 / 3.0, 1e15, 1e16, 1e-5, 9.9e-6, f64::MAX, f64::MIN_POSITIVE, 5e-324]);
        for value in values {
            let mut text = Vec::new();
            write(value, &mut text).unwrap();
            let text = String::from_utf8(text).unwrap();
            assert_eq!(read(&text).map(f64::to_bits), Some(value.to_bits()), "{text}");
            let mantissa = text.split('e').next().unwrap_or_default().replace(['-', '.'], "");
            assert!(mantissa.trim_matches('0').len() <= 17, "{text}");
        }
    }
}
