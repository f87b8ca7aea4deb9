//! Quasi-static: no inertia, static equilibrium under the loads of each step.

use super::{Method, SchemeProperties, unlimited};

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "quasi-static", method: Method::Equilibrium, step_limit: unlimited };
