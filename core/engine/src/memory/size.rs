//! Numbers of bytes as people write and read them.

/// Parses a number of bytes, such as `2 GB` (1000^3) or `512 MiB` (1024^2).
///
/// # Errors
/// What is allowed.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, u64); 7] = [
        ("kB", 1000),
        ("MB", 1_000_000),
        ("GB", 1_000_000_000),
        ("KiB", 1 << 10),
        ("MiB", 1 << 20),
        ("GiB", 1 << 30),
        ("B", 1),
    ];
    let text = text.trim();
    let parsed = UNITS.iter().find_map(|(unit, size)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        (number > 0.0 && number.is_finite()).then_some((number * *size as f64) as u64)
    });
    parsed.ok_or_else(|| format!("`{text}`; allowed is a number above 0 with B, kB, MB, GB, KiB, MiB or GiB"))
}

/// A number of bytes as people read it.
pub fn format_bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b >= 1e15 => "more than 1000 TB".into(),
        b if b >= 1e9 => format!("{:.2} GB", b / 1e9),
        b if b >= 1e6 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.0} kB", b / 1e3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_have_units() {
        assert_eq!(parse_bytes("2 GB"), Ok(2_000_000_000));
        assert_eq!(parse_bytes("1.5 MiB"), Ok(3 << 19));
        assert!(["2", "GB", "-1 GB", "1 parsec"].iter().all(|text| parse_bytes(text).is_err()));
        assert_eq!(
            [2_000, 1_500_000, 3_210_000_000, u64::MAX].map(format_bytes),
            ["2 kB", "1.5 MB", "3.21 GB", "more than 1000 TB"]
        );
    }
}
