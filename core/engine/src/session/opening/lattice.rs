//! Opening of the lattice of a solid: the cells of a grid, or the tetrahedra of its file.

use super::Opening;
use crate::body::{CellSource, Lattice, LatticeError, RegionSettings, TetrahedralCells};
use crate::scene::{BodyScene, Extent, Level};
use crate::session::level_choice::{LevelChosen, choose_level};
use crate::session::shared::SharedModel;
use crate::session::{EventKind, SessionError};
use bytemuck::cast_slice;
use pliant_host::{Grid, HostError, Material, PluginKind};
use pliant_plugin_api::abi;
use pliant_solver::ForceModel;
use std::sync::Arc;

/// Default radius of a local region: the larger one of this many cells and of [`REGION_TOOL_RADII`] radii of the largest tool. A contact of radius a in
/// a region of radius Rb with a fixed boundary is too stiff by the factor (1 + 0.584 a/Rb)^1.5, at most 1.21 at four radii.
const REGION_CELLS: f64 = 10.0;
const REGION_TOOL_RADII: f64 = 4.0;

/// Default radius of a local region of cells with this edge, m, with a largest tool of this radius, m.
pub(in crate::session) fn region_radius(edge: f64, largest_tool: f64) -> f64 {
    (REGION_CELLS * edge).max(REGION_TOOL_RADII * largest_tool)
}

impl Opening<'_> {
    /// The lattice of the cells of a grid.
    pub(super) fn lattice(
        &mut self,
        scene: &BodyScene,
        index: usize,
        shared: &SharedModel,
        material: &Material,
    ) -> Result<Lattice, SessionError> {
        let name = scene.name.get_ref();
        let families = material.requests().iter().fold(0, |all, r| all | r.families);
        let (library, info, settings) =
            self.plugin(PluginKind::Grid, &scene.grid.get_ref().plugin, &scene.grid.get_ref().params)?;
        let radius = match scene.grid.get_ref().region {
            Extent::Whole => Some(f64::INFINITY),
            Extent::Local => scene.grid.get_ref().radius.as_ref().map(|r| r.get_ref().si),
        };
        let level = match *scene.grid.get_ref().level.get_ref() {
            Level::At(level) => level,
            Level::Auto => {
                let (level, why) = choose_level(&shared.model.surface, self.tool_radii, radius);
                self.levels.push(LevelChosen { body: name.clone(), level, why });
                level
            }
        };
        let relaxation = scene.grid.get_ref().relaxation.get_ref().si;
        // Slopes that are continued across a crack would know what is on its other side.
        let can_fail = material.requests().iter().any(|r| r.kind == abi::TETRAHEDRON && r.flags & abi::CAN_FAIL != 0);
        let region = RegionSettings {
            level,
            radius: radius.unwrap_or(0.0),
            relaxation,
            smooth: scene.grid.get_ref().smooth.as_ref().is_none_or(|smooth| *smooth.get_ref()) && !can_fail,
        };
        let (number, path, dt) = (shared.number, library.path().display(), self.dt);
        let key = format!("{number} {level} {dt:e} {path} {} {settings:?}", info.id);
        let grid = match self.shared.idle_grid(&key) {
            Some(grid) => grid,
            None => {
                self.check_grid(scene, index, level)?;
                let mut grid = Grid::open(library, &info.id, &settings, self.dt)
                    .map_err(|error| self.refused(scene.grid.get_ref().level.span(), error))?;
                let surface = &shared.model.surface;
                let built = grid.build(cast_slice(&surface.points), &surface.triangles, level);
                built.map_err(|error| self.level_refused(scene, level, surface.bounds().longest_edge(), error))?;
                grid
            }
        };
        let grid = CellSource::Grid(self.shared.pool(key.clone(), grid));
        let mut lattice = Lattice::new(grid, key, region, families).map_err(|error| {
            if let LatticeError::Host(error) = error {
                return self.refused(scene.grid.get_ref().level.span(), error);
            }
            SessionError::Lattice { body: name.clone(), error }
        })?;
        if radius.is_none() {
            lattice.settings.radius = region_radius(lattice.edge(), self.tool_radii.largest);
        }
        self.check_lattice(scene, index, shared, material, &mut lattice)?;
        Ok(lattice)
    }

    /// The lattice of the tetrahedra of a file, simulated as a whole.
    pub(super) fn tetrahedra(
        &mut self,
        scene: &BodyScene,
        index: usize,
        shared: &SharedModel,
        cells: Arc<TetrahedralCells>,
        material: &Material,
    ) -> Result<Lattice, SessionError> {
        self.check_tetrahedra(scene, index, shared, material, &cells.facts())?;
        let can_fail = material.requests().iter().any(|r| r.flags & abi::CAN_FAIL != 0);
        let refused = match (cells.corner_weights(), can_fail, material.info().whole_lists) {
            (Some(_), true, _) => Some("can fail, and its mesh has quadratic tetrahedra of 10 nodes, which cannot"),
            (Some(_), _, true) => {
                Some("wants whole lists, and its mesh has quadratic tetrahedra of 10 nodes, which are called in parts")
            }
            _ => None,
        };
        if let Some(why) = refused {
            let (id, name) = (&material.info().id, scene.name.get_ref());
            let text = format!(
                "material `{id}` of body `{name}` {why}; allowed are tetrahedra of 4 nodes (`gmsh -3 -order 1`)"
            );
            return Err(self.source.error(scene.material.plugin.span(), text).into());
        }
        for note in cells.mesh().notes.iter().filter(|note| !note.is_doubtful()) {
            self.events.add(EventKind::Model, 0.0, || format!("body `{}`: {note}", scene.name.get_ref()));
        }
        // Nothing of a whole body returns to rest, so the relaxation is not used.
        let settings = RegionSettings { level: 1, radius: f64::INFINITY, relaxation: 1.0, smooth: false };
        let key = format!("{} tetrahedra", shared.number);
        let made = Lattice::new(CellSource::Tetrahedra(cells), key, settings, 0);
        made.map_err(|error| SessionError::Lattice { body: scene.name.get_ref().clone(), error })
    }

    /// The error of a grid that refuses a level for a body with this longest edge (m). Suggests the coarsest level whose cells are at most as wide
    /// as the radius of the largest tool.
    fn level_refused(&self, scene: &BodyScene, level: u32, longest: f64, error: HostError) -> SessionError {
        let span = scene.grid.get_ref().level.span();
        let edge = |level: u32| longest / (1_u64 << (level - 1)) as f64;
        // The cell edge halves from level to level; 64 levels exceed the range of a shift.
        let fitting = (1..level.min(64)).find(|&level| edge(level) <= self.tool_radii.largest);
        let Some(fitting) = fitting.filter(|_| error.is_refusal()) else {
            return self.refused(span, error);
        };
        let [edge, radius] = [edge(fitting), self.tool_radii.largest].map(|length| 1e3 * length);
        let text =
            format!("{error}; level {fitting}, with cells of {edge:.3} mm, fits the tool, of radius {radius:.3} mm");
        self.source.error(span, text).into()
    }
}
