//! Parameters and directions that differ from place to place.

mod fibres;
mod fields;
mod texture_fields;
