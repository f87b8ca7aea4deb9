//! The vector unit that kernels run on.

use pulp::Arch;
use std::env::VarError;
use std::sync::LazyLock;

/// The environment variable that limits the vector unit.
const VARIABLE: &str = "PLIANT_VECTOR_UNIT";

/// Read once: a unit that changed in a run would split its kernels.
static UNIT: LazyLock<Result<Arch, String>> = LazyLock::new(|| match std::env::var(VARIABLE) {
    Ok(name) => named(&name),
    Err(VarError::NotPresent) => Ok(Arch::new()),
    Err(VarError::NotUnicode(name)) => named(&name.to_string_lossy()),
});

/// The unit with this name; an empty one is that of the processor.
fn named(name: &str) -> Result<Arch, String> {
    match name {
        "" => Ok(Arch::new()),
        "none" => Ok(Arch::Scalar),
        "avx2" => avx2().ok_or_else(|| format!("${VARIABLE} is `avx2`, which this processor does not have")),
        _ => Err(format!(
            "${VARIABLE} is `{name}`; allowed are `none`, `avx2`, or nothing for the widest of the processor"
        )),
    }
}

fn avx2() -> Option<Arch> {
    #[cfg(target_arch = "x86_64")]
    return pulp::x86::V3::try_new().map(Arch::V3);
    #[cfg(not(target_arch = "x86_64"))]
    None
}

/// The vector unit of all kernels: the widest of the processor, unless `$PLIANT_VECTOR_UNIT` is `none` or `avx2`. Kernels give the same bytes on each, so
/// that is for comparing them, and the results of processors.
pub fn vector_unit() -> Arch {
    UNIT.as_ref().map_or_else(|_| Arch::new(), |unit| *unit)
}

/// Checks `$PLIANT_VECTOR_UNIT`, for a program to call before it computes anything.
///
/// # Errors
/// What it is and what is allowed, if it names no unit of this processor.
pub fn check_vector_unit() -> Result<(), String> {
    UNIT.as_ref().map(drop).map_err(String::clone)
}

/// The vector units of this processor: none, AVX2 where it has that, and the widest. A kernel must give the same bytes on each.
pub fn units() -> Vec<Arch> {
    [Some(Arch::Scalar), avx2(), Some(Arch::new())].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_that_does_not_exist_is_named_with_those_that_do() {
        assert!(matches!(named("none"), Ok(Arch::Scalar)));
        let error = named("avx3").expect_err("there is none");
        assert!(error.contains("`avx3`") && error.contains("`none`") && error.contains("`avx2`"), "{error}");
    }
}
