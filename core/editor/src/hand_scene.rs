//! The pointer's hand in a scene: a device, a tool, and edits that begin with buttons.
//!
//! Every edit kind of the engine has a button: two where its shape may be kept or spring back, two for a cut, and two for each parameter that may be painted, one
//! that raises it and one that lowers it. A user interface offers all kinds and selects one by pressing its button, like a user with a real device.

use pliant_engine::edit::{EditKind, KINDS, KeyName, SheetLayers};
use pliant_engine::scene::Release;
use pliant_mesh::TetMesh;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

/// Name of the device and of the tool in a drafted scene.
pub const HAND: &str = "hand";

/// A hand and the tool it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandSettings {
    /// Longest edge of the edited model's bounding box, m.
    pub size: f64,
    /// Radius of the tool, m.
    pub radius: f64,
    /// Stiffness of the coupling, N/m.
    pub coupling: f64,
    /// Largest force of the hand, N.
    pub peak_force: f64,
    /// Pressure of inflating and deflating strokes, Pa.
    pub pressure: f64,
    /// Mass of the tip on sheets, kg; `None` for a tip at the position of the hand.
    pub tip_mass: Option<f64>,
}

impl HandSettings {
    /// Largest rate of change of the force on the hand, N/s.
    pub fn slew(&self) -> f64 {
        self.peak_force / RISE
    }

    /// Fracture energy per area that its blade meets, J/m^2: across the whole model it resists with the force that moves the coupling by a share of the
    /// tool's radius, so that the blade follows the hand as closely in a soft body as in a stiff one.
    pub fn toughness(&self) -> f64 {
        LAG_SHARE * self.coupling * self.radius / self.size
    }
}

/// Distance of the blade behind the hand in a cut as wide as the model, in radii of the tool.
const LAG_SHARE: f64 = 0.25;

/// Speed limit of the hand, in model sizes per second of simulated time; high, because a hand is fast relative to a simulation in slow motion.
const SPEED: f64 = 100.0;
/// Shortest time in which the force may rise to its peak, s.
const RISE: f64 = 5e-3;
/// Stiffness declared by the pointer's device relative to that of the coupling; a device without force rendering has no limit.
const DEVICE_STIFFNESS: f64 = 4.0;

/// What a button of the hand does.
#[derive(Clone, Copy)]
pub struct HandStroke {
    /// The edit kind.
    pub kind: &'static dyn EditKind,
    /// What becomes of the shape, where the kind leaves a choice.
    pub release: Release,
    /// What it paints, if it does.
    pub paint: Option<PaintStroke>,
    /// SheetLayers of a sheet that it cuts, if it does.
    pub sheet_layers: SheetLayers,
}

/// What a stroke that paints does to a parameter of the material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PaintStroke {
    /// Place of the parameter among those that the hand may paint.
    pub param: usize,
    /// Whether it lowers the parameter by the factor that it raises it by otherwise.
    pub lowers: bool,
}

/// Most parameters that a hand can paint.
pub const MAX_PAINTED: usize = 3;
/// Factor by which a stroke raises or lowers a parameter.
const PAINT_FACTOR: f64 = 4.0;

/// Whether a stroke of this kind may keep its shape or let it spring back.
pub fn has_release(kind: &dyn EditKind) -> bool {
    !kind.cuts() && !kind.changes_body()
}

/// Name of the edit kind that does the opposite of the one called `kind`; `None` if the engine has none.
pub fn opposite_kind(kind: &str) -> Option<&'static str> {
    KINDS.iter().find(|other| other.name() == kind)?.opposite().map(EditKind::name)
}

/// The strokes of a hand that may paint `params` parameters, in the order of their buttons, from 0. Those that paint are the last, so that the number of
/// parameters changes no other button.
pub fn hand_strokes(params: usize) -> Vec<HandStroke> {
    let (painting, others): (Vec<_>, Vec<_>) = KINDS.iter().copied().partition(|kind| kind.param().is_some());
    let mut strokes = Vec::new();
    for kind in others {
        let releases: &[Release] =
            if has_release(kind) { &[Release::Keep, Release::SpringBack] } else { &[Release::Keep] };
        // A line over a picture goes through all layers of a sheet; a knife that is felt goes through the one that it meets.
        let layers: &[SheetLayers] =
            if has_layers(kind) { &[SheetLayers::All, SheetLayers::One] } else { &[SheetLayers::One] };
        let ways = releases.iter().flat_map(|release| layers.iter().map(|layers| (*release, *layers)));
        strokes.extend(ways.map(|(release, sheet_layers)| HandStroke { kind, release, paint: None, sheet_layers }));
    }
    for kind in painting {
        for (param, lowers) in (0..params.min(MAX_PAINTED)).flat_map(|param| [(param, false), (param, true)]) {
            let paint = Some(PaintStroke { param, lowers });
            strokes.push(HandStroke { kind, release: Release::Keep, paint, sheet_layers: SheetLayers::One });
        }
    }
    strokes
}

/// The button, from 0, of an edit kind for a pointer, whose hand feels nothing. `release` counts where the kind leaves a choice, `paint` where it paints.
pub fn stroke_button(kind: &dyn EditKind, release: Release, paint: PaintStroke) -> u32 {
    button_with(kind, release, paint, SheetLayers::All)
}

/// The button, from 0, of an edit kind for a device, whose hand feels what it does.
pub fn device_button(kind: &dyn EditKind, release: Release, paint: PaintStroke) -> u32 {
    button_with(kind, release, paint, SheetLayers::One)
}

/// Whether a stroke of this kind cuts one or all layers of a sheet.
fn has_layers(kind: &dyn EditKind) -> bool {
    kind.keys().iter().any(|key| key.name == KeyName::SheetLayers)
}

fn button_with(kind: &dyn EditKind, release: Release, paint: PaintStroke, sheet_layers: SheetLayers) -> u32 {
    let is_asked = |stroke: &HandStroke| {
        stroke.kind.name() == kind.name()
            && (stroke.release == release || !has_release(kind))
            && (stroke.sheet_layers == sheet_layers || !has_layers(kind))
            && stroke.paint.is_none_or(|other| other == paint)
    };
    hand_strokes(MAX_PAINTED).iter().position(is_asked).unwrap_or_default() as u32
}

/// Replaces devices, tools, edits and probes of a scene by this hand, whose edits may be mirrored along any axis: an editor says along which with
/// `SessionCommand::SetSymmetry` of the engine before the first step, as all are on otherwise. `painted`: the parameters of the bodies' materials
/// that it may paint, at most [`MAX_PAINTED`]. Where a body is a tetrahedral mesh, which is neither cut nor stitched, buttons of edits that do so begin none.
pub fn give_hand(scene: &mut DocumentMut, hand: &HandSettings, painted: &[&str]) {
    for key in ["device", "tool", "edit", "probe"] {
        scene.remove(key);
    }
    scene["device"] = tables([device(hand)]);
    scene["tool"] = tables([tool(hand)]);
    let is_divided = |kind: &dyn EditKind| kind.changes_topology() && has_tetrahedra(scene);
    let strokes = hand_strokes(painted.len()).into_iter().enumerate().filter(|(_, stroke)| !is_divided(stroke.kind));
    let mut edits = Vec::new();
    for (button, HandStroke { kind, release, paint, sheet_layers }) in strokes {
        let mut edit = Table::new();
        edit["kind"] = value(kind.name());
        edit["tool"] = value(HAND);
        edit["symmetry"] = value("xyz");
        edit["button"] = value(button as i64);
        // What a blade has dragged along is no shape that anyone wants.
        let keeps = release == Release::Keep && !kind.cuts();
        edit["release"] = value(if keeps { "keep" } else { "spring-back" });
        if kind.keys().iter().any(|key| key.name == KeyName::Limit) {
            edit["limit"] = value(hand.peak_force);
        }
        if sheet_layers == SheetLayers::All {
            edit["sheet-layers"] = value("all");
        }
        if kind.strength().is_some_and(|strength| strength.unit == "Pa") {
            edit["strength"] = value(hand.pressure);
        }
        if let Some(PaintStroke { param, lowers }) = paint {
            edit["param"] = value(painted[param]);
            edit["strength"] = value(if lowers { 1.0 / PAINT_FACTOR } else { PAINT_FACTOR });
        }
        edits.push(edit);
    }
    scene["edit"] = tables(edits);
}

/// Whether a body of a scene is a tetrahedral mesh.
fn has_tetrahedra(scene: &DocumentMut) -> bool {
    let bodies = scene.get("body").and_then(Item::as_array_of_tables);
    bodies.into_iter().flatten().filter_map(|body| body.get("mesh")?.as_str()).any(TetMesh::is_name)
}

fn device(hand: &HandSettings) -> Table {
    let mut device = Table::new();
    device["name"] = value(HAND);
    device["plugin"] = value("scripted");
    let mut params = InlineTable::new();
    params.insert("peak-force", hand.peak_force.into());
    params.insert("stiffness", (DEVICE_STIFFNESS * hand.coupling).into());
    // Pose of the scripted device that the pointer replaces: at the origin with no button pressed.
    params.insert("path", [Value::from([0.0; 4].into_iter().collect::<Array>())].into_iter().collect::<Array>().into());
    device["params"] = value(params);
    device
}

fn tool(hand: &HandSettings) -> Table {
    let mut tool = Table::new();
    tool["name"] = value(HAND);
    tool["device"] = value(HAND);
    tool["radius"] = value(hand.radius);
    tool["stiffness"] = value(hand.coupling);
    tool["speed"] = value(SPEED * hand.size);
    tool["slew"] = value(hand.slew());
    if let Some(mass) = hand.tip_mass {
        tool["mass"] = value(mass);
    }
    let mut blade = InlineTable::new();
    // The blade is long enough to pass through the whole model.
    blade.insert("length", (4.0 * hand.size).into());
    blade.insert("toughness", hand.toughness().into());
    tool["blade"] = value(blade);
    tool
}

/// An array of tables.
pub(crate) fn tables(all: impl IntoIterator<Item = Table>) -> Item {
    Item::ArrayOfTables(all.into_iter().collect::<ArrayOfTables>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_engine::plan::{Edit, Plan};
    use pliant_engine::scene;
    use std::path::Path;

    #[test]
    fn what_a_tetrahedral_mesh_refuses_has_no_edit() {
        for (mesh, refused) in [("a.msh", true), ("a.vtk", true), ("a.obj", false)] {
            let text = format!(
                "format = 1\n[[body]]\nname = \"a\"\nmesh = \"{mesh}\"\nmaterial = {{ plugin = \"neo-hookean\" }}\n"
            );
            let mut document: DocumentMut = text.parse().unwrap();
            let hand = HandSettings {
                size: 1.0,
                radius: 0.1,
                coupling: 100.0,
                peak_force: 5.0,
                pressure: 50.0,
                tip_mass: None,
            };
            give_hand(&mut document, &hand, &["young"]);
            let (scene, source) =
                scene::load_text(Path::new("scene.toml"), document.to_string(), &[]).expect("a scene");
            let plan = Plan::new(&scene, &source).expect("a plan");
            for kind in KINDS {
                let has = plan.edits.iter().any(|edit| edit.kind.name() == kind.name());
                assert_eq!(has, !(refused && kind.changes_topology()), "{mesh}: {}", kind.name());
            }
            let touch = KINDS.iter().find(|kind| kind.name() == "touch").expect("a kind");
            let button = stroke_button(*touch, Release::Keep, PaintStroke::default());
            assert!(plan.edits.iter().any(|edit| edit.kind.name() == "touch" && edit.button == Some(button)));
        }
    }

    #[test]
    fn every_kind_has_its_buttons_and_the_scene_keeps_its_bodies() {
        let text = "format = 1\n[[body]]\nname = \"a\"\nmaterial = { plugin = \"mass-spring\" }\n\
            shape = { kind = \"box\", size = [1, 1, 1] }\n[[device]]\nname = \"old\"\n[[tool]]\nname = \"t\"\n\
            device = \"old\"\nradius = 0.1\n[[edit]]\nkind = \"touch\"\ntool = \"t\"\n";
        let mut document: DocumentMut = text.parse().unwrap();
        let hand =
            HandSettings { size: 1.0, radius: 0.1, coupling: 100.0, peak_force: 5.0, pressure: 50.0, tip_mass: None };
        give_hand(&mut document, &hand, &["young", "density"]);
        let (scene, source) = scene::load_text(Path::new("scene.toml"), document.to_string(), &[]).expect("a scene");
        assert_eq!((scene.body.len(), scene.device.len(), scene.tool.len()), (1, 1, 1));
        let plan = Plan::new(&scene, &source).expect("a plan");
        // Every kind that the engine has, and as many buttons as a device may have.
        let strokes = hand_strokes(2);
        assert!(strokes.len() <= 32 && hand_strokes(MAX_PAINTED).len() <= 32);
        // The hand, and its mirror images along each combination of axes.
        assert_eq!((plan.edits.len(), plan.tools.len()), (8 * strokes.len(), 8));
        assert!(KINDS.iter().all(|kind| strokes.iter().any(|stroke| stroke.kind.name() == kind.name())));
        for (place, stroke) in strokes.iter().enumerate() {
            let HandStroke { kind, release, paint, sheet_layers } = *stroke;
            let button = match sheet_layers {
                SheetLayers::All => stroke_button(kind, release, paint.unwrap_or_default()),
                SheetLayers::One => device_button(kind, release, paint.unwrap_or_default()),
            };
            assert_eq!(button as usize, place, "{}", kind.name());
            for tool in 0..8 {
                let begins = |edit: &&Edit| edit.button == Some(button) && edit.tool == tool;
                let edit = plan.edits.iter().find(begins).expect("an edit of the button");
                let release = if kind.cuts() { Release::SpringBack } else { release };
                assert_eq!((edit.kind.name(), edit.release, edit.span.end), (kind.name(), release, f64::INFINITY));
                assert_eq!(edit.sheet_layers, sheet_layers);
                let painted =
                    paint.map(|paint| (["young", "density"][paint.param], if paint.lowers { 0.25 } else { 4.0 }));
                assert_eq!(edit.param.as_deref().zip(edit.strength), painted, "{}", kind.name());
            }
        }
    }
}
