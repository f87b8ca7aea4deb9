//! The sources themselves: dependencies, documentation, fuzz seeds, and what no command would run.

mod crate_graph;
mod doc_links;
mod fuzz_seeds;
mod unbuilt_tests;
