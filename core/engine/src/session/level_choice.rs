//! Choice of the level of a grid by `level = "auto"`: cells that are fine for the smallest tool, within a number of cells.

use super::opening::region_radius;
use pliant_mesh::Surface;
use serde::Serialize;
use std::f64::consts::PI;

/// Largest edge of a cell, relative to the radius of the smallest tool.
const CELL_SHARE: f64 = 0.5;
/// Largest estimated number of cells that are simulated at a time.
const MOST_CELLS: f64 = 8000.0;
/// Finest level that `auto` chooses; a finer one takes so much memory that a scene must name it.
const FINEST: u32 = 8;
/// Level of a body that no tool touches, if it has few enough cells.
const WITHOUT_TOOL: u32 = 6;

/// The level of a body's grid or of its subdivision, and why it was chosen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LevelChosen {
    /// Name of the body.
    pub body: String,
    /// Level of a grid, which has 2^(level - 1) cells along the longest edge of the body; or the number of times that faces were divided into four.
    pub level: u32,
    /// Reason for the choice, for people.
    pub why: String,
}

/// Inputs of the choice of a level.
struct Demand {
    /// Longest edge of the body, m.
    longest: f64,
    /// Volume, m^3, and area, m^2, of its surface.
    volume: f64,
    area: f64,
    /// Tools in use.
    tools: ToolRadii,
    /// Radius of the local region, m, infinite for the whole body; `None` if it depends on cells and tools.
    region: Option<f64>,
}

/// Radii of the smallest and of the largest tool in use, m; both 0 without a tool.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolRadii {
    pub smallest: f64,
    pub largest: f64,
}

impl ToolRadii {
    /// Counts a tool of this radius, m.
    pub fn add(&mut self, radius: f64) {
        self.smallest = if self.largest == 0.0 { radius } else { self.smallest.min(radius) };
        self.largest = self.largest.max(radius);
    }
}

/// The level of the grid of a body with this surface, and the reason for it. `region` is the radius of its local region, m, infinite for the whole
/// body; `None` if the region follows from cells and tools.
pub fn choose_level(surface: &Surface, tools: ToolRadii, region: Option<f64>) -> (u32, String) {
    let longest = surface.bounds().longest_edge();
    let (volume, area) = (surface.volume().abs(), surface.areas().iter().sum());
    Demand { longest, volume, area, tools, region }.choose()
}

impl Demand {
    fn choose(&self) -> (u32, String) {
        let smallest = self.tools.smallest;
        let fits = |level: u32| match smallest {
            0.0 => level == WITHOUT_TOOL,
            _ => self.edge(level) <= CELL_SHARE * smallest,
        };
        let wanted = (1..FINEST).find(|level| fits(*level)).unwrap_or(FINEST);
        let level = (1..=wanted).rev().find(|level| self.cells(*level) <= MOST_CELLS).unwrap_or(1);
        let [edge, tool] = [self.edge(level), smallest].map(|length| 1e3 * length);
        let why = if level < wanted {
            let (finer, cells) = (level + 1, self.cells(level + 1));
            format!("cells of {edge:.3} mm; level {finer} would simulate about {cells:.0}, over {MOST_CELLS}")
        } else if smallest == 0.0 {
            format!("cells of {edge:.3} mm; no tool is in use")
        } else if fits(level) {
            format!("cells of {edge:.3} mm are at most half of the smallest tool's radius, {tool:.3} mm")
        } else {
            format!(
                "the finest that is chosen; cells of {edge:.3} mm are over half of the smallest tool's radius, {tool:.3} mm"
            )
        };
        (level, why)
    }

    /// Edge of a cell, m.
    fn edge(&self, level: u32) -> f64 {
        self.longest / f64::from(1_u32 << (level - 1))
    }

    /// Estimated number of cells that are simulated at a time: those of the body, or those of half a ball around a point of its surface, if they are
    /// fewer.
    fn cells(&self, level: u32) -> f64 {
        let edge = self.edge(level);
        // Half of a cell that the surface crosses is outside of the body.
        let volume = self.volume + 0.5 * edge * self.area;
        let radius = self.region.unwrap_or_else(|| region_radius(edge, self.tools.largest));
        (volume / edge.powi(3)).min(2.0 / 3.0 * PI * (radius / edge).powi(3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::generate::cuboid;

    fn surface(size: [f64; 3]) -> Surface {
        Surface::from_document(&cuboid(2, size).unwrap())
    }

    /// Boxes with edges of a 50th of a metre to a metre, in all proportions.
    fn boxes() -> impl Iterator<Item = [f64; 3]> {
        let edge = |i: u32| 0.02 * 50.0_f64.powf(f64::from(i) / 5.0);
        (0..216).map(move |i| [edge(i % 6), edge(i / 6 % 6), edge(i / 36)])
    }

    #[test]
    fn cells_suit_the_smallest_tool_or_are_as_many_as_may_be() {
        let mut seen = [0; 3];
        for (i, size) in boxes().enumerate() {
            let surface = surface(size);
            let smallest = 5e-4 * 2.0_f64.powi(i as i32 % 8);
            let tools = ToolRadii { smallest, largest: 2.0 * smallest };
            for region in [None, Some(4.0 * smallest), Some(f64::INFINITY)] {
                let (level, why) = choose_level(&surface, tools, region);
                let longest = size.into_iter().fold(0.0, f64::max);
                let edge = |level: u32| longest / 2.0_f64.powi(level as i32 - 1);
                // Of the whole box: those inside, and those that it fills or touches.
                let [inside, touched] =
                    [0.0, 1.0].map(|more| move |edge: f64| size.iter().map(|s| s / edge + more).product::<f64>());
                let suits = |level: u32| edge(level) <= 0.5 * smallest;
                assert!(level == 1 || !suits(level - 1), "{size:?} {smallest}: a coarser level suits: {level}");
                assert!(
                    level == 1 || inside(edge(level)) <= MOST_CELLS || region != Some(f64::INFINITY),
                    "{size:?}: {level}"
                );
                let at_limit = !suits(level) && level < FINEST;
                assert!(!at_limit || touched(edge(level + 1)) > MOST_CELLS, "{size:?} {smallest}: {level}");
                assert_eq!(why.contains("would simulate"), at_limit, "{why}");
                seen[usize::from(!suits(level)) + usize::from(at_limit)] += 1;
            }
        }
        assert!(seen.iter().all(|n| *n > 20), "suited, finest, at the limit of cells: {seen:?}");
    }

    #[test]
    fn a_body_without_a_tool_has_the_same_cells_at_any_size() {
        for size in boxes() {
            let (surface, scaled) = (surface(size), surface(size.map(|s| 100.0 * s)));
            let choose = |surface| choose_level(surface, ToolRadii::default(), Some(f64::INFINITY)).0;
            assert_eq!(choose(&surface), choose(&scaled), "{size:?}");
            assert!(choose(&surface) <= WITHOUT_TOOL);
        }
    }

    #[test]
    fn radii_of_tools_are_those_of_the_smallest_and_the_largest() {
        let mut radii = ToolRadii::default();
        [3.0, 2.0, 5.0].into_iter().for_each(|radius| radii.add(radius));
        assert_eq!(radii, ToolRadii { smallest: 2.0, largest: 5.0 });
    }
}
