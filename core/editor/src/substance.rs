//! Choice between solid and sheet for a model: closed models are solids, open models are sheets.

use pliant_mesh::Surface;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Kind of body for a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Substance {
    /// Solid: the surface is embedded in a grid.
    Solid,
    /// Sheet: the vertices of the surface are the nodes.
    Sheet,
}

/// The chosen kind of body with the properties it follows from.
#[derive(Clone, Debug, PartialEq)]
pub struct SubstanceChoice {
    /// The chosen kind.
    pub substance: Substance,
    /// Number of loops of border edges.
    pub openings: usize,
    /// Length of the longest loop, in units of the surface; 0 without one.
    pub longest_opening: f64,
}

/// Length of a loop of border edges, relative to the longest edge of the model's bounding box, above which it counts as an opening, like the end of a sleeve;
/// a shorter loop counts as a hole of a scan.
const OPENING: f64 = 1.0;

impl SubstanceChoice {
    /// Chooses the kind of body from the borders of a surface.
    pub fn of(surface: &Surface) -> Self {
        let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
        for ([a, b], sides) in surface.edges().iter().filter(|(_, sides)| sides.len() == 1) {
            let (from, to) = if sides[0].upward { (a, b) } else { (b, a) };
            next.entry(from).or_default().push(to);
        }
        let mut starts: Vec<u32> = next.keys().copied().collect();
        starts.sort_unstable();
        let (mut openings, mut longest) = (0, 0.0_f64);
        for start in starts {
            let (mut at, mut length, mut edges) = (start, 0.0, 0);
            while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
                length += (surface.points[to as usize] - surface.points[at as usize]).norm();
                edges += 1;
                at = to;
            }
            openings += usize::from(edges > 0);
            longest = longest.max(length);
        }
        let open = longest > OPENING * surface.bounds().longest_edge();
        let substance = if open { Substance::Sheet } else { Substance::Solid };
        Self { substance, openings, longest_opening: longest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::generate::{self, Pattern};

    #[test]
    fn closed_models_and_small_holes_are_solids_and_cloth_is_not() {
        let mut ball = Surface::from_document(&generate::sphere(8, 0.05).unwrap());
        assert_eq!(
            SubstanceChoice::of(&ball),
            SubstanceChoice { substance: Substance::Solid, openings: 0, longest_opening: 0.0 }
        );
        ball.triangles.truncate(ball.triangles.len() - 1);
        let holed = SubstanceChoice::of(&ball);
        assert_eq!((holed.substance, holed.openings), (Substance::Solid, 1));
        let cloth = Surface::from_document(&generate::grid([8, 8], [0.2, 0.2], Pattern::Regular).unwrap());
        let cloth = SubstanceChoice::of(&cloth);
        assert_eq!((cloth.substance, cloth.openings), (Substance::Sheet, 1));
        assert!((cloth.longest_opening - 0.8).abs() < 1e-12);
    }
}
