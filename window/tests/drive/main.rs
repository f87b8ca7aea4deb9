//! Whole drives: the program on a display of its own, moved by a mouse and a keyboard that the X server takes for real ones.

mod cut;
mod display;
mod drag;
mod dropping;
mod edit;
mod leaving;
mod models;
mod recovery;
mod start;
mod window;
