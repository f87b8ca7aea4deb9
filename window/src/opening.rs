//! From a file to a session: a model becomes a scene with one hand, a scene gets that hand in the place of its own.

use crate::strings;
use crate::tools::ToolKind;
use pliant_editor::{
    DeviceChoice, DeviceRequest, Draft, DraftMaterial, HandSettings, LengthUnit, MAX_PAINTED, SOLIDS, SolidPreset,
    Substance, SubstanceChoice, fabrics, give_hand,
};
use pliant_engine::plan::Plan;
use pliant_engine::scene::{self, Scene, Source};
use pliant_engine::session::{Options, Session};
use pliant_host::{AllowedFolders, Library, PluginKind, SearchPath};
use pliant_mesh::{ObjDocument, Surface, TetMesh};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use toml_edit::DocumentMut;

/// What is to be opened.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenRequest {
    /// The model or scene as the user knows it; Save writes a model there.
    pub path: PathBuf,
    /// Model file that holds the present shape, where that is not the one the user knows.
    pub shape: Option<PathBuf>,
    /// Where shapes are kept after each stroke; `None`: with the user's other state.
    pub autosave: Option<PathBuf>,
    /// Folders with plugins.
    pub plugin_path: Vec<PathBuf>,
    /// Folders from which scenes may name libraries by path.
    pub allow_plugins: Vec<PathBuf>,
    /// Threads of the simulation; 0 for all processors.
    pub threads: usize,
    /// Unit of a model; `None`: guess it.
    pub unit: Option<LengthUnit>,
    /// Solid or sheet; `None`: by what the model encloses.
    pub substance: Option<Substance>,
    /// Whether large faces of a model are divided until a touch shows.
    pub subdivide: bool,
    /// Whether vertices of borders that lie at one place become one; `None`: unless the file says that they are cuts.
    pub weld: Option<bool>,
    /// What a solid is made of.
    pub solid: SolidPreset,
    /// Plugin of a solid's material.
    pub solid_plugin: String,
    /// Fabric of a sheet.
    pub fabric: String,
    /// Level of the grid in a solid.
    pub level: u32,
    /// s, one step of a sheet
    pub sheet_step: f64,
    /// Device that has the hand; `None`: the pointer has it.
    pub device: Option<DeviceRequest>,
}

/// Endings of the names of models and scenes.
pub const MODEL_ENDINGS: [&str; 5] = ["obj", "msh", "vtk", "vtu", "toml"];

/// Whether a file has the name of a model or a scene, in small or large letters.
pub fn is_model_name(path: &Path) -> bool {
    path.extension().is_some_and(|ending| MODEL_ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// The material a new model gets: soft enough for a hand, stiff enough to keep its shape.
pub const DEFAULT_SOLID: usize = 1;
/// Plugin of a material that flows.
const FLOWING_PLUGIN: &str = "neo-hookean";
/// Plugin of a sheet's material.
const SHEET_PLUGIN: &str = "cloth";
/// Fabric of a new sheet.
const DEFAULT_FABRIC: &str = "denim";
/// s, one step of a new scene
const STEP: f64 = 1e-3;
/// s, one step of a new scene with a sheet, whose solver takes longer
const SHEET_STEP: f64 = 4e-3;
/// s, the longest step of a sheet: at more than that its folds move visibly from step to step
const LONGEST_SHEET_STEP: f64 = 16e-3;
/// The coarsest level of a grid that is offered where simulation is slow.
const COARSEST: u32 = 3;

/// What makes a slow simulation faster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Half as many cells along each axis of a solid: the level of its grid.
    CoarserGrid(u32),
    /// Twice the step of a sheet, whose implicit solver takes longer steps: s.
    LongerStep(f64),
}
/// Share of the height of a part of a sheet from the top whose vertices are held: it hangs.
const HELD_SHARE: f64 = 0.02;

impl OpenRequest {
    /// Where plugins are looked for.
    ///
    /// # Errors
    /// An allowed folder that is not there.
    pub fn search(&self) -> Result<SearchPath, String> {
        let allowed = AllowedFolders::new(&self.allow_plugins).map_err(|error| error.to_string())?;
        Ok(SearchPath::new(&self.plugin_path).allow(allowed))
    }

    /// Of a file, with everything else left open.
    pub fn new(path: PathBuf) -> Self {
        Self {
            path,
            shape: None,
            autosave: None,
            plugin_path: Vec::new(),
            allow_plugins: Vec::new(),
            threads: 0,
            unit: None,
            substance: None,
            subdivide: false,
            weld: None,
            solid: SOLIDS[DEFAULT_SOLID],
            solid_plugin: "mass-spring".into(),
            fabric: DEFAULT_FABRIC.into(),
            level: 6,
            sheet_step: SHEET_STEP,
            device: None,
        }
    }

    /// What makes the simulation of this model faster, where there is something that the window can do. A scene says its steps and grids itself, and a
    /// tetrahedral mesh has no other elements.
    pub fn remedy(&self, taken_as: Option<Substance>) -> Option<Remedy> {
        match taken_as? {
            Substance::Solid if self.is_tetrahedral() || self.level <= COARSEST => None,
            Substance::Solid => Some(Remedy::CoarserGrid(self.level - 1)),
            Substance::Sheet => {
                Some(2.0 * self.sheet_step).filter(|dt| *dt <= LONGEST_SHEET_STEP).map(Remedy::LongerStep)
            }
        }
    }

    /// Takes the remedy; it is there once the model is opened anew.
    pub fn take_remedy(&mut self, remedy: Remedy) {
        match remedy {
            Remedy::CoarserGrid(level) => self.level = level,
            Remedy::LongerStep(dt) => self.sheet_step = dt,
        }
    }

    /// Folder that paths of a scene are relative to.
    fn folder(&self) -> &Path {
        self.path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }

    /// Where the `mtllib` files of a model are, also if its present shape is in a file elsewhere; `None` for a scene, whose models have theirs beside them.
    pub fn material_folder(&self) -> Option<&Path> {
        self.path.parent().filter(|_| !self.is_scene())
    }

    /// Whether it is a tetrahedral mesh, which the window reads and does not write.
    pub fn is_tetrahedral(&self) -> bool {
        TetMesh::is_name(&self.path.to_string_lossy())
    }

    /// Whether it is a scene and not a model.
    pub fn is_scene(&self) -> bool {
        self.path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
    }
}

/// What is known of an opened model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFacts {
    /// The hand and the tool it holds.
    pub hand: HandSettings,
    /// What a model was taken for; `None` for a scene, which says it itself.
    pub substance: Option<SubstanceChoice>,
    /// Whether the model is a tetrahedral mesh: a solid without a grid, saved as the OBJ file of its surface.
    pub is_tetrahedral: bool,
    /// What it is taken for now; `None` for a scene.
    pub taken_as: Option<Substance>,
    /// Unit of the model; `None` for a scene.
    pub unit: Option<LengthUnit>,
    /// Number of vertices of a model that lie on borders, where others do; 0 for a scene.
    pub coincident_vertices: usize,
    /// Whether these are joined to the others.
    pub is_welded: bool,
    /// Name of the material of faces that a cut makes.
    pub cap_material: String,
    /// Fabrics that a sheet may be made of.
    pub fabrics: Vec<String>,
    /// Parameters of the material that strokes may paint, in the order of [`PaintStroke::param`](pliant_editor::PaintStroke).
    pub painted: Vec<&'static str>,
    /// Edit kinds that its bodies take; strokes of the others do nothing.
    pub kinds: BTreeSet<&'static str>,
    /// Devices of the scene that can have the hand; none for a model.
    pub devices: Vec<DeviceChoice>,
}

impl ModelFacts {
    /// Why strokes of a tool do nothing, for people; `None` if they do something.
    pub fn why_idle(&self, tool: ToolKind) -> Option<String> {
        match self.kinds.contains(tool.name()) {
            true => None,
            false if tool.paints() => Some(strings::NOTHING_TO_PAINT.to_owned()),
            false => Some(strings::undivided(tool.name())),
        }
    }
}

/// An opened session and what is known of its model.
pub struct Opened {
    /// The opened session.
    pub session: Session,
    /// What was opened, with the window's hand.
    pub scene: Scene,
    /// Text of the scene, for error messages that name its lines.
    pub source: Source,
    /// Model in the place of the scene's first.
    pub mesh: Option<PathBuf>,
    /// What is known of it.
    pub facts: ModelFacts,
}

/// Opens a model or a scene.
///
/// # Errors
/// A sentence with file, place and cause.
pub fn open(request: &OpenRequest) -> Result<Opened, String> {
    let (text, mut facts) = if request.is_scene() { scene_text(request)? } else { model_text(request)? };
    let in_folder = request.path.with_extension("pliant.toml");
    let file = if request.is_scene() { &request.path } else { &in_folder };
    let (scene, source) = scene::load_text(file, text, &[]).map_err(|error| error.to_string())?;
    let plan = Plan::new(&scene, &source).map_err(|error| error.to_string())?;
    facts.cap_material.clone_from(&plan.cap_material);
    facts.kinds = plan.edits.iter().map(|edit| edit.kind.name()).collect();
    let search = request.search()?;
    let mesh = request.shape.clone().filter(|_| request.is_scene());
    let options = Options { mesh: mesh.clone(), ..Options::new(search, request.threads) };
    let session = Session::open(&scene, &source, plan, &options).map_err(|error| error.to_string())?;
    if session.bodies.is_empty() {
        return Err(strings::nothing_moves(&request.path));
    }
    Ok(Opened { session, scene, source, mesh, facts })
}

/// The text of the scene of a model.
fn model_text(request: &OpenRequest) -> Result<(String, ModelFacts), String> {
    let file = request.shape.as_ref().unwrap_or(&request.path);
    let is_tetrahedral = TetMesh::is_name(&file.to_string_lossy());
    let mut document = match is_tetrahedral {
        true => TetMesh::read(file).and_then(|mesh| mesh.surface()).map_err(|error| error.to_string())?,
        false => ObjDocument::read(file).map_err(|error| error.to_string())?,
    };
    let mut surface = Surface::from_document(&document);
    let mut seen = SubstanceChoice::of(&surface);
    let is_whole = is_tetrahedral || seen.openings == 0;
    let coincident = if is_whole { Vec::new() } else { document.coincident_borders(&surface, 0.0) };
    let weld = request.weld.unwrap_or(!document.has_cut_borders()) && !coincident.is_empty();
    if weld {
        document.weld(&coincident);
        surface = Surface::from_document(&document);
        seen = SubstanceChoice::of(&surface);
    }
    let bounds = surface.bounds();
    let extent = bounds.longest_edge();
    if !(extent > 0.0 && extent.is_finite()) {
        return Err(strings::one_point(file));
    }
    let unit = request.unit.unwrap_or_else(|| LengthUnit::guess(extent));
    // A tetrahedral mesh is a solid, whatever its surface is like.
    let taken_as = if is_tetrahedral { Substance::Solid } else { request.substance.unwrap_or(seen.substance) };
    let material = match taken_as {
        Substance::Solid => {
            let flows = request.solid.flow.is_some();
            let plugin = if flows { FLOWING_PLUGIN.into() } else { request.solid_plugin.clone() };
            DraftMaterial::Solid { plugin, preset: request.solid, level: request.level }
        }
        Substance::Sheet => {
            DraftMaterial::Sheet { plugin: SHEET_PLUGIN.into(), fabric: request.fabric.clone(), held: tops(&surface) }
        }
    };
    let dt = if taken_as == Substance::Solid { STEP } else { request.sheet_step };
    let mesh = std::path::absolute(file).unwrap_or_else(|_| file.clone());
    let (subdivide, scale) = (request.subdivide, unit.metres());
    let is_welded = (!coincident.is_empty()).then_some(weld);
    let draft = Draft { mesh, scale, size: extent * scale, subdivide, weld: is_welded, material, dt };
    let folder = std::path::absolute(&request.path).unwrap_or_else(|_| request.path.clone());
    let text = draft.to_toml(folder.parent().unwrap_or(Path::new("/")));
    let facts = ModelFacts {
        hand: draft.hand(),
        substance: Some(seen),
        is_tetrahedral,
        taken_as: Some(taken_as),
        unit: Some(unit),
        coincident_vertices: coincident.len(),
        is_welded: weld,
        cap_material: String::new(),
        fabrics: fabrics_of(&request.search()?),
        painted: draft.painted().to_vec(),
        kinds: BTreeSet::new(),
        devices: Vec::new(),
    };
    Ok((text, facts))
}

/// Vertices at the top of each connected part of a sheet, by which it hangs, and those beside them: a part that nothing holds would drift away from a push, and
/// one that is held by a line alone would turn about it for ever.
fn tops(surface: &Surface) -> Vec<u32> {
    let shells = surface.shells();
    let heights = |triangle: usize| surface.triangles[triangle].map(|v| surface.points[v as usize].y);
    let mut extents: Vec<[f64; 2]> = Vec::new();
    for (triangle, shell) in shells.iter().enumerate() {
        let [a, b, c] = heights(triangle);
        extents.resize(extents.len().max(*shell as usize + 1), [f64::INFINITY, f64::NEG_INFINITY]);
        let [low, high] = &mut extents[*shell as usize];
        (*low, *high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
    }
    let corners = surface.triangles.iter().zip(&shells).flat_map(|(triangle, shell)| triangle.map(|v| (v, *shell)));
    let is_top = |(v, shell): &(u32, u32)| {
        let [low, high] = extents[*shell as usize];
        surface.points[*v as usize].y >= high - HELD_SHARE * (high - low)
    };
    let mut held: Vec<u32> = corners.filter(is_top).map(|(v, _)| v).collect();
    held.sort_unstable();
    held.dedup();
    let is_beside = |triangle: &&[u32; 3]| triangle.iter().any(|v| held.binary_search(v).is_ok());
    let mut clamped: Vec<u32> = surface.triangles.iter().filter(is_beside).flatten().copied().collect();
    clamped.sort_unstable();
    clamped.dedup();
    clamped
}

/// Fabrics that the material of sheets offers; none where it is not there.
fn fabrics_of(search: &SearchPath) -> Vec<String> {
    let info = || {
        let found = search.find(SHEET_PLUGIN, Path::new(".")).ok()?;
        let library = Library::open(&found.path).ok()?;
        library.plugin(PluginKind::Material, SHEET_PLUGIN).ok()
    };
    info().map(fabrics).unwrap_or_default()
}

/// Parameters that strokes may paint where the material of a scene lets them vary.
const PAINTABLE: [&str; MAX_PAINTED] = ["young", "density", "thickness"];

/// A session of the bodies of a scene under some hand of the window: devices of the scene may not be there, and nobody holds them.
///
/// # Errors
/// A sentence with file, place and cause.
fn look(scene: &Scene, source: &Source, document: &DocumentMut, request: &OpenRequest) -> Result<Session, String> {
    let radius = scene.tool.iter().find_map(|tool| Some(tool.radius.as_ref()?.get_ref().si)).unwrap_or(FIRST_RADIUS);
    let hand = HandSettings { size: 1.0, radius, coupling: 1.0, peak_force: 1.0, pressure: 1.0, tip_mass: None };
    let mut document = document.clone();
    give_hand(&mut document, &hand, &[]);
    let (with_hand, _) =
        scene::load_text(&request.path, document.to_string(), &[]).map_err(|error| error.to_string())?;
    // All else stays that of the file, so errors name its lines.
    let Scene { device, tool, edit, probe, .. } = with_hand;
    let scene = Scene { device, tool, edit, probe, ..scene.clone() };
    let plan = Plan::new(&scene, source).map_err(|error| error.to_string())?;
    let options = Options { mesh: request.shape.clone(), ..Options::new(request.search()?, 1) };
    Session::open(&scene, source, plan, &options).map_err(|error| error.to_string())
}

/// Radius of a tool in a scene that has none, m.
const FIRST_RADIUS: f64 = 0.005;

/// The text of a scene with the window's hand in the place of its own.
fn scene_text(request: &OpenRequest) -> Result<(String, ModelFacts), String> {
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", request.path.display());
    // As the engine reads it, for its errors name line and column.
    let (scene, source) = scene::load(&request.path, &[]).map_err(|error| error.to_string())?;
    Plan::new(&scene, &source).map_err(|error| error.to_string())?;
    let mut document: DocumentMut = source.text.parse().map_err(|error: toml_edit::TomlError| named(&error))?;
    // A look at the bodies, to know how large a hand they ask for.
    let session = look(&scene, &source, &document, request)?;
    let surfaces = session.bodies.iter().map(|body| &body.model.surface);
    let standing = session.standing.iter().map(|(_, model)| &model.surface);
    let size = surfaces.chain(standing).map(|surface| surface.bounds().longest_edge()).fold(0.0, f64::max);
    let young = scene.body.iter().find_map(|body| {
        let value = body.material.params.get("young")?.get_ref();
        let number = || value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
        number().or_else(|| scene::parse_quantity(value.as_str()?, "Pa").ok())
    });
    let mut preset = request.solid;
    preset.young = young.unwrap_or(preset.young);
    let is_sheet = scene.body.iter().all(|body| body.sheet.is_some());
    let material = if is_sheet {
        DraftMaterial::Sheet { plugin: SHEET_PLUGIN.into(), fabric: DEFAULT_FABRIC.into(), held: Vec::new() }
    } else {
        DraftMaterial::Solid { plugin: request.solid_plugin.clone(), preset, level: request.level }
    };
    let dt = scene.time.dt.get_ref().si;
    let draft = Draft { mesh: PathBuf::new(), scale: 1.0, size, subdivide: false, weld: None, material, dt };
    let hand = draft.hand();
    // What the material of any body lets vary.
    let varies = |param: &&str| session.bodies.iter().any(|body| body.params.iter().any(|key| key == param));
    let painted: Vec<&'static str> = PAINTABLE.into_iter().filter(varies).collect();
    give_hand(&mut document, &hand, &painted);
    let choice = |device: &scene::DeviceScene| {
        let (name, request) = (device.name.get_ref().clone(), DeviceRequest::of_scene(device, request.folder())?);
        Some(DeviceChoice { name, summary: request.plugin.clone(), request })
    };
    let devices = scene.device.iter().filter_map(choice).collect();
    let facts = ModelFacts {
        hand,
        substance: None,
        is_tetrahedral: false,
        taken_as: None,
        unit: None,
        coincident_vertices: 0,
        is_welded: false,
        cap_material: String::new(),
        fabrics: Vec::new(),
        painted,
        kinds: BTreeSet::new(),
        devices,
    };
    Ok((document.to_string(), facts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_solid_gets_a_coarser_grid_and_a_slow_sheet_longer_steps_until_there_is_nothing_more() {
        let open = |name: &str| OpenRequest::new(PathBuf::from(name));
        for (taken_as, least) in [(Substance::Solid, 3), (Substance::Sheet, 2)] {
            let mut request = open("a.obj");
            let mut count = 0;
            while let Some(remedy) = request.remedy(Some(taken_as)) {
                let before = request.clone();
                request.take_remedy(remedy);
                assert_ne!(request, before, "{remedy:?}");
                count += 1;
                assert!(count < 20);
            }
            assert_eq!(count, least, "{taken_as:?}");
            assert!(request.level >= COARSEST && request.sheet_step <= LONGEST_SHEET_STEP);
        }
        assert_eq!(open("a.msh").remedy(Some(Substance::Solid)), None, "its elements are those of the file");
        assert_eq!(open("a.toml").remedy(None), None, "the scene says what it is");
    }
}
