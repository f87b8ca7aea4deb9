//! Pictures as SVG texts: line plots, state maps and stacked bars. Every axis has a name and a unit; legends are beside the picture,
//! where they hide nothing.

mod axis;
mod lines;
mod stacked_bars;
mod state_map;
mod svg;

pub(crate) use axis::Axis;
pub(crate) use lines::{Curve, LinePlot};
pub(crate) use stacked_bars::StackedBars;
pub(crate) use state_map::StateMap;
pub(crate) use svg::format_short;
