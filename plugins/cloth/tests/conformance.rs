//! The promises of the border.

use pliant_cloth::Cloth;
use pliant_plugin_api::AsMaterial;
use pliant_plugin_api::kit::{self, CountingAllocator};

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance() {
    kit::check::<AsMaterial<Cloth>>();
}
