//! The panels beside the picture: tools, view, material, history.

use super::App;
use super::leaving::Departure;
use crate::gl::{Shading, Stereo, Wireframe};
use crate::opening::OpenRequest;
use crate::sim::Command;
use crate::strings;
use crate::tools::ToolSettings;
use crate::view::{Projection, UpAxis};
use eframe::egui::{self, Color32, Slider};
use pliant_editor::{LengthUnit, SOLIDS, SolidPreset, Substance, format_length, stiffness_word};
use pliant_engine::edit::Falloff;
use pliant_engine::scene::Release;

impl App {
    /// Tools and how the model is shown.
    pub(super) fn left_panel(&mut self, ui: &mut egui::Ui) {
        let width = panel_width(ui, 236.0);
        egui::Panel::left("tools").exact_size(width).resizable(false).show(ui, |ui| {
            egui::ScrollArea::both().show(ui, |ui| {
                shrink_controls(ui, width);
                self.tool_panel(ui);
                ui.separator();
                self.view_panel(ui);
                ui.separator();
                self.reference_panel(ui);
            });
        });
    }

    /// The question for the unit, warnings, the force, material, layers, history and gauges.
    pub(super) fn right_panel(&mut self, ui: &mut egui::Ui) {
        let width = panel_width(ui, 280.0);
        egui::Panel::right("model").exact_size(width).resizable(false).show(ui, |ui| {
            egui::ScrollArea::both().show(ui, |ui| {
                shrink_controls(ui, width);
                self.unit_question(ui);
                self.warning_panel(ui);
                self.force_panel(ui);
                ui.separator();
                self.material_panel(ui);
                ui.separator();
                self.layer_panel(ui);
                ui.separator();
                self.history_panel(ui);
                ui.separator();
                self.gauge_panel(ui);
            });
        });
    }

    /// A line for each warning of the session; nothing where there is none.
    fn warning_panel(&self, ui: &mut egui::Ui) {
        if self.model.is_none() || self.status.warnings.is_empty() {
            return;
        }
        ui.heading(strings::WARNINGS);
        for warning in &self.status.warnings {
            let said = strings::warning(warning.code, &warning.message, self.request.is_scene());
            let text = format!("[{}] {said}", warning.code.name());
            ui.colored_label(Color32::from_rgb(240, 170, 40), text).on_hover_text(warning.to_string());
        }
        ui.separator();
    }

    fn tool_panel(&mut self, ui: &mut egui::Ui) {
        self.device_panel(ui);
        ui.heading(strings::TOOLS);
        for tool in 0..self.tools.len() {
            let kind = self.tools[tool];
            let label = format!("{}  {}", kind.key(tool).unwrap_or(' '), kind.name());
            ui.horizontal(|ui| {
                super::icons::show(ui, kind.name());
                if ui.selectable_label(self.tool == tool, label).on_hover_text(kind.kind.summary()).clicked() {
                    self.choose_tool(tool);
                }
            });
        }
        ui.horizontal(|ui| {
            ui.label(strings::SYMMETRY);
            for (is_on, axis) in self.settings.symmetry.iter_mut().zip(strings::AXES) {
                let name = strings::mirror_along(axis);
                let button = egui::Button::selectable(*is_on, axis).frame_when_inactive(true);
                let response = ui.add(button).on_hover_text(&name);
                *is_on ^= response.clicked();
                let role = egui::Role::Button;
                response.widget_info(|| egui::WidgetInfo::selected(role, true, *is_on, &name));
            }
        });
        let mut size = self.settings.size;
        let slider = Slider::new(&mut size, ToolSettings::SIZES).logarithmic(true).max_decimals(2).text(strings::SIZE);
        let radius = self.tool_radius();
        if ui.add(slider).on_hover_text(strings::radius(&format_length(radius))).changed() {
            self.settings.size = size;
            self.resize_tool();
        }
        if self.tools[self.tool].kind.cuts() {
            ui.add(Slider::new(&mut self.settings.cut_depth, 0.05..=2.0).max_decimals(2).text(strings::CUT_DEPTH));
            return;
        }
        self.brush_controls(ui);
        if self.tools[self.tool].paints() {
            self.paint_controls(ui);
        }
        if self.tools[self.tool].always_stays() {
            return;
        }
        ui.radio_value(&mut self.settings.release, Release::Keep, strings::KEEP);
        ui.radio_value(&mut self.settings.release, Release::SpringBack, strings::SPRING_BACK);
    }

    /// Strength and falloff of strokes, as far as the tool has them.
    fn brush_controls(&mut self, ui: &mut egui::Ui) {
        let (tool, before) = (self.tools[self.tool], self.settings);
        if let Some(strength) = self.settings.strength_mut(tool) {
            let slider = Slider::new(strength, ToolSettings::STRENGTHS).logarithmic(true).max_decimals(2);
            ui.add(slider.text(strings::STRENGTH)).on_hover_text(strings::strength_hint(tool.strength()));
        }
        if tool.has_falloff() {
            let name = |falloff: Falloff| strings::FALLOFFS[falloff as usize];
            let shown = egui::ComboBox::from_label(strings::FALLOFF).selected_text(name(self.settings.falloff));
            shown.show_ui(ui, |ui| {
                for falloff in Falloff::ALL {
                    ui.selectable_value(&mut self.settings.falloff, falloff, name(falloff));
                }
            });
        }
        if (self.settings.brush, self.settings.falloff) != (before.brush, before.falloff) {
            self.set_brush();
        }
    }

    /// Which parameter of the material strokes paint.
    fn paint_controls(&mut self, ui: &mut egui::Ui) {
        let Some(painted) = self.model.as_ref().map(|model| model.facts.painted.clone()) else { return };
        ui.horizontal(|ui| {
            ui.label(strings::PAINTS);
            for (place, param) in painted.iter().enumerate() {
                ui.selectable_value(&mut self.settings.painted, place, strings::painted(param));
            }
        });
        ui.weak(strings::PAINT_HINT);
    }

    /// Takes another tool, between two strokes.
    pub(super) fn choose_tool(&mut self, tool: usize) {
        if self.model.as_ref().is_none_or(|model| !model.hand.is_busy()) && self.tool != tool {
            self.tool = tool;
            self.log.event("tool", &[("name", self.tools[tool].name().into())]);
        }
    }

    /// Keeps the shape of the next stroke if the last sprang back, and the other way round.
    pub(super) fn toggle_release(&mut self) {
        self.settings.release = match self.settings.release {
            Release::Keep => Release::SpringBack,
            Release::SpringBack => Release::Keep,
        };
    }

    /// Goes on to the next way to draw edges.
    pub(super) fn next_wireframe(&mut self) {
        self.view.wireframe = match self.view.wireframe {
            Wireframe::Off => Wireframe::Over,
            Wireframe::Over => Wireframe::Only,
            Wireframe::Only => Wireframe::Off,
        };
    }

    fn view_panel(&mut self, ui: &mut egui::Ui) {
        ui.heading(strings::VIEW);
        let name = |shading: Shading| {
            Shading::ALL.iter().position(|other| *other == shading).map_or("", |place| strings::SHADINGS[place])
        };
        egui::ComboBox::from_label(strings::SHADING).selected_text(name(self.view.shading)).show_ui(ui, |ui| {
            for shading in Shading::ALL {
                ui.selectable_value(&mut self.view.shading, shading, name(shading));
            }
        });
        ui.horizontal(|ui| {
            ui.label(strings::WIREFRAME);
            let ways = [Wireframe::Off, Wireframe::Over, Wireframe::Only];
            for (way, name) in ways.into_iter().zip(strings::WIREFRAMES) {
                ui.selectable_value(&mut self.view.wireframe, way, name);
            }
        });
        let stereo = Stereo::ALL.iter().position(|way| *way == self.view.stereo).unwrap_or_default();
        egui::ComboBox::from_label(strings::STEREO).selected_text(strings::STEREOS[stereo]).show_ui(ui, |ui| {
            for (way, name) in Stereo::ALL.into_iter().zip(strings::STEREOS) {
                ui.selectable_value(&mut self.view.stereo, way, name);
            }
        });
        ui.add(Slider::new(&mut self.view.opacity, 0.1..=1.0).max_decimals(2).text(strings::OPACITY));
        ui.checkbox(&mut self.view.file_colours, strings::FILE_COLOURS).on_hover_text(strings::FILE_COLOURS_HINT);
        ui.checkbox(&mut self.view.ground, strings::GROUND);
        ui.checkbox(&mut self.view.cells, strings::CELLS);
        let mut orthographic = self.camera.projection == Projection::Orthographic;
        if ui.checkbox(&mut orthographic, strings::ORTHOGRAPHIC).changed() {
            self.camera.projection = if orthographic { Projection::Orthographic } else { Projection::Perspective };
        }
        let mut z_up = self.camera.up == UpAxis::Z;
        if ui.checkbox(&mut z_up, strings::Z_UP).changed() {
            self.camera.up = if z_up { UpAxis::Z } else { UpAxis::Y };
        }
        if ui.button(strings::FRAME_ALL).clicked() {
            self.frame_all();
        }
    }

    fn material_panel(&mut self, ui: &mut egui::Ui) {
        ui.heading(strings::MATERIAL);
        let Some(facts) = self.model.as_ref().map(|model| model.facts.clone()) else { return };
        self.split_controls(ui);
        let (Some(taken_as), Some(unit), Some(seen)) = (facts.taken_as, facts.unit, &facts.substance) else {
            ui.label(strings::SCENE_MATERIAL);
            self.stiffness_controls(ui);
            return;
        };
        let before = self.request.clone();
        let request = &mut self.request;
        let mut substance = request.substance.unwrap_or(taken_as);
        if facts.is_tetrahedral {
            ui.label(strings::TETRAHEDRAL);
        } else {
            ui.horizontal(|ui| {
                ui.label(strings::TAKEN_AS);
                ui.selectable_value(&mut substance, Substance::Solid, strings::SOLID);
                ui.selectable_value(&mut substance, Substance::Sheet, strings::SHEET);
            });
        }
        if substance != request.substance.unwrap_or(taken_as) {
            request.substance = Some(substance);
        }
        if !facts.is_tetrahedral {
            ui.weak(strings::substance_reason(seen.openings, seen.substance == Substance::Sheet));
            ui.checkbox(&mut request.subdivide, strings::SUBDIVIDE).on_hover_text(strings::SUBDIVIDE_HINT);
        }
        if facts.coincident_vertices > 0 {
            let mut weld = request.weld.unwrap_or(facts.is_welded);
            ui.horizontal_wrapped(|ui| {
                if ui.checkbox(&mut weld, strings::WELD).on_hover_text(strings::WELD_HINT).changed() {
                    request.weld = Some(weld);
                }
                ui.weak(strings::welded_vertices(facts.coincident_vertices));
            });
        }
        match substance {
            Substance::Solid => solid_controls(ui, request, !facts.is_tetrahedral),
            Substance::Sheet => {
                egui::ComboBox::from_label(strings::FABRIC).selected_text(request.fabric.as_str()).show_ui(ui, |ui| {
                    for fabric in &facts.fabrics {
                        ui.selectable_value(&mut request.fabric, fabric.clone(), fabric);
                    }
                });
            }
        }
        // The stiffness alone changes at once, without opening the model again.
        let (young, opened) = (request.solid.young, self.opened_young);
        let is_young_alone = OpenRequest { solid: before.solid, ..request.clone() } == before
            && SolidPreset { young: before.solid.young, ..request.solid } == before.solid;
        let stiffer = opened.filter(|_| is_young_alone && young != before.solid.young).map(|opened| young / opened);
        let mut chosen = request.unit.unwrap_or(unit);
        let size = facts.hand.size / unit.metres();
        egui::ComboBox::from_label(strings::UNIT).selected_text(unit_text(chosen, size)).show_ui(ui, |ui| {
            for unit in LengthUnit::ALL {
                ui.selectable_value(&mut chosen, unit, unit_text(unit, size));
            }
        });
        if chosen != request.unit.unwrap_or(unit) {
            request.unit = Some(chosen);
        }
        if *request != before && stiffer.is_none() {
            self.is_material_changed = true;
        }
        if let Some(factor) = stiffer {
            self.stiffen(factor);
        }
        self.stiffness_controls(ui);
        let apply = ui.add_enabled(self.is_material_changed, egui::Button::new(strings::APPLY));
        if apply.on_hover_text(strings::APPLY_HINT).clicked() {
            self.reopen();
        }
    }

    /// How many bodies there are, and a button that makes each part one.
    fn split_controls(&mut self, ui: &mut egui::Ui) {
        let Some(model) = &self.model else { return };
        let (count, is_busy) = (model.moving_bodies(), model.hand.is_busy());
        ui.horizontal(|ui| {
            let split = ui.add_enabled(!is_busy, egui::Button::new(strings::SPLIT));
            if split.on_hover_text(strings::SPLIT_HINT).clicked() {
                self.split_all();
            }
            if count > 1 {
                ui.label(strings::bodies(count));
            }
        });
    }

    /// Makes each part of every body a body of its own.
    fn split_all(&mut self) {
        let Some(model) = &self.model else { return };
        for body in 0..model.moving_bodies() as u32 {
            self.split(body, None);
        }
    }

    /// Makes parts of a body bodies of their own: each, or the one with a triangle.
    pub(super) fn split(&mut self, body: u32, triangle: Option<u32>) {
        self.log.event("split", &[("body", body.to_string())]);
        self.send(Command::Split { body, triangle });
    }

    /// The stiffness of what has no Young's modulus in the panel, and how far it has changed.
    fn stiffness_controls(&mut self, ui: &mut egui::Ui) {
        if self.opened_young.is_none() {
            let mut factor = self.stiffness;
            let slider = Slider::new(&mut factor, 0.1..=10.0).logarithmic(true).max_decimals(2).suffix(" x");
            if ui.add(slider.text(strings::STIFFNESS_FACTOR)).on_hover_text(strings::STIFFNESS_HINT).changed() {
                self.stiffen(factor);
            }
        }
        let state = self.status.stiffness;
        if state.now != state.wanted {
            let slew = self.model.as_ref().map(|model| model.facts.hand.slew()).filter(|_| state.is_limited);
            ui.label(strings::stiffness_changes(state.now, state.wanted, self.opened_young, slew));
        }
    }

    /// Goes on with the present shape in the material that is chosen.
    pub(super) fn reopen(&mut self) {
        if self.model.as_ref().is_some_and(|model| model.facts.is_tetrahedral) {
            // The present places of the nodes inside are in no file that can be opened.
            let request = Box::new(self.request.clone());
            return self.leave(Departure::Open { request, recovered: None });
        }
        let folder = match tempfile::Builder::new().prefix("pliant-").tempdir() {
            Ok(folder) => folder,
            Err(error) => return self.fail(strings::no_shape_folder(&error)),
        };
        self.is_material_changed = false;
        let file = folder.path().join("shape.obj");
        self.shapes.push(folder);
        self.after_save = Some(self.request.clone());
        self.send(Command::Save { path: file, for_user: false });
    }

    fn history_panel(&mut self, ui: &mut egui::Ui) {
        ui.heading(strings::HISTORY);
        let begun = self.status.begun;
        let mut wanted = None;
        egui::ScrollArea::vertical().max_height(HISTORY_HEIGHT).stick_to_bottom(true).show(ui, |ui| {
            if ui.selectable_label(begun == 0, strings::AS_OPENED).clicked() {
                wanted = Some(0);
            }
            let strokes = &self.status.strokes;
            for (place, stroke) in strokes.iter().enumerate() {
                // A stroke of the pointer is one line, however many it is of the session.
                if strokes.get(place + 1).is_some_and(|next| next.number == stroke.number) {
                    continue;
                }
                let text = strings::stroke(stroke.number, stroke.name, stroke.time);
                let text = if place < begun { egui::RichText::new(text) } else { egui::RichText::new(text).weak() };
                if ui.selectable_label(place + 1 == begun, text).clicked() {
                    wanted = Some(place + 1);
                }
            }
        });
        if let Some(count) = wanted {
            self.follows_stiffness = true;
            self.send(Command::JumpTo(count));
        }
    }
}

/// Width of a panel, points: the usual one, or on a small screen as much as leaves the picture its place.
fn panel_width(ui: &egui::Ui, usual: f32) -> f32 {
    usual.min(PANEL_SHARE * ui.ctx().content_rect().width())
}

/// Largest height of the list of strokes, points.
const HISTORY_HEIGHT: f32 = 190.0;
/// Largest share of the width of the window that a panel takes.
const PANEL_SHARE: f32 = 0.32;
/// Points of a panel that the name and the number of a slider take.
const BESIDE_SLIDER: f32 = 136.0;

/// Sliders and boxes that fit into a panel of this width, points.
fn shrink_controls(ui: &mut egui::Ui, width: f32) {
    let spacing = ui.spacing_mut();
    spacing.slider_width = spacing.slider_width.min((width - BESIDE_SLIDER).max(32.0));
    spacing.combo_width = spacing.combo_width.min((width - BESIDE_SLIDER).max(32.0));
}

pub(super) fn unit_text(unit: LengthUnit, size: f64) -> String {
    strings::unit_and_size(unit, &format_length(size * unit.metres()))
}

fn solid_controls(ui: &mut egui::Ui, request: &mut OpenRequest, has_grid: bool) {
    let solid = &mut request.solid;
    egui::ComboBox::from_label(strings::PRESET).selected_text(solid.name).show_ui(ui, |ui| {
        for preset in SOLIDS {
            ui.selectable_value(solid, *preset, preset.name).on_hover_text(preset.source);
        }
    });
    let stiffness = Slider::new(&mut solid.young, 1e3..=1e7).logarithmic(true).suffix(strings::PASCAL);
    ui.add(stiffness.max_decimals(0).text(strings::STIFFNESS)).on_hover_text(strings::STIFFNESS_HINT);
    ui.weak(stiffness_word(solid.young));
    ui.add(
        Slider::new(&mut solid.density, 10.0..=3000.0)
            .logarithmic(true)
            .suffix(strings::KILOGRAM_PER_CUBIC_METRE)
            .text(strings::DENSITY),
    );
    let mut milliseconds = solid.damping_time * 1e3;
    let damping =
        Slider::new(&mut milliseconds, 0.0..=5.0).suffix(strings::MILLISECOND).max_decimals(2).text(strings::DAMPING);
    if ui.add(damping).changed() {
        solid.damping_time = milliseconds * 1e-3;
    }
    if has_grid {
        ui.add(Slider::new(&mut request.level, 3..=8).text(strings::LEVEL));
    }
}
