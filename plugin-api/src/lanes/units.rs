//! Vector units to test kernels on.

use pulp::Arch;

/// The vector units of this processor: none, AVX2 where it has that, and the widest. A kernel must give the same bytes on each.
pub fn units() -> Vec<Arch> {
    let mut units = vec![Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    units.extend(pulp::x86::V3::try_new().map(Arch::V3));
    units.push(Arch::new());
    units
}
