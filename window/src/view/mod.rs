//! What is seen, and what is drawn over the picture of the model.

mod camera;
pub mod cube;
pub mod overlay;

pub use camera::{Camera, Eye, Projection, Ray, UpAxis};
