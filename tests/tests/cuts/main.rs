//! Bodies that are cut, split and stitched.

mod cut_area;
mod cut_face_dents;
mod cut_parts;
mod cutting;
mod cutting_physics;
mod drawn_cuts;
mod drawn_line;
mod drawn_twice;
mod fast_cuts;
mod fragments;
mod kept_line;
mod open_parts;
mod seams;
mod sheet_layers;
mod split_bodies;
mod split_parts;
mod stitching;
