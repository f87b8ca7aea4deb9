//! What a scene needs, what is left out, and why: decided before any plugin is opened.

mod check;

use crate::body::Axes;
use crate::edit::{Command, EditKind, Falloff};
use crate::probe::{QUANTITIES, Quantity, Subject};
use crate::scene::{Extent, Release, Scene, SceneError, Source};
use pliant_solver::Vec3;
use serde::Serialize;

/// A part that a scene could have and this one does without.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Name of the part.
    pub what: String,
    /// Why it is not needed.
    pub why: String,
}

/// One thing done with a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Kind of the edit.
    pub kind: &'static dyn EditKind,
    /// Where in the scene it stands: file, line and column.
    pub place: String,
    /// Place among the plan's tools.
    pub tool: usize,
    /// s, from and until
    pub span: (f64, f64),
    /// Only while this button is down.
    pub button: Option<u32>,
    /// What becomes of the shape.
    pub release: Release,
    /// N, it lets go above it
    pub limit: Option<f64>,
    /// m, of what it acts on
    pub radius: Option<f64>,
    /// How its weight falls up to the radius.
    pub falloff: Falloff,
    /// In the unit of its kind.
    pub strength: Option<f64>,
}

/// An undo or redo that a scene asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistoryStep {
    /// Redo, else undo.
    pub redo: bool,
    /// When it happens.
    pub trigger: Trigger,
}

/// When an undo or redo happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trigger {
    /// s, once
    Time(f64),
    /// Each time a hand presses a button.
    Button {
        /// Number of the button, from 0.
        button: u32,
        /// s, from and until
        span: (f64, f64),
    },
}

/// One thing measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// For the report.
    pub name: String,
    /// The quantity that is measured.
    pub quantity: &'static Quantity,
    /// Place among the plan's tools or bodies.
    pub of: usize,
    /// m, of the surface point nearest to it
    pub at: Option<Vec3>,
    /// s
    pub time: f64,
    /// The greatest until then.
    pub greatest: bool,
    /// What it should be.
    pub expected: Option<f64>,
    /// Allowed relative error.
    pub tolerance: f64,
    /// Where the expected value comes from.
    pub source: String,
}

/// What will be opened, and what not.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Places in the scene of the bodies that move; the rest only stand there.
    pub moving: Vec<bool>,
    /// Places in the scene of the devices that are opened.
    pub devices: Vec<usize>,
    /// Places in the scene of the tools that are used.
    pub tools: Vec<usize>,
    /// For each of `tools`, the place among them of the one it mirrors, and in which axes.
    pub mirrors: Vec<Option<(usize, Axes)>>,
    /// In the order of the scene; one with symmetry is followed by its mirror images.
    pub edits: Vec<Edit>,
    /// Name of the material of faces that a blade makes inside of a body.
    pub cap_material: String,
    /// Undo and redo, in the order of the scene.
    pub history_steps: Vec<HistoryStep>,
    /// In the order of the scene.
    pub probes: Vec<Probe>,
    /// m/s^2
    pub gravity: Vec3,
    /// Whether energies are computed.
    pub energy: bool,
    /// What is not there, and why.
    pub left_out: Vec<LeftOut>,
}

impl Plan {
    /// Looks at a scene.
    ///
    /// # Errors
    /// A name that stands for nothing, or a time or number that makes no sense.
    pub fn new(scene: &Scene, source: &Source) -> Result<Self, SceneError> {
        check::check(scene, source)?;
        let mut plan =
            Self { gravity: scene.gravity.map_or(Vec3::zeros(), |g| g.map(|a| a.si).into()), ..Self::default() };
        plan.find_tools(scene, source)?;
        plan.find_devices(scene);
        plan.find_moving(scene);
        plan.find_probes(scene, source)?;
        plan.list_gravity(scene);
        plan.list_small_things(scene);
        Ok(plan)
    }

    /// Whether anything is cut.
    pub fn cuts(&self) -> bool {
        self.edits.iter().any(|edit| edit.kind.cuts())
    }

    /// Whether an edit with a tool, by its place among [`Plan::tools`], renders torque.
    pub fn has_torque(&self, tool: usize) -> bool {
        self.edits.iter().any(|edit| edit.tool == tool && edit.kind.renders_torque())
    }

    fn leave(&mut self, what: impl Into<String>, why: impl Into<String>) {
        self.left_out.push(LeftOut { what: what.into(), why: why.into() });
    }

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
                        Some(button) => Trigger::Button { button: *button.get_ref(), span: (start, end) },
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
                self.leave(what, format!("the scene ends at {duration} s"));
                continue;
            }
            let place = self.place_of(tool, None);
            let planned = Edit {
                kind,
                place: source.error(edit.kind.span(), "").place(),
                tool: place,
                span: (start, end),
                button: edit.button.as_ref().map(|b| *b.get_ref()),
                release: edit.release,
                limit: edit.limit.as_ref().map(|f| f.get_ref().si),
                radius: edit.radius.as_ref().map(|r| r.get_ref().si),
                falloff: edit.falloff.as_ref().map_or(Falloff::default(), |f| *f.get_ref()),
                strength: check::strength(edit, kind, source)?,
            };
            self.edits.push(planned.clone());
            for axes in check::images(edit, source)? {
                let tool = self.place_of(tool, Some((place, axes)));
                self.edits.push(Edit { tool, ..planned.clone() });
            }
        }
        for (i, name) in names.iter().enumerate() {
            if !self.tools.contains(&i) {
                self.leave(format!("tool `{name}`"), "no edit uses it");
            }
        }
        if !self.cuts() {
            self.leave("cutting", "no edit is a cut");
        }
        if self.history_steps.is_empty() {
            self.leave("the history of edits", "nothing is undone");
        }
        Ok(())
    }

    /// Place among the tools in use of a tool of the scene, or of its mirror image.
    fn place_of(&mut self, tool: usize, mirror: Option<(usize, Axes)>) -> usize {
        let known = self.tools.iter().zip(&self.mirrors).position(|of| of == (&tool, &mirror));
        known.unwrap_or_else(|| {
            self.tools.push(tool);
            self.mirrors.push(mirror);
            self.tools.len() - 1
        })
    }

    fn find_devices(&mut self, scene: &Scene) {
        for (i, device) in scene.device.iter().enumerate() {
            let name = device.name.get_ref();
            if self.tools.iter().any(|&t| scene.tool[t].device.get_ref() == name) {
                self.devices.push(i);
            } else {
                self.leave(format!("device `{name}` (plugin `{}`)", device.plugin.get_ref()), "no tool in use has it");
            }
        }
        if self.tools.is_empty() {
            self.leave("contact, coupling and force safety", "no tool is used");
        }
    }

    fn find_moving(&mut self, scene: &Scene) {
        for body in &scene.body {
            let led = body.fixed.iter().any(|f| f.get_ref().path.iter().any(|row| row[1..] != [0.0; 3]));
            let whole = body.sheet.is_some() || body.grid.region == Extent::Whole;
            let falls = self.gravity != Vec3::zeros() && whole;
            let moving = !self.tools.is_empty() || led || falls;
            self.moving.push(moving);
            if !moving {
                let (grid, material) = (body.grid.plugin.get_ref(), body.material.plugin.get_ref());
                let what = format!("plugins `{grid}` and `{material}` of body `{}`", body.name.get_ref());
                self.leave(what, "nothing acts on it: no tool, no gravity on the whole of it, nothing led");
            }
        }
    }

    fn find_probes(&mut self, scene: &Scene, source: &Source) -> Result<(), SceneError> {
        let tools: Vec<&str> = self.tools.iter().map(|&t| scene.tool[t].name.get_ref().as_str()).collect();
        let bodies: Vec<&str> = scene.body.iter().map(|b| b.name.get_ref().as_str()).collect();
        for probe in &scene.probe {
            let quantity = Quantity::find(&probe.quantity.get_ref().0).ok_or_else(|| {
                let known = list(QUANTITIES.iter().map(|quantity| quantity.name));
                let text = format!("quantity `{}`; allowed is {known}", probe.quantity.get_ref().0);
                source.error(probe.quantity.span(), text)
            })?;
            let (kind, names) = match quantity.subject {
                Subject::Tool => ("tool in use", &tools),
                Subject::Body => ("body", &bodies),
            };
            let of = match &probe.of {
                None if names.is_empty() => {
                    return Err(source.error(probe.name.span(), format!("a probe of a {kind}, and there is none")));
                }
                None => 0,
                Some(name) => names.iter().position(|n| n == name.get_ref()).ok_or_else(|| {
                    let known = list(names.iter().copied());
                    source.error(name.span(), format!("no {kind} `{}`; allowed is {known}", name.get_ref()))
                })?,
            };
            if quantity.needs_place && probe.at.is_none() {
                let text = format!("a probe of `{}` needs `at`, a place", quantity.name);
                return Err(source.error(probe.name.span(), text));
            }
            self.probes.push(Probe {
                name: probe.name.get_ref().clone(),
                quantity,
                of,
                at: probe.at.map(|p| p.map(|c| c.si).into()),
                time: probe.time.as_ref().map_or(f64::INFINITY, |t| t.get_ref().si),
                greatest: probe.greatest,
                expected: probe.expected.as_ref().map(|e| *e.get_ref()),
                tolerance: *probe.tolerance.get_ref(),
                source: probe.source.clone(),
            });
        }
        Ok(())
    }

    fn list_gravity(&mut self, scene: &Scene) {
        if self.gravity == Vec3::zeros() {
            self.leave("gravity", if scene.gravity.is_some() { "it is zero" } else { "the scene has none" });
            return;
        }
        for body in scene.body.iter().filter(|b| b.sheet.is_none() && b.grid.region == Extent::Local) {
            // A patch that is switched on under gravity would start out of equilibrium and jump.
            let why = "its region is local: the shape handed in is the shape it has under its own weight";
            self.leave(format!("gravity on body `{}`", body.name.get_ref()), why);
        }
    }

    fn list_small_things(&mut self, scene: &Scene) {
        let own: Vec<usize> =
            self.tools.iter().zip(&self.mirrors).filter(|of| of.1.is_none()).map(|of| *of.0).collect();
        for t in own {
            let (tool, name) = (&scene.tool[t], scene.tool[t].name.get_ref());
            if *tool.friction.get_ref() == [0.0; 2] {
                self.leave(format!("friction of tool `{name}`"), "its coefficients are zero");
            }
            if tool.damping.as_ref().is_none_or(|d| d.get_ref().si == 0.0) {
                self.leave(format!("damping in the coupling of tool `{name}`"), "it is zero");
            }
        }
        for body in &scene.body {
            if body.sheet.is_some() {
                self.leave(format!("grid of body `{}`", body.name.get_ref()), "its own mesh carries it");
                continue;
            }
            let name = body.name.get_ref();
            let what = match body.grid.level.get_ref().given() {
                Some(level) => format!("levels {} and finer of the grid of body `{name}`", u64::from(level) + 1),
                None => format!("levels of the grid of body `{name}` that are finer than the one chosen"),
            };
            self.leave(what, "nobody reads them");
        }
        self.energy = scene.output.energy
            || scene.time.force_unstable
            || self.probes.iter().any(|probe| probe.quantity.needs_energy);
        if !self.energy {
            self.leave("energies", "neither the output nor a probe asks for them");
        }
        if scene.output.frames.is_none() {
            self.leave("pictures of the surface between start and end", "the output does not ask for them");
        }
    }
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|n| format!("`{n}`")).collect();
    if names.is_empty() { "nothing: there is none".into() } else { names.join(", ") }
}
