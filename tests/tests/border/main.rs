//! Plugins: what the interface promises, and what happens when one breaks it.

mod conformance;
mod contact_law_scenes;
mod contact_laws;
mod corrupted_libraries;
mod old_binaries;
mod plugin_check;
mod plugin_faults;
mod plugin_new;
mod whole_lists;
