//! The conformance suite.

use pliant_contact_laws::{HuntCrossley, RateAndState};
use pliant_plugin_api::AsContactLaw;
use pliant_plugin_api::kit::{self, CountingAllocator};

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance_of_hunt_crossley() {
    kit::check::<AsContactLaw<HuntCrossley>>();
}

#[test]
fn conformance_of_rate_and_state() {
    kit::check::<AsContactLaw<RateAndState>>();
}
