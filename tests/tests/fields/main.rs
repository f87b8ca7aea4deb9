//! Parameters and directions that differ from place to place.

mod fibres;
mod fields;
mod mesh_data_fields;
mod texture_fields;
