//! Reference cases, numbered as in `docs/testing.md`.

mod reference_contact;
mod reference_drape;
mod reference_dynamics;
mod reference_sheets;
mod reference_statics;
