//! What happens in the window, without a graphics card: keys, pointer, panels and files, through the names that screen readers hear.

#[path = "../common/mod.rs"]
mod common;

mod camera;
mod controls;
mod dropping;
mod leaving;
mod opening;
mod painting;
mod reference_image;
mod release;
mod rest;
mod saving;
mod sculpt_layers;
mod sessions;
mod stiffness;
mod symmetry;
