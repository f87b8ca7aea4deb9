//! The pointer's hand in a scene: a device, a tool, and edits that begin with buttons.
//!
//! Every edit kind of the engine gets two edits, one whose shape is kept and one that springs back, each with its own button. A user interface offers all
//! kinds and selects one by pressing its button, like a user with a real device.

use pliant_engine::edit::{EditKind, KINDS, KeyName};
use pliant_engine::scene::Release;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

/// Name of the device and of the tool in a drafted scene.
pub const HAND: &str = "hand";
/// Name of the device and of the tool that mirror the hand.
pub const MIRROR: &str = "mirror";

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
    /// Mass of the tip on sheets, kg; `None` for a tip at the position of the hand.
    pub tip_mass: Option<f64>,
}

impl HandSettings {
    /// Largest rate of change of the force on the hand, N/s.
    pub fn slew(&self) -> f64 {
        self.peak_force / RISE
    }
}

/// Speed limit of the hand, in model sizes per second of simulated time; high, because a hand is fast relative to a simulation in slow motion.
const SPEED: f64 = 100.0;
/// Shortest time in which the force may rise to its peak, s.
const RISE: f64 = 5e-3;
/// Stiffness declared by the pointer's device relative to that of the coupling; a device without force rendering has no limit.
const DEVICE_STIFFNESS: f64 = 4.0;

/// Edit kinds with buttons: all of them, as far as 32 buttons suffice.
pub fn stroke_kinds() -> impl Iterator<Item = &'static dyn EditKind> {
    KINDS.iter().copied().take(16)
}

/// The button, from 0, of the edit kind with this index in [`stroke_kinds`].
pub fn stroke_button(kind: usize, release: Release) -> u32 {
    2 * kind as u32 + u32::from(release == Release::SpringBack)
}

/// Replaces devices, tools, edits and probes of a scene by this hand and a second one for mirrored edits.
pub fn give_hand(scene: &mut DocumentMut, hand: &HandSettings) {
    for key in ["device", "tool", "edit", "probe"] {
        scene.remove(key);
    }
    scene["device"] = tables([HAND, MIRROR].map(|name| device(name, hand)));
    scene["tool"] = tables([HAND, MIRROR].map(|name| tool(name, hand)));
    let mut edits = Vec::new();
    for (place, kind) in stroke_kinds().enumerate() {
        for (release, name) in [(Release::Keep, "keep"), (Release::SpringBack, "spring-back")] {
            for tool in [HAND, MIRROR] {
                let mut edit = Table::new();
                edit["kind"] = value(kind.name());
                edit["tool"] = value(tool);
                edit["button"] = value(i64::from(stroke_button(place, release)));
                edit["release"] = value(name);
                if kind.keys().iter().any(|key| key.name == KeyName::Limit) {
                    edit["limit"] = value(hand.peak_force);
                }
                edits.push(edit);
            }
        }
    }
    scene["edit"] = tables(edits);
}

fn device(name: &str, hand: &HandSettings) -> Table {
    let mut device = Table::new();
    device["name"] = value(name);
    device["plugin"] = value("scripted");
    let mut params = InlineTable::new();
    params.insert("peak-force", hand.peak_force.into());
    params.insert("stiffness", (DEVICE_STIFFNESS * hand.coupling).into());
    // Pose of the scripted device that the pointer replaces: at the origin with no button pressed.
    params.insert("path", [Value::from([0.0; 4].into_iter().collect::<Array>())].into_iter().collect::<Array>().into());
    device["params"] = value(params);
    device
}

fn tool(name: &str, hand: &HandSettings) -> Table {
    let mut tool = Table::new();
    tool["name"] = value(name);
    tool["device"] = value(name);
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
    fn every_kind_has_two_buttons_and_the_scene_keeps_its_bodies() {
        let text = "format = 1\n[[body]]\nname = \"a\"\nmaterial = { plugin = \"mass-spring\" }\n\
            shape = { kind = \"box\", size = [1, 1, 1] }\n[[device]]\nname = \"old\"\n[[tool]]\nname = \"t\"\n\
            device = \"old\"\nradius = 0.1\n[[edit]]\nkind = \"touch\"\ntool = \"t\"\n";
        let mut document: DocumentMut = text.parse().unwrap();
        let hand = HandSettings { size: 1.0, radius: 0.1, coupling: 100.0, peak_force: 5.0, tip_mass: None };
        give_hand(&mut document, &hand);
        let (scene, source) = scene::load_text(Path::new("scene.toml"), document.to_string(), &[]).expect("a scene");
        assert_eq!((scene.body.len(), scene.device.len(), scene.tool.len()), (1, 2, 2));
        let plan = Plan::new(&scene, &source).expect("a plan");
        assert_eq!(plan.edits.len(), 4 * KINDS.len().min(16));
        for (place, kind) in stroke_kinds().enumerate() {
            for release in [Release::Keep, Release::SpringBack] {
                let button = stroke_button(place, release);
                for tool in 0..2 {
                    let begins = |edit: &&Edit| edit.button == Some(button) && edit.tool == tool;
                    let edit = plan.edits.iter().find(begins).expect("an edit of the button");
                    assert_eq!((edit.kind.name(), edit.release, edit.span.1), (kind.name(), release, f64::INFINITY));
                }
                assert!(button < 32);
            }
        }
    }
}
