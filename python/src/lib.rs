//! The native half of the Python package `pliant`.
//!
//! It hands texts, arrays and numbers over and nothing else: what a scene may say, what a step does and what an error says is the
//! engine's, and what users call is written in Python in `pliant/`.

mod arrays;
mod batch;
mod conformance;
mod convert;
mod ctrl_c;
mod failure;
mod law;
mod law_element;
mod law_material;
mod lease;
mod live;
mod live_clock;
mod live_device;
mod live_object;
mod model;
mod open;
mod open_session;
mod painting;
mod plugins;
mod run;
mod session;
mod session_batch;
mod states;
mod trace;

#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::arrays::ray_cast;
    #[pymodule_export]
    use super::batch::{batch_collect, batch_run, batch_serve, batch_size};
    #[pymodule_export]
    use super::conformance::check_law;
    #[pymodule_export]
    use super::convert::{obj_text, to_toml};
    #[pymodule_export]
    use super::failure::raise_panic;
    #[pymodule_export]
    use super::law::Law;
    #[pymodule_export]
    use super::live_object::Live;
    #[pymodule_export]
    use super::open::check;
    #[pymodule_export]
    use super::plugins::{
        devices, edit_kinds, edit_strengths, opposite_kind, plugins, quantities, skipped_plugin_folders, solids,
    };
    #[pymodule_export]
    use super::run::run;
    #[pymodule_export]
    use super::session::{Session, Snapshot};
    #[pymodule_export]
    use super::session_batch::SessionBatch;
}
