//! What viewers show of painting: for each vertex that is pinned or painted a number, its tint.

use super::{Body, Discretization, LatticeError, Skin};

/// Tint of a pinned vertex; that of a painted one is the decimal logarithm of its factor, -1 to 1.
pub const PINNED_TINT: f32 = 2.0;

/// Tints of the vertices that are pinned or painted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tints {
    /// Vertices, ascending, each with its tint.
    list: Vec<(u32, f32)>,
    /// Number of times that pins, factors or vertices have changed.
    changes: u64,
}

/// The tint of a vertex; 0 if it is neither pinned nor painted.
pub fn tint_of(tints: &[(u32, f32)], vertex: u32) -> f32 {
    tints.binary_search_by_key(&vertex, |(of, _)| *of).map_or(0.0, |at| tints[at].1)
}

impl Body {
    /// Tints of the vertices that are pinned or painted, ascending.
    pub fn tints(&self) -> &[(u32, f32)] {
        &self.tints.list
    }

    /// Counts changes of what is pinned or painted, and of the vertices that it is listed by.
    pub fn paint_changes(&self) -> u64 {
        self.tints.changes
    }

    /// The surface, to be updated by a viewer, and the tints of its vertices.
    pub fn skin_with_tints(&mut self) -> (&mut Skin, &[(u32, f32)]) {
        (&mut self.skin, &self.tints.list)
    }

    /// Lists the tints anew after pins, factors or vertices have changed, and marks the pages of vertices whose tint has.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn update_tints(&mut self) -> Result<(), LatticeError> {
        let mut tints = self.painted_vertices()?;
        tints.extend(self.pinned_vertices().map(|vertex| (vertex, PINNED_TINT)));
        // Pins are shown over paint, and of several factors the largest change.
        tints.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.abs().total_cmp(&a.1.abs())).then(a.1.total_cmp(&b.1)));
        tints.dedup_by_key(|(vertex, _)| *vertex);
        let differs = |own: &[(u32, f32)], (vertex, tint): (u32, f32)| tint_of(own, vertex) != tint;
        let pages = &mut self.skin.pages;
        let before = &self.tints.list;
        tints.iter().filter(|at| differs(before, **at)).for_each(|(vertex, _)| pages.mark(*vertex));
        before.iter().filter(|at| differs(&tints, **at)).for_each(|(vertex, _)| pages.mark(*vertex));
        self.tints = Tints { list: tints, changes: self.tints.changes + 1 };
        Ok(())
    }

    /// Tint of every vertex of a painted cell or triangle, several of a vertex in several triangles.
    fn painted_vertices(&self) -> Result<Vec<(u32, f32)>, LatticeError> {
        let mut all = Vec::new();
        for (element, factors) in self.painted().elements() {
            let logs = factors.iter().map(|factor| libm::log10(*factor));
            let tint = logs.fold(0.0, |most: f64, log| if log.abs() > most.abs() { log } else { most }) as f32;
            match &self.discretization {
                _ if tint == 0.0 => {}
                Discretization::Lattice(lattice) => lattice.for_points_of_cell(element, |v| all.push((v, tint)))?,
                Discretization::Sheet(_) => {
                    let corners = self.model.surface.triangles.get(element as usize);
                    all.extend(corners.into_iter().flatten().map(|v| (*v, tint)));
                }
            }
        }
        Ok(all)
    }
}
