//! The palette of edits, what it keeps, and how it is taken back.

mod ball_cuts;
mod clay;
mod doubled_vertices;
mod drafted_tools;
mod dragging;
mod edit_accuracy;
mod edit_balance;
mod edit_fields;
mod edits;
mod folded_shapes;
mod lost_grips;
mod mirrored_cuts;
mod mirrored_edits;
mod painted_layers;
mod painting;
mod pinned_groups;
mod pressed_places;
mod repeated_cuts;
mod sculpt_layers;
mod stiffness_change;
mod symmetric_strokes;
mod thin_plates;
mod two_hands;
mod undo;
