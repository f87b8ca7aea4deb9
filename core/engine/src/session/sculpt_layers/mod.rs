//! Sculpt layers: what strokes have made of the shape at rest, kept apart, so that it can be weakened, hidden and taken away.
//!
//! The shape at rest of a body is a base and, for each layer, its strength times a difference of rest shapes. Strokes made while a layer records
//! become a part of it: what they press comes off again with the layer and its strain does not, so a stroke is recorded as the shape that was kept.
//! A cut or a stitch changes the connectivity; layers from before it then have a fixed strength, for the new surface is not in them.

mod commands;
mod stack;

pub use stack::SculptLayerState;
pub(super) use stack::SculptLayers;
