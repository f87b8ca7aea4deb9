//! Tools, obstacles and bodies that meet.

mod contact_families;
mod contact_levels;
mod containment;
mod meeting_bodies;
mod moving_obstacles;
mod obstacles;
mod stiff_couplings;
mod tied_bodies;
mod tool_shapes;
mod touching;
