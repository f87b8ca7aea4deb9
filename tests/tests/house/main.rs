//! The sources themselves: dependencies, documentation and fuzz seeds.

mod crate_graph;
mod doc_links;
mod fuzz_seeds;
