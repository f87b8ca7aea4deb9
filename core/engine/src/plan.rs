//! The plan of a scene: which bodies, devices, tools, edits and probes it needs, and what is left out and why. It is made before any plugin is
//! opened.

mod check;
mod collisions;
mod fibres;
mod images;
mod probes;
mod stitches;

pub(crate) use check::strength;
pub use images::Image;
pub use probes::Probe;

use crate::body::PaintDepth;
use crate::contact::CollisionSettings;
use crate::edit::{Command, EditKind, Falloff, SheetLayers};
use crate::scene::{Extent, Release, Scene, SceneError, Source};
use pliant_solver::Vec3;
use serde::Serialize;

/// A part of the program that this scene does not need.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Name of the part.
    pub what: String,
    /// Reason why it is not needed.
    pub why: String,
}

/// A span of time: its start belongs to it and its end does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpan {
    /// Time at which it starts, s.
    pub start: f64,
    /// Time at which it ends, s; infinite if it does not end.
    pub end: f64,
}

impl TimeSpan {
    /// Whether a time (s) lies in it.
    pub fn contains(self, time: f64) -> bool {
        self.start <= time && time < self.end
    }
}

/// An edit with one tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Kind of the edit.
    pub kind: &'static dyn EditKind,
    /// File, line and column of the edit in the scene, for messages.
    pub place: String,
    /// Index in [`Plan::tools`].
    pub tool: usize,
    /// Time span in which it acts.
    pub span: TimeSpan,
    /// Button that must be down for the edit to act.
    pub button: Option<u32>,
    /// What happens to the shape at the end of the edit.
    pub release: Release,
    /// Force above which it lets go, N.
    pub limit: Option<f64>,
    /// Radius of the region on which it acts, m.
    pub radius: Option<f64>,
    /// How its weight decreases from the centre to the radius.
    pub falloff: Falloff,
    /// Strength, in the SI unit of its kind; `None` for the default of the kind.
    pub strength: Option<f64>,
    /// Factor on the strength, set by the session's commands; 1 at first. Edits that paint ignore it.
    pub strength_factor: f64,
    /// Parameter of the material that it paints.
    pub param: Option<String>,
    /// Depth from the surface to which it paints.
    pub depth: PaintDepth,
    /// Whether the parts of a body that it has cut become bodies of their own at the end of the edit.
    pub splits: bool,
    /// SheetLayers of a sheet that it cuts.
    pub sheet_layers: SheetLayers,
}

impl Edit {
    /// Strength of a stroke that begins now, in the SI unit of its kind, for a kind with this default.
    pub(crate) fn strength_or(&self, default: f64) -> f64 {
        self.strength_factor * self.strength.unwrap_or(default)
    }
}

/// An undo or redo that a scene asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistoryStep {
    /// Whether it is a redo; otherwise an undo.
    pub redo: bool,
    /// When it happens.
    pub trigger: Trigger,
}

/// When an undo or redo happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trigger {
    /// Once, at this time (s).
    Time(f64),
    /// Each time a hand presses a button.
    Button {
        /// Number of the button, from 0.
        button: u32,
        /// When presses count.
        span: TimeSpan,
    },
}

/// What a session of a scene consists of.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Whether each body of the scene is simulated; the others stay at rest and open no plugin.
    pub moving: Vec<bool>,
    /// How each body of the scene meets others.
    pub collisions: Vec<CollisionSettings>,
    /// Devices that are opened, as indices in the scene.
    pub devices: Vec<usize>,
    /// Tools that edits use, as indices in the scene. The mirror image of a tool is an entry of its own.
    pub tools: Vec<usize>,
    /// For each entry of `tools` that is a mirror image: the entry it mirrors, and how.
    pub mirrors: Vec<Option<(usize, Image)>>,
    /// Edits in the order of the scene; one with symmetry is followed by its mirror images.
    pub edits: Vec<Edit>,
    /// Name of the OBJ material of faces that a cut makes inside of a body.
    pub cap_material: String,
    /// Undo and redo, in the order of the scene.
    pub history_steps: Vec<HistoryStep>,
    /// Probes in the order of the scene.
    pub probes: Vec<Probe>,
    /// Whether the scene ties bodies to each other.
    pub is_stitched: bool,
    /// Acceleration of gravity, m/s^2.
    pub gravity: Vec3,
    /// Whether energies are computed.
    pub energy: bool,
    /// Parts that are not needed.
    pub left_out: Vec<LeftOut>,
}

impl Plan {
    /// Makes the plan of a scene.
    ///
    /// # Errors
    /// Returns the first error of the scene: an unknown name, a number out of range, keys that do not belong together.
    pub fn new(scene: &Scene, source: &Source) -> Result<Self, SceneError> {
        check::check(scene, source)?;
        let mut plan =
            Self { gravity: scene.gravity.map_or(Vec3::zeros(), |g| g.map(|a| a.si).into()), ..Self::default() };
        plan.find_tools(scene, source)?;
        plan.find_devices(scene);
        plan.find_moving(scene);
        plan.find_collisions(scene);
        plan.find_stitched(scene);
        plan.find_probes(scene, source)?;
        plan.list_gravity(scene);
        plan.list_left_out_options(scene);
        Ok(plan)
    }

    /// Whether an edit cuts.
    pub fn cuts(&self) -> bool {
        self.edits.iter().any(|edit| edit.kind.cuts())
    }

    /// Whether an edit with a tool, by its index in [`Plan::tools`], renders torque.
    pub fn has_torque(&self, tool: usize) -> bool {
        self.edits.iter().any(|edit| edit.tool == tool && edit.kind.renders_torque())
    }

    /// Records a part that is left out.
    fn leave_out(&mut self, what: impl Into<String>, why: impl Into<String>) {
        self.left_out.push(LeftOut { what: what.into(), why: why.into() });
    }

    /// Lists edits and the tools they use.
    fn find_tools(&mut self, scene: &Scene, source: &Source) -> Result<(), SceneError> {
        let duration = scene.time.duration.get_ref().si;
        let names: Vec<&str> = scene.tool.iter().map(|t| t.name.get_ref().as_str()).collect();
        for tool in &scene.tool {
            if !scene.device.iter().any(|d| d.name.get_ref() == tool.device.get_ref()) {
                let known = list(scene.device.iter().map(|d| d.name.get_ref().as_str()));
                let text = format!("no device `{}`; allowed is {known}", tool.device.get_ref());
                return Err(source.error(tool.device.span(), text));
            }
        }
        for edit in &scene.edit {
            let start = edit.start.as_ref().map_or(0.0, |t| t.get_ref().si);
            let kind = match Command::find(&edit.kind.get_ref().0) {
                Some(Command::Tool(kind)) => kind,
                command => {
                    let end = edit.end.as_ref().map_or(f64::INFINITY, |t| t.get_ref().si);
                    let trigger = match &edit.button {
                        Some(button) => Trigger::Button { button: *button.get_ref(), span: TimeSpan { start, end } },
                        None => Trigger::Time(start),
                    };
                    self.history_steps.push(HistoryStep { redo: command == Some(Command::Redo), trigger });
                    continue;
                }
            };
            let Some(wanted) = &edit.tool else { continue };
            let Some(tool) = names.iter().position(|n| n == wanted.get_ref()) else {
                let text = format!("no tool `{}`; allowed is {}", wanted.get_ref(), list(names.iter().copied()));
                return Err(source.error(wanted.span(), text));
            };
            if kind.cuts() {
                let Some(blade) = &scene.tool[tool].blade else {
                    return Err(source.error(wanted.span(), format!("tool `{}` cuts and has no `blade`", names[tool])));
                };
                self.cap_material.clone_from(blade.get_ref().material.get_ref());
            }
            let end = edit.end.as_ref().map_or(f64::INFINITY, |t| t.get_ref().si);
            if start >= duration {
                let what = format!("edit of tool `{}` from {start} s", names[tool]);
                self.leave_out(what, format!("the scene ends at {duration} s"));
                continue;
            }
            let index = self.tool_index(tool, None);
            let planned = Edit {
                kind,
                place: source.error(edit.kind.span(), "").place(),
                tool: index,
                span: TimeSpan { start, end },
                button: edit.button.as_ref().map(|b| *b.get_ref()),
                release: edit.release,
                limit: edit.limit.as_ref().map(|f| f.get_ref().si),
                radius: edit.radius.as_ref().map(|r| r.get_ref().si),
                falloff: edit.falloff.as_ref().map_or(Falloff::default(), |f| *f.get_ref()),
                strength: check::strength(edit, kind, source)?,
                strength_factor: 1.0,
                param: edit.param.as_ref().map(|param| param.get_ref().clone()),
                depth: check::depth(edit, source)?,
                splits: edit.split.as_ref().is_some_and(|split| *split.get_ref()),
                sheet_layers: edit.sheet_layers.as_ref().map_or(SheetLayers::default(), |layers| *layers.get_ref()),
            };
            self.edits.push(planned.clone());
            for image in images::images(edit, source)? {
                let tool = self.tool_index(tool, Some((index, image)));
                self.edits.push(Edit { tool, ..planned.clone() });
            }
        }
        for (i, name) in names.iter().enumerate() {
            if !self.tools.contains(&i) {
                self.leave_out(format!("tool `{name}`"), "no edit uses it");
            }
        }
        if !self.cuts() {
            self.leave_out("cutting", "no edit is a cut");
        }
        if self.history_steps.is_empty() {
            self.leave_out("the history of edits", "nothing is undone");
        }
        Ok(())
    }

    /// Index in `tools` of a tool of the scene, or of its mirror image; adds it if it is new.
    fn tool_index(&mut self, tool: usize, mirror: Option<(usize, Image)>) -> usize {
        let known = self.tools.iter().zip(&self.mirrors).position(|of| of == (&tool, &mirror));
        known.unwrap_or_else(|| {
            self.tools.push(tool);
            self.mirrors.push(mirror);
            self.tools.len() - 1
        })
    }

    /// Lists the devices of the tools in use.
    fn find_devices(&mut self, scene: &Scene) {
        for (i, device) in scene.device.iter().enumerate() {
            let name = device.name.get_ref();
            if self.tools.iter().any(|&t| scene.tool[t].device.get_ref() == name) {
                self.devices.push(i);
            } else {
                let what = match &device.recording {
                    Some(recording) => format!("device `{name}` (recording {})", recording.get_ref()),
                    None => format!("device `{name}` (plugin `{}`)", device.plugin.get_ref()),
                };
                self.leave_out(what, "no tool in use has it");
            }
        }
        if self.tools.is_empty() {
            self.leave_out("contact, coupling and force safety", "no tool is used");
        }
    }

    /// Finds the bodies that tools, gravity or driven fixings can move.
    fn find_moving(&mut self, scene: &Scene) {
        for body in &scene.body {
            let driven = body.fixed.iter().any(|f| f.get_ref().path.iter().any(|row| row[1..] != [0.0; 3]));
            let whole = body.extent() == Extent::Whole;
            let falls = self.gravity != Vec3::zeros() && whole;
            let pushed = whole
                && scene.obstacle.iter().any(|o| !o.path.get_ref().is_empty() || !o.rotation_path.get_ref().is_empty());
            let sewn = !body.stitch.is_empty() || stitches::is_stitched(&body.name, scene);
            let moving = !self.tools.is_empty() || driven || falls || pushed || sewn;
            self.moving.push(moving);
            if !moving {
                let (grid, material) = (body.grid.get_ref().plugin.get_ref(), body.material.plugin.get_ref());
                let plugins = match body.has_own_mesh() {
                    true => format!("plugin `{material}`"),
                    false => format!("plugins `{grid}` and `{material}`"),
                };
                let what = format!("{plugins} of body `{}`", body.name.get_ref());
                self.leave_out(
                    what,
                    "nothing acts on it: no tool, no gravity on the whole body, no driven nodes, no seam, no moving obstacle",
                );
            }
        }
    }

    /// Records where gravity is left out.
    fn list_gravity(&mut self, scene: &Scene) {
        if self.gravity == Vec3::zeros() {
            self.leave_out("gravity", if scene.gravity.is_some() { "it is zero" } else { "the scene has none" });
            return;
        }
        for body in scene.body.iter().filter(|b| b.extent() == Extent::Local) {
            // A region that is activated under gravity would start out of equilibrium and jump.
            let why = "its region is local: the shape of the file is taken as the shape under its own weight";
            self.leave_out(format!("gravity on body `{}`", body.name.get_ref()), why);
        }
    }

    /// Lists the options that the scene does not use: friction, damping, grids, energies and frames.
    fn list_left_out_options(&mut self, scene: &Scene) {
        let own: Vec<usize> =
            self.tools.iter().zip(&self.mirrors).filter(|of| of.1.is_none()).map(|of| *of.0).collect();
        for t in own {
            let (tool, name) = (&scene.tool[t], scene.tool[t].name.get_ref());
            if tool.contact_law.is_some() {
                self.leave_out(format!("friction and restitution of tool `{name}`"), "its contact law has its own");
            } else if *tool.friction.get_ref() == [0.0; 2] {
                self.leave_out(format!("friction of tool `{name}`"), "its coefficients are zero");
            }
            if tool.damping.as_ref().is_none_or(|d| d.get_ref().si == 0.0) {
                self.leave_out(format!("damping in the coupling of tool `{name}`"), "it is zero");
            }
        }
        for body in &scene.body {
            if body.has_own_mesh() {
                let why = match body.is_tetrahedral() {
                    true => "it is simulated on the tetrahedra of its file",
                    false => "it is simulated on its own mesh",
                };
                self.leave_out(format!("grid of body `{}`", body.name.get_ref()), why);
                continue;
            }
            let name = body.name.get_ref();
            let what = match body.grid.get_ref().level.get_ref().given() {
                Some(level) => format!("levels {} and finer of the grid of body `{name}`", u64::from(level) + 1),
                None => format!("levels of the grid of body `{name}` that are finer than the one chosen"),
            };
            self.leave_out(what, "only one level is simulated");
        }
        if scene.obstacle.is_empty() {
            self.leave_out("obstacles", "the scene has none");
        }
        self.energy = scene.output.energy
            || scene.time.force_unstable
            || self.probes.iter().any(|probe| probe.quantity.needs_energy);
        if !self.energy {
            self.leave_out("energies", "neither the output nor a probe asks for them");
        }
        if scene.output.frames.is_none() {
            self.leave_out("pictures of the surface between start and end", "the output does not ask for them");
        }
    }
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|n| format!("`{n}`")).collect();
    if names.is_empty() { "nothing: there is none".into() } else { names.join(", ") }
}
