//! Figures as SVG: line plots, heat maps, state maps and stacked bars. Every axis has a name and a unit; legends are beside the plot and cover nothing.

mod axis;
mod heat_map;
mod lines;
mod stacked_bars;
mod state_map;
mod svg;

pub use axis::Axis;
pub use heat_map::HeatMap;
pub use lines::{Curve, LinePlot};
pub(crate) use stacked_bars::StackedBars;
pub(crate) use state_map::StateMap;
pub(crate) use svg::format_short;
