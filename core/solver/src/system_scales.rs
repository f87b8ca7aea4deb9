//! The matrix of a step: factors of mass, stiffness and damping, and how stiffness is approximated.

/// How much of the exact Hessian an approximation must reach.
///
/// Two energies have no Hessian that fits the matrix: coupled hinges, whose exact one is full, and energies of vertex normals, whose
/// exact one couples nodes that share no element. Both are approximated by one term `k g g^T` for each hinge (g the gradient of its
/// angle); what is dropped is the coupling between hinges and the geometric part `m d2s/dx2`. The variants say how k is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HessianApproximation {
    /// No bound: for Newton's method with a line search, which converges fastest with the mean stiffness.
    Unbounded,
    /// At least half the exact Hessian: one step of backward Euler that is linearised once is stable with it.
    AtLeastHalf,
    /// Nowhere below the exact Hessian: for step limits, and for schemes without numerical damping.
    UpperBound,
}

/// The matrix `mass M + stiffness K + damping C` that [`Matrix::assemble`](crate::Matrix::assemble) builds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemScales {
    /// Factor of the lumped masses M. A step of an implicit scheme has 1; a frequency estimate has 0.
    pub mass: f64,
    /// Factor of the stiffness K: g^2 (s^2) in a step that moves positions by g (s) times velocities.
    pub stiffness: f64,
    /// Factor of the damping C: g (s) in such a step.
    pub damping: f64,
    /// How a Hessian that does not fit the matrix is approximated.
    pub hessian: HessianApproximation,
    /// Whether the forces of this state were computed last, so that the strains of coupled hinges are those of this state.
    pub strains_are_current: bool,
    /// Whether blocks may be stored in single precision, if the material writes them so.
    pub allow_f32: bool,
}
