//! One spring: energy and stiffness. The force is in `kernel`, many springs at a time.

/// J: k/2 (l - l0)^2. `p` are the ends, m; `k` the stiffness, N/m; `l0` the rest length, m.
pub fn energy(p: [[f64; 3]; 2], k: f64, l0: f64) -> f64 {
    let stretch = crate::kernel::length(p[0], p[1]) - l0;
    0.5 * k * stretch * stretch
}

/// N/m, 3 x 3: what moving the second end does to the force on the first, `k (n n' + max(0, 1 - l0/l) (I - n n'))`, plus
/// `c n n'` along the axis n. The transverse part of a compressed spring is left out, so that the matrix stays positive
/// semi-definite. Zero where the ends meet, for want of a direction.
pub fn hessian(p: [[f64; 3]; 2], k: f64, l0: f64, c: f64) -> [[f64; 3]; 3] {
    let l = crate::kernel::length(p[0], p[1]);
    if l < crate::kernel::NO_DIRECTION * l0 {
        return [[0.0; 3]; 3];
    }
    let n: [f64; 3] = std::array::from_fn(|i| (p[1][i] - p[0][i]) / l);
    let across = k * (1.0 - l0 / l).max(0.0);
    let along = k + c - across;
    std::array::from_fn(|i| std::array::from_fn(|j| along * n[i] * n[j] + if i == j { across } else { 0.0 }))
}
