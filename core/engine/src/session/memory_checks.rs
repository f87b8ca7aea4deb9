//! Checks of the memory of models, grids and regions before they are allocated.

use super::SessionError;
use super::opening::{Opening, region_radius};
use super::shared::SharedModel;
use crate::body::Lattice;
use crate::memory::{
    CellCosts, MemoryAccount, TETRAHEDRA_OF_CUBE, document_bytes, file_bytes, format_bytes, grid_bytes, sample_bytes,
    shape_bytes, sheet_bytes, tetrahedra_bytes,
};
use crate::scene::{BodyScene, ShapeKind, ShapeScene, Source};
use pliant_host::Material;
use pliant_mesh::generate::MAX_CELLS;
use pliant_mesh::{ObjDocument, TetMesh};
use pliant_plugin_api::abi::Level;
use pliant_solver::ForceModel;
use std::f64::consts::PI;
use std::path::Path;

/// Finest level whose grid is checked before it is built, of 0.7 GB. Finer ones are left to the plugin, which says which it can do: a grid that has
/// them is sparse, and nothing follows from the number of cubes.
const FINEST_CHECKED: u32 = 10;

/// A body in messages.
fn body_called(scene: &BodyScene) -> String {
    format!("body `{}`", scene.name.get_ref())
}

/// Checks of one body's model against the account of the session.
pub(super) struct ModelCheck<'a> {
    pub(super) scene: &'a BodyScene,
    pub(super) source: &'a Source,
    pub(super) account: &'a MemoryAccount,
}

impl ModelCheck<'_> {
    /// Checks a file before it is read.
    pub(super) fn file(&self, path: &Path) -> Result<(), SessionError> {
        let size = std::fs::metadata(path).map_or(0, |facts| facts.len());
        self.check(file_bytes(size), || format!("the model {} of {}", path.display(), format_bytes(size)))
    }

    /// Checks a document before a model is made of it.
    pub(super) fn document(&self, document: &ObjDocument) -> Result<(), SessionError> {
        let counts = || {
            let (vertices, faces) = (document.positions().len(), document.face_count());
            format!("the model {} of {vertices} vertices and {faces} faces", document.name().display())
        };
        self.check(document_bytes(document), counts)
    }

    /// Checks a tetrahedral mesh before cells are made of it.
    pub(super) fn tetrahedra(&self, mesh: &TetMesh) -> Result<(), SessionError> {
        let (nodes, tetrahedra) = (mesh.points.len(), mesh.tetrahedra.len());
        let what = || format!("the model {} of {nodes} nodes and {tetrahedra} tetrahedra", mesh.name().display());
        self.check(tetrahedra_bytes(nodes as u64, tetrahedra as u64), what)
    }

    /// Checks a document before its faces are divided into four.
    pub(super) fn subdivision(&self, document: &ObjDocument) -> Result<(), SessionError> {
        let faces = document.faces_subdivided();
        let what = || format!("the model {} subdivided to {faces} faces", document.name().display());
        self.check(4 * document_bytes(document), what)
    }

    /// Checks a shape before it is generated.
    pub(super) fn shape(&self, shape: &ShapeScene) -> Result<(), SessionError> {
        if shape.cells.max(shape.rows) > MAX_CELLS {
            return Ok(()); // it is refused for its cells
        }
        let (cells, rows) = (u64::from(shape.cells), u64::from(shape.rows));
        let triangles = match shape.kind {
            ShapeKind::Box | ShapeKind::Sphere => 12 * cells * cells,
            // Rows of 0 make cells square: as many as columns, times the proportion of the sides.
            ShapeKind::Sheet if rows == 0 => {
                (2.0 * cells as f64 * cells as f64 * shape.size[1].si / shape.size[0].si) as u64
            }
            ShapeKind::Sheet => 2 * cells * rows,
            ShapeKind::Cylinder => 8 * cells * (cells + 1),
        };
        self.check(shape_bytes(triangles), || format!("a shape of {cells} cells along an edge"))
    }

    fn check(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), SessionError> {
        if bytes <= self.account.left() {
            return Ok(());
        }
        let checked = self.account.check(&body_called(self.scene), bytes, &what(), |_| None);
        checked.map_err(|text| SessionError::Memory(self.source.error(self.scene.name.span(), text)))
    }
}

impl Opening<'_> {
    /// Checks the levels of a grid before they are built.
    pub(super) fn check_grid(&mut self, scene: &BodyScene, index: usize, level: u32) -> Result<(), SessionError> {
        if level > FINEST_CHECKED {
            return Ok(());
        }
        let bytes = grid_bytes(level);
        let what = format!("the levels of a grid to level {level}");
        let coarser = |_| Some("use a coarser level".into());
        let checked = self.memory.check(&body_called(scene), bytes, &what, coarser);
        checked.map_err(|text| SessionError::Memory(self.source.error(scene.grid.get_ref().level.span(), text)))?;
        self.memory.update(index, |body| body.grid = bytes);
        Ok(())
    }

    /// Checks the nodes, elements, samples and solver of a lattice whose grid is built, and limits its region to what the budget has room for.
    pub(super) fn check_lattice(
        &mut self,
        scene: &BodyScene,
        index: usize,
        shared: &SharedModel,
        material: &Material,
        lattice: &mut Lattice,
    ) -> Result<(), SessionError> {
        let costs = CellCosts::new(material.requests(), TETRAHEDRA_OF_CUBE, self.is_implicit);
        let radius = scene.grid.get_ref().radius.as_ref().map(|r| r.get_ref().si);
        let whole = lattice.is_whole();
        let largest_tool = self.tool_radii.largest;
        let cells_of = |facts: &Level| {
            let occupied = (facts.surface_cells + facts.inside_cells) as f64;
            if whole {
                return occupied;
            }
            let radius = radius.unwrap_or_else(|| region_radius(facts.edge, largest_tool));
            // Half of a ball with its border, because contacts are at the surface. A region that grows further meets `most_cells`.
            let ball = 2.0 / 3.0 * PI * (radius / facts.edge + 2.0).powi(3);
            occupied.min(self.regions.max(1) as f64 * ball)
        };
        let surface = &shared.model.surface;
        let has_samples = largest_tool > 0.0;
        let parts_of = |facts: &Level| {
            let samples = if has_samples { sample_bytes(surface, facts.edge) } else { 0 };
            (samples, (cells_of(facts) * costs.per_simulated_cell(facts)) as u64)
        };
        let facts = lattice.facts;
        let (samples, elements) = parts_of(&facts);
        let source = &lattice.source;
        let fitting = |left: u64| {
            let left = left.saturating_add(grid_bytes(facts.level));
            let fits = (1..facts.level).rev().find_map(|level| {
                let facts = source.level(level).ok()?;
                let (samples, elements) = parts_of(&facts);
                let bytes = samples.saturating_add(elements).saturating_add(grid_bytes(level));
                (bytes <= left).then_some((level, bytes))
            });
            let (level, bytes) = fits?;
            Some(format!("use level {level}, of about {}", format_bytes(bytes)))
        };
        let cells = cells_of(&facts);
        let what = format!("{cells:.0} simulated cells of level {} and its surface", facts.level);
        let bytes = samples.saturating_add(elements);
        let checked = self.memory.check(&body_called(scene), bytes, &what, fitting);
        checked.map_err(|text| SessionError::Memory(self.source.error(scene.grid.get_ref().level.span(), text)))?;
        self.memory.update(index, |body| (body.samples, body.elements) = (samples, elements));
        let more = self.memory.left() as f64 / costs.per_simulated_cell(&facts);
        lattice.most_cells = (cells + more) as usize;
        Ok(())
    }

    /// Checks the nodes, elements, samples and solver of a body of tetrahedra.
    pub(super) fn check_tetrahedra(
        &mut self,
        scene: &BodyScene,
        index: usize,
        shared: &SharedModel,
        material: &Material,
        facts: &Level,
    ) -> Result<(), SessionError> {
        let weights = shared.model.tetrahedra.as_ref().and_then(|cells| cells.corner_weights());
        let costs = match weights {
            Some(weights) => CellCosts::of_quadratic_tetrahedra(material.requests(), weights.parts(), self.is_implicit),
            None => CellCosts::new(material.requests(), 1.0, self.is_implicit),
        };
        let has_samples = self.tool_radii.largest > 0.0;
        let samples = if has_samples { sample_bytes(&shared.model.surface, facts.edge) } else { 0 };
        let cells = facts.surface_cells + facts.inside_cells;
        let elements = (cells as f64 * costs.per_simulated_cell(facts)) as u64;
        let what = format!("{cells} tetrahedra and their surface");
        let checked = self.memory.check(&body_called(scene), samples.saturating_add(elements), &what, |_| None);
        checked.map_err(|text| SessionError::Memory(self.source.error(scene.name.span(), text)))?;
        let tetrahedra = tetrahedra_bytes(facts.nodes, cells);
        self.memory.update(index, |body| {
            (body.samples, body.elements) = (samples, elements);
            body.model = body.model.saturating_add(tetrahedra);
        });
        Ok(())
    }

    /// Checks the nodes, elements and solver of a sheet of this many triangles.
    pub(super) fn check_sheet(
        &mut self,
        scene: &BodyScene,
        index: usize,
        triangles: usize,
    ) -> Result<(), SessionError> {
        let bytes = sheet_bytes(triangles as u64, self.is_implicit);
        let what = format!("a sheet of {triangles} triangles");
        let checked = self.memory.check(&body_called(scene), bytes, &what, |_| None);
        checked.map_err(|text| SessionError::Memory(self.source.error(scene.name.span(), text)))?;
        self.memory.update(index, |body| body.elements = bytes);
        Ok(())
    }
}
