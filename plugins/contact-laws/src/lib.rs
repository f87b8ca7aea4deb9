//! Contact laws: the traction of two surfaces that overlap by a depth and slide along each other.
//!
//! Both laws press apart as Hunt and Crossley (1975) say. `hunt-crossley` has Coulomb friction, `rate-and-state` a friction that depends on
//! the speed of slip and on its past (Dieterich 1979, Ruina 1983).

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod hunt_crossley;
mod normal;
mod rate_and_state;

pub use hunt_crossley::HuntCrossley;
use pliant_plugin_api::{AsContactLaw, export_plugins};
pub use rate_and_state::RateAndState;

export_plugins!(AsContactLaw<HuntCrossley>, AsContactLaw<RateAndState>);
