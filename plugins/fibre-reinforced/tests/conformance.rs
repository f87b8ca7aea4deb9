//! The conformance suite, with allocations counted.

use pliant_fibre_reinforced::FibreReinforced;
use pliant_plugin_api::AsMaterial;
use pliant_plugin_api::kit::{self, CountingAllocator};

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance() {
    kit::check::<AsMaterial<FibreReinforced>>();
}
