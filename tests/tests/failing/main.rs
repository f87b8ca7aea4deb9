//! Elements that fail, and surfaces that follow.

mod broken_cuts;
mod broken_solids;
mod failed_steps;
mod failure;
mod fracture;
