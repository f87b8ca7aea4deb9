//! The conformance suite.

use pliant_plugin_api::AsMaterial;
use pliant_plugin_api::kit::{self, CountingAllocator};
use pliant_quasi_brittle::QuasiBrittle;

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance() {
    kit::check::<AsMaterial<QuasiBrittle>>();
}
