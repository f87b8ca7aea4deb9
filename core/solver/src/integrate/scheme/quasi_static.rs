//! Quasi-static: no inertia, static equilibrium under the loads of each step.

use super::{Definition, Method, unlimited};

pub(super) const DEFINITION: Definition =
    Definition { name: "quasi-static", method: Method::Equilibrium, step_limit: unlimited };
