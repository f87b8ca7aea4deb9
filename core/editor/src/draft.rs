//! Default scene for a model without one, which `edit model.obj` opens.

use crate::hand_scene::{HandSettings, give_hand, tables};
use crate::preset::SolidPreset;
use crate::substance::Substance;
use pliant_mesh::TetMesh;
use std::path::{Path, PathBuf};
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value, value};

/// Name of the body in a drafted scene.
pub const BODY: &str = "model";

/// Material of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum DraftMaterial {
    /// A solid embedded in a grid.
    Solid {
        /// Plugin of the material; one with plastic flow for a preset that flows.
        plugin: String,
        /// Parameters of the material.
        preset: SolidPreset,
        /// Level of the grid.
        level: u32,
    },
    /// A sheet of a fabric.
    Sheet {
        /// Plugin of the material.
        plugin: String,
        /// Value of its parameter `fabric`.
        fabric: String,
        /// Indices of fixed vertices.
        held: Vec<u32>,
    },
}

/// A scene with one model and one hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// OBJ file of the model.
    pub mesh: PathBuf,
    /// Metres per file unit.
    pub scale: f64,
    /// Longest edge of the model's bounding box, m.
    pub size: f64,
    /// Whether large faces are divided until a touch shows.
    pub subdivide: bool,
    /// Whether vertices of borders that lie at one place become one; `None` leaves it to the default of a scene.
    pub weld: Option<bool>,
    /// Material of the body.
    pub material: DraftMaterial,
    /// Size of a step of simulated time, s.
    pub dt: f64,
}

/// Radius of the tool relative to the size of the model.
pub const TOOL_SHARE: f64 = 0.04;
/// Stiffness of the coupling relative to that of a ball pressed into a half-space by its radius, about 2 E r: stiff enough that the surface follows the
/// hand, soft enough to be stable.
const COUPLING_SHARE: f64 = 2.0;
/// Largest force of the hand relative to that which compresses the coupling by the radius of the tool.
const PEAK_SHARE: f64 = 4.0;
/// Stiffness of the coupling on a sheet of 100 mm, N/m; the mass of its tip is that of a live run, 10 g.
const SHEET_COUPLING: f64 = 200.0;
/// Plugin of the material of a tetrahedral mesh.
const TETRAHEDRAL_PLUGIN: &str = "neo-hookean";
/// Pressure of an inflating stroke relative to Young's modulus: a bulge of about a seventh of the region's radius, which is seen at once, and three times as high at the
/// greatest strength.
const PRESSURE_SHARE: f64 = 0.25;
/// Pressure of an inflating stroke on a sheet, some twenty times the weight of a cloth, Pa.
const SHEET_PRESSURE: f64 = 50.0;
/// Speed below which a body comes to rest, in sizes of the model per second. A sheet of 100 mm that swings freely, once in a second, is so slow for 0.1 s at the
/// end of a swing of 0.2 mm.
const SLEEP_SHARE: f64 = 3e-3;
/// Mass of a tip on a sheet, as in a live run, kg.
const TIP_MASS: f64 = 0.01;

impl Draft {
    /// The kind of body.
    pub fn substance(&self) -> Substance {
        match self.material {
            DraftMaterial::Solid { .. } => Substance::Solid,
            DraftMaterial::Sheet { .. } => Substance::Sheet,
        }
    }

    /// Whether the file is a tetrahedral mesh, which is simulated on its own elements, without a grid.
    pub fn is_tetrahedral(&self) -> bool {
        TetMesh::is_name(&self.mesh.to_string_lossy())
    }

    /// Radius of the tool, m.
    pub fn radius(&self) -> f64 {
        TOOL_SHARE * self.size
    }

    /// Stiffness of the coupling, N/m.
    pub fn coupling(&self) -> f64 {
        match &self.material {
            DraftMaterial::Solid { preset, .. } => COUPLING_SHARE * 2.0 * preset.young * self.radius(),
            DraftMaterial::Sheet { .. } => SHEET_COUPLING,
        }
    }

    /// Largest force of the hand, N.
    pub fn peak_force(&self) -> f64 {
        PEAK_SHARE * self.coupling() * self.radius()
    }

    /// Pressure of inflating and deflating strokes, Pa.
    pub fn pressure(&self) -> f64 {
        match &self.material {
            DraftMaterial::Solid { preset, .. } => PRESSURE_SHARE * preset.young,
            DraftMaterial::Sheet { .. } => SHEET_PRESSURE,
        }
    }

    /// The hand and its tool.
    pub fn hand(&self) -> HandSettings {
        HandSettings {
            size: self.size,
            radius: self.radius(),
            coupling: self.coupling(),
            peak_force: self.peak_force(),
            pressure: self.pressure(),
            tip_mass: (self.substance() == Substance::Sheet).then_some(TIP_MASS),
        }
    }

    /// Parameters of its material that a hand can paint.
    pub fn painted(&self) -> &'static [&'static str] {
        match self.substance() {
            Substance::Solid => &["young", "density"],
            Substance::Sheet => &["young", "thickness"],
        }
    }

    /// The scene as TOML, for a file in `folder`.
    pub fn to_toml(&self, folder: &Path) -> String {
        let mut scene = DocumentMut::new();
        scene["format"] = value(1);
        let stem = self.mesh.file_name().unwrap_or_default().to_string_lossy().into_owned();
        scene["title"] = value(format!("edit: {stem}"));
        let mut time = Table::new();
        time["dt"] = value(self.dt);
        time["sleep"] = value(SLEEP_SHARE * self.size);
        if self.substance() == Substance::Sheet {
            time["integrator"] = value("backward-euler");
            let mut solver = Table::new();
            solver["tolerance"] = value(1e-4);
            scene["solver"] = Item::Table(solver);
        }
        scene["time"] = Item::Table(time);
        scene["body"] = tables([self.body(folder)]);
        give_hand(&mut scene, &self.hand(), self.painted());
        let mut output = Table::new();
        output["energy"] = value(false);
        scene["output"] = Item::Table(output);
        scene.to_string()
    }

    fn body(&self, folder: &Path) -> Table {
        let mut body = Table::new();
        body["name"] = value(BODY);
        body["mesh"] = value(relative(&self.mesh, folder).to_string_lossy().into_owned());
        body["scale"] = value(self.scale);
        if self.subdivide && !self.is_tetrahedral() {
            body["subdivide"] = value("auto");
        }
        if let Some(weld) = self.weld.filter(|_| !self.is_tetrahedral()) {
            body["weld"] = value(weld);
        }
        let mut material = InlineTable::new();
        let mut params = InlineTable::new();
        match &self.material {
            DraftMaterial::Solid { plugin, preset, level } => {
                // Mass-spring has links along the edges of cubes.
                let plugin = if self.is_tetrahedral() { TETRAHEDRAL_PLUGIN } else { plugin.as_str() };
                material.insert("plugin", plugin.into());
                params.insert("young", preset.young.into());
                params.insert("density", preset.density.into());
                params.insert("damping-time", preset.damping_time.into());
                if let Some(flow) = preset.flow {
                    params.insert("poisson", preset.poisson.into());
                    params.insert("yield-strain", flow.yield_strain.into());
                    params.insert("hardening", flow.hardening.into());
                    params.insert("flow-time", flow.flow_time.into());
                }
                if !self.is_tetrahedral() {
                    let mut grid = Table::new();
                    grid["level"] = value(i64::from(*level));
                    body["grid"] = Item::Table(grid);
                }
            }
            DraftMaterial::Sheet { plugin, fabric, held } => {
                material.insert("plugin", plugin.as_str().into());
                params.insert("fabric", fabric.as_str().into());
                body["sheet"] = value(InlineTable::new());
                if !held.is_empty() {
                    let mut fixed = Table::new();
                    fixed["nodes"] = value(held.iter().map(|v| i64::from(*v)).collect::<Array>());
                    body["fixed"] = tables([fixed]);
                }
            }
        }
        material.insert("params", Value::InlineTable(params));
        body["material"] = value(material);
        body
    }
}

/// The path relative to `folder` if it is inside of it, otherwise the path itself.
fn relative<'a>(path: &'a Path, folder: &Path) -> &'a Path {
    path.strip_prefix(folder).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::SOLIDS;
    use pliant_engine::scene;

    fn draft(material: DraftMaterial) -> Draft {
        Draft {
            mesh: "/models/a \"b\".obj".into(),
            scale: 0.01,
            size: 0.1,
            subdivide: false,
            weld: None,
            material,
            dt: 1e-3,
        }
    }

    #[test]
    fn a_draft_is_a_scene() {
        let solid = DraftMaterial::Solid { plugin: "mass-spring".into(), preset: SOLIDS[1], level: 6 };
        let clay = *crate::preset::solid("clay").expect("a preset");
        let clay = DraftMaterial::Solid { plugin: "neo-hookean".into(), preset: clay, level: 6 };
        let sheet = DraftMaterial::Sheet { plugin: "cloth".into(), fabric: "denim".into(), held: vec![3, 5] };
        for material in [solid, clay, sheet] {
            let draft = draft(material);
            let text = draft.to_toml(Path::new("/models"));
            let (scene, _) = scene::load_text(Path::new("/models/scene.toml"), text.clone(), &[]).expect("a scene");
            assert_eq!(scene.body[0].mesh.as_ref().map(|m| m.get_ref().clone()), Some("a \"b\".obj".into()), "{text}");
            assert_eq!(scene.tool[0].radius.as_ref().map(|r| r.get_ref().si), Some(draft.radius()));
            let flows = matches!(&draft.material, DraftMaterial::Solid { preset, .. } if preset.flow.is_some());
            assert_eq!(scene.body[0].material.params.contains_key("yield-strain"), flows);
            assert_eq!(scene.body[0].sheet.is_some(), draft.substance() == Substance::Sheet);
            let divided = Draft { subdivide: true, ..draft }.to_toml(Path::new("/models"));
            let (divided, _) = scene::load_text(Path::new("/models/scene.toml"), divided, &[]).expect("a scene");
            let asked = |scene: &scene::Scene| scene.body[0].subdivide.as_ref().map(|level| *level.get_ref());
            assert_eq!((asked(&scene), asked(&divided)), (None, Some(scene::Level::Auto)));
        }
    }

    #[test]
    fn a_hand_is_stiffer_than_what_it_presses_and_scales_with_the_model() {
        let solid = DraftMaterial::Solid { plugin: "mass-spring".into(), preset: SOLIDS[1], level: 6 };
        let small = draft(solid);
        let large = Draft { size: 1.7, ..small.clone() };
        let contact = 2.0 * SOLIDS[1].young * small.radius();
        assert!(small.coupling() > contact && small.peak_force() > contact * small.radius());
        assert!((large.coupling() / small.coupling() - 17.0).abs() < 1e-9);
    }
}
