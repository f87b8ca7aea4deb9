//! The picture of the model: what the pointer does in it, and how it is painted.

use super::App;
use super::dropped::takes_drops;
use super::gauges::remember;
use super::key_pointer::KeyMotion;
use super::key_presses::{around_press, is_pressed, switches};
use super::measure::pointer_ray;
use super::model::Picked;
use crate::gl::{Channels, PixelArea, Scene, Stereo};
use crate::sim::Command;
use crate::strings;
use crate::tools::ToolKind;
use crate::view::cube::visible_faces;
use crate::view::overlay::{self, Frame};
use crate::view::{Eye, Projection};
use eframe::egui::{self, Align2, Color32, FontId, Key, PointerButton, Sense, vec2};
use eframe::egui_glow;
use nalgebra::Point3;
use pliant_editor::{Gesture, PaintStroke, StrokeStart, Substance, SurfacePoint};
use pliant_engine::body::mirrored;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Factor of the distance for a point of a wheel's turn.
const ZOOM_SPEED: f32 = 0.0025;
/// Radii of the tool that a point of a wheel's turn moves the hand in a stroke.
const LIFT_SPEED: f64 = 0.004;
/// Time for which a message is shown over the picture, beside that for reading it.
const SHOWN: Duration = Duration::from_secs(3);
/// Widths of messages over the picture, points: below the first they are shown below the axes and not beside them.
const NARROWEST_MESSAGE: f32 = 260.0;
/// See [`NARROWEST_MESSAGE`].
const WIDEST_MESSAGE: f32 = 720.0;
/// Time for reading a letter: 200 words in a minute.
const READING: Duration = Duration::from_millis(50);

/// Points of the screen that the axes in the corner take up.
const AXES_SIZE: f32 = 112.0;
/// Points of the screen of half an edge of the cube among them.
const CUBE_HALF: f32 = 15.0;

/// What a drag of the pointer turns or moves.
#[derive(Clone, Copy, PartialEq)]
enum Navigation {
    Orbit,
    Pan,
    Zoom,
}

impl App {
    /// The picture, with what the pointer does in it.
    pub(super) fn viewport(&mut self, ui: &mut egui::Ui) {
        egui::CentralPanel::no_frame().show(ui, |ui| {
            let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
            let rect = response.rect;
            self.times.show_in(self.pixels(rect, ui.ctx()));
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, strings::PICTURE_OF_MODEL));
            if self.model.is_none() {
                let text = self.waiting_text();
                painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
                painter.text(
                    rect.center(),
                    Align2::CENTER_CENTER,
                    text,
                    FontId::proportional(18.0),
                    ui.visuals().text_color(),
                );
                return;
            }
            let motion = self.keys.update(ui.ctx(), rect);
            let latest = self.keys.at().or(ui.input(|input| input.pointer.latest_pos()));
            let pointer = latest.filter(|at| rect.contains(*at));
            // A slow picture has in one frame the keys that set a tool, the stroke with it, and keys that are for the next.
            let events = ui.input(|input| input.events.clone());
            let [before, after] = around_press(&events);
            self.tool_keys(ui, before);
            // First: a press that begins a stroke turns no view, also where a slow picture has the press and the way after it in one frame.
            let hit = self.use_tool(ui, &response, rect, pointer, motion.began);
            self.tool_keys(ui, after);
            self.navigate(ui, &response, rect, motion);
            self.view_keys(ui, hit);
            self.split_key(ui, rect, pointer);
            self.paint(ui, rect);
            self.paint_overlay(ui, rect, hit, pointer);
            self.view_axes(ui, rect);
        });
    }

    fn waiting_text(&self) -> String {
        match (&self.simulation, &self.error) {
            (Some(_), None) => format!("{} {}", strings::OPENING, self.request.path.display()),
            _ => strings::no_model(takes_drops()).to_owned(),
        }
    }

    fn pixels(&self, rect: egui::Rect, context: &egui::Context) -> PixelArea {
        let (scale, screen) = (context.pixels_per_point(), context.content_rect());
        let pixel = |points: f32| (points * scale).round() as i32;
        PixelArea {
            left: pixel(rect.left()),
            bottom: pixel(screen.bottom() - rect.bottom()),
            width: pixel(rect.width()),
            height: pixel(rect.height()),
        }
    }

    fn navigate(&mut self, ui: &egui::Ui, response: &egui::Response, rect: egui::Rect, motion: KeyMotion) {
        let modifiers = ui.input(|input| input.modifiers);
        let is_busy = self.model.as_ref().is_some_and(|model| model.hand.is_busy());
        let navigation = if response.dragged_by(PointerButton::Middle) {
            match (modifiers.shift, modifiers.ctrl) {
                (true, _) => Some(Navigation::Pan),
                (_, true) => Some(Navigation::Zoom),
                _ => Some(Navigation::Orbit),
            }
        } else if response.dragged_by(PointerButton::Secondary) {
            Some(Navigation::Pan)
        } else if response.dragged_by(PointerButton::Primary) && !is_busy && !self.is_press_spent {
            Some(if modifiers.shift { Navigation::Pan } else { Navigation::Orbit })
        } else {
            None
        };
        let frame = Frame { rect, camera: &self.camera };
        let aspect = frame.aspect();
        let height = f64::from(rect.height().max(1.0));
        let moved = response.drag_delta();
        let (across, up) = (f64::from(moved.x) / height, -f64::from(moved.y) / height);
        match navigation {
            Some(Navigation::Orbit) => self.camera.orbit(across, -up),
            Some(Navigation::Pan) => self.camera.pan(across, up),
            Some(Navigation::Zoom) => self.camera.zoom((-2.0 * up).exp(), [0.0; 2], aspect),
            None => {}
        }
        self.camera.orbit(f64::from(motion.turn.x), f64::from(motion.turn.y));
        let scrolled = if response.hovered() { ui.input(|input| input.smooth_scroll_delta.y) } else { 0.0 };
        let wheel = scrolled + motion.wheel;
        if wheel != 0.0 {
            if let (true, Some(model)) = (is_busy, &mut self.model) {
                let length = LIFT_SPEED * f64::from(wheel) * self.settings.size * model.facts.hand.radius;
                model.hand.stroke().into_iter().for_each(|stroke| stroke.lift(length));
            } else {
                let at = self.keys.at().or(ui.input(|input| input.pointer.latest_pos())).unwrap_or(rect.center());
                let place = Frame { rect, camera: &self.camera }.place(at);
                self.camera.zoom(f64::from((-ZOOM_SPEED * wheel).exp()), place, aspect);
            }
        }
    }

    /// Moves the hand; gives where the pointer meets the model.
    fn use_tool(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        rect: egui::Rect,
        pointer: Option<egui::Pos2>,
        key_began: bool,
    ) -> Option<Picked> {
        let radius = self.tool_radius();
        let is_by_device = self.model.as_ref()?.hand.is_by_device();
        if is_by_device {
            self.use_device(ui.ctx());
        }
        let model = self.model.as_mut()?;
        let dt = f64::from(ui.input(|input| input.stable_dt).min(0.1));
        let frame = Frame { rect, camera: &self.camera };
        let latest = self.keys.at().or(ui.input(|input| input.pointer.latest_pos()));
        let is_down = self.keys.is_down() || ui.input(|input| input.pointer.primary_down());
        self.is_press_spent &= is_down;
        // A stroke goes on beside the picture.
        let at = if model.hand.is_busy() { latest } else { pointer };
        let ray = at.map(|at| pointer_ray(self.camera.ray(frame.place(at), frame.aspect())));
        let reach = 2.0 * (self.camera.distance + self.camera.scene_radius) + radius;
        let hit = ray.and_then(|ray| model.pick(&ray, reach));
        let tool = self.tools[self.tool];
        if is_by_device {
            return hit;
        }
        if model.hand.is_busy() {
            // The pointer may have come to where the button was let go since the last frame.
            if !model.hand.has_let_go() && (is_down || ui.input(|input| input.pointer.primary_released())) {
                if let Some(ray) = ray {
                    model.hand.follow(ray, hit.map(|picked| picked.hit.at));
                }
                model.hand.advance(dt);
            } else if model.hand.finish(dt, model.tool().map(|tool| tool.hand), radius) {
                self.log.event("stroke ends", &[("tool", tool.name().into())]);
                if tool.kind.cuts() && self.settings.symmetry.contains(&true) && !model.has_mirrored_cut {
                    model.has_mirrored_cut = true;
                    self.messages.push((Instant::now(), strings::MIRRORED_CUT.to_owned()));
                }
                self.latency.release();
                self.send(Command::EndStroke);
            }
            ui.ctx().request_repaint();
            return hit;
        }
        let is_over = response.hovered() || response.is_pointer_button_down_on();
        let pressed_at =
            ui.input(|input| input.pointer.primary_pressed().then(|| input.pointer.press_origin()).flatten());
        let began = key_began || (is_over && ui.input(|input| input.pointer.primary_pressed()));
        // Where the button was pressed, from which the pointer may have gone on since the last frame.
        let began_at = pressed_at.filter(|at| !key_began && rect.contains(*at)).or(at);
        let began_ray = began_at.map(|at| pointer_ray(self.camera.ray(frame.place(at), frame.aspect())));
        let began_hit = if began { began_ray.and_then(|ray| model.pick(&ray, reach)) } else { None };
        let modifiers = ui.input(|input| input.modifiers);
        let other = match (modifiers.shift, modifiers.command) {
            (true, _) => ToolKind::smoothing(&self.tools),
            (_, true) => tool.inverse(&self.tools),
            _ => None,
        };
        let tool = other.unwrap_or(tool);
        if let Some(why) = model.facts.why_idle(tool).filter(|_| began) {
            self.keys.let_go();
            self.tell(why);
            return hit;
        }
        if let (true, Some(began_ray)) = (began, began_ray) {
            let depth = match tool.gesture() {
                Gesture::Slice => self.settings.cut_depth * model.facts.hand.size,
                _ => self.settings.depth_of(tool) * radius,
            };
            let back = self.camera.axes()[2];
            let focus = self.camera.target.coords;
            let start = StrokeStart {
                gesture: tool.gesture(),
                ray: began_ray,
                hit: began_hit.map(|picked| picked.hit.at),
                back,
                focus,
                radius,
                depth,
            };
            let paint = PaintStroke {
                param: self.settings.painted.min(model.facts.painted.len().saturating_sub(1)),
                lowers: modifiers.command,
            };
            if model.hand.begin(start, tool.buttons(self.settings.release, paint)) {
                self.log.event("stroke begins", &[("tool", tool.name().into())]);
                model.held = began_hit;
                if let Some(ray) = ray {
                    model.hand.follow(ray, hit.map(|picked| picked.hit.at));
                    // The button may be up again by now.
                    model.hand.advance(0.0);
                }
                self.send(Command::BeginStroke(tool.name()));
                if tool.gesture() != Gesture::Slice {
                    self.latency.press();
                }
                ui.ctx().request_repaint();
            } else {
                self.keys.let_go();
            }
        } else if let (Some(picked), false) = (&hit, is_down) {
            model.hand.hover(&picked.hit.at, radius);
        }
        hit
    }

    /// Keys that change what is seen.
    fn view_keys(&mut self, ui: &egui::Ui, hit: Option<Picked>) {
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |key| ui.input(|input| is_pressed(&input.events, key));
        let switched = |key| ui.input(|input| switches(&input.events, key));
        if pressed(Key::F) {
            match hit {
                Some(picked) => self.camera.target = picked.hit.at.point.into(),
                None => self.frame_all(),
            }
        }
        if pressed(Key::Home) {
            self.frame_all();
        }
        if pressed(Key::W) {
            self.next_wireframe();
        }
        if switched(Key::O) {
            self.camera.projection = match self.camera.projection {
                Projection::Perspective => Projection::Orthographic,
                Projection::Orthographic => Projection::Perspective,
            };
        }
    }

    /// The key that makes the part under the pointer a body of its own.
    fn split_key(&mut self, ui: &egui::Ui, rect: egui::Rect, pointer: Option<egui::Pos2>) {
        let pressed = ui.input(|input| is_pressed(&input.events, Key::B));
        let Some(model) = self.model.as_mut().filter(|model| pressed && !model.hand.is_busy()) else { return };
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let frame = Frame { rect, camera: &self.camera };
        let ray = pointer.map(|at| pointer_ray(self.camera.ray(frame.place(at), frame.aspect())));
        let reach = 2.0 * (self.camera.distance + self.camera.scene_radius);
        match ray.and_then(|ray| model.pick_body(&ray, reach)) {
            Some((body, triangle)) => self.split(body, Some(triangle)),
            None => self.tell(strings::NOTHING_TO_SPLIT.to_owned()),
        }
    }

    /// Looks at all of the model.
    pub(super) fn frame_all(&mut self) {
        if let Some(model) = self.model.take() {
            self.look_at_all(&model);
            self.model = Some(model);
        }
    }

    fn paint(&mut self, ui: &egui::Ui, rect: egui::Rect) {
        let (lines, reference) = (self.lines(), self.reference_quad());
        let Some(model) = &mut self.model else { return };
        let Some(renderer) = &self.renderer else {
            model.uploads.clear();
            return;
        };
        // Only where it will be drawn: an image is handed over once.
        let picture = self.reference.take_upload();
        let aspect = Frame { rect, camera: &self.camera }.aspect();
        let background = if ui.visuals().dark_mode {
            [[0.24, 0.26, 0.29], [0.12, 0.13, 0.145]]
        } else {
            [[0.90, 0.91, 0.93], [0.74, 0.76, 0.79]]
        };
        let (camera, stereo) = (self.camera, self.view.stereo);
        let scene = Scene {
            view: camera.view_matrix(Eye::Both),
            projection: camera.projection_matrix(aspect, Eye::Both),
            origins: model.origins(),
            shading: self.view.shading,
            wireframe: self.view.wireframe,
            file_colours: self.view.file_colours,
            opacity: self.view.opacity,
            mark_backs: model.facts.taken_as != Some(Substance::Sheet),
            full_displacement: (2.0 * model.facts.hand.radius) as f32,
            background,
            channels: Channels::All,
            lines,
            reference,
        };
        // They wait until a picture is painted: egui may throw a frame away, as it does with the first one.
        if let Ok(mut pending) = self.pending.lock() {
            if std::mem::take(&mut model.is_new) {
                pending.uploads.clear();
                pending.is_new_model = true;
            }
            pending.uploads.append(&mut model.uploads);
            pending.reference = picture.or(pending.reference.take());
        }
        let pending = Arc::clone(&self.pending);
        let (renderer, times) = (Arc::clone(renderer), Arc::clone(&self.times.drawn));
        let problem = self.reference.problem();
        let paint = move |info: egui::PaintCallbackInfo, _: &egui_glow::Painter| {
            let (Ok(mut renderer), Ok(mut pending)) = (renderer.lock(), pending.lock()) else { return };
            let began = Instant::now();
            pending.was_painted = true;
            if std::mem::take(&mut pending.is_new_model) {
                renderer.clear();
            }
            for upload in pending.uploads.drain(..) {
                renderer.upload(&upload);
            }
            if let Some(picture) = pending.reference.take() {
                let refused = renderer.upload_reference(&picture).err();
                if let Ok(mut problem) = problem.lock() {
                    *problem = refused;
                }
            }
            let uploaded = began.elapsed();
            let area = info.viewport_in_pixels();
            let area = PixelArea {
                left: area.left_px,
                bottom: area.from_bottom_px,
                width: area.width_px,
                height: area.height_px,
            };
            for (eye, channels, area) in eyes(stereo, area) {
                // The picture of a half is drawn for the aspect of the whole: what shows such pictures stretches it.
                let (view, projection) = (camera.view_matrix(eye), camera.projection_matrix(aspect, eye));
                renderer.draw(&Scene { view, projection, channels, ..scene.clone() }, area);
            }
            if let Ok(mut times) = times.lock() {
                remember(&mut times.uploads, uploaded);
                remember(&mut times.draws, began.elapsed() - uploaded);
            }
        };
        let callback = egui::PaintCallback { rect, callback: Arc::new(egui_glow::CallbackFn::new(paint)) };
        ui.painter().add(callback);
    }

    /// The axes of the scene with a cube in the upper right corner: a click on an end or on a face looks from there.
    fn view_axes(&mut self, ui: &egui::Ui, rect: egui::Rect) {
        let centre = rect.right_top() + vec2(-0.5 * AXES_SIZE, 0.5 * AXES_SIZE);
        self.view_cube(ui, centre);
        let [right, up, back] = self.camera.axes();
        let colours =
            [Color32::from_rgb(226, 84, 84), Color32::from_rgb(120, 190, 70), Color32::from_rgb(80, 140, 235)];
        let mut ends: Vec<_> = (0..3).flat_map(|axis| [(axis, 0, 1.0), (axis, 1, -1.0)]).collect();
        // Ends that point away are drawn first.
        ends.sort_by(|a, b| (a.2 * back[a.0]).total_cmp(&(b.2 * back[b.0])));
        for (axis, side, sign) in ends {
            let offset = vec2((sign * right[axis]) as f32, -(sign * up[axis]) as f32) * 38.0;
            let at = centre + offset;
            let id = ui.scope_id().with(("look from", axis, side));
            let response = ui.interact(egui::Rect::from_center_size(at, egui::Vec2::splat(20.0)), id, Sense::click());
            response
                .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, strings::LOOK_FROM[axis][side]));
            let colour = if response.hovered() { Color32::WHITE } else { colours[axis] };
            if side == 0 {
                ui.painter().line_segment([centre, at], egui::Stroke::new(2.0, colour));
                ui.painter().circle_filled(at, 9.0, colour);
                ui.painter().text(
                    at,
                    Align2::CENTER_CENTER,
                    strings::AXES[axis],
                    FontId::proportional(12.0),
                    Color32::BLACK,
                );
            } else {
                ui.painter().circle_filled(at, 6.0, colour.gamma_multiply(0.45));
            }
            if response.clicked() {
                let mut from = nalgebra::Vector3::zeros();
                from[axis] = sign;
                self.camera.look_from(from);
            }
        }
    }

    /// A cube around a place of the screen: a click on a face looks from there.
    fn view_cube(&mut self, ui: &egui::Ui, centre: egui::Pos2) {
        let faces = visible_faces(self.camera.axes(), CUBE_HALF);
        let id = ui.scope_id().with("cube");
        let area = egui::Rect::from_center_size(centre, egui::Vec2::splat(3.4 * CUBE_HALF));
        let pointer = ui.input(|input| input.pointer.latest_pos()).filter(|at| area.contains(*at));
        let under = pointer.and_then(|at| faces.iter().position(|face| face.contains(at - centre)));
        let response = under.map(|_| ui.interact(area, id, Sense::click()));
        for (index, face) in faces.iter().enumerate() {
            let grey = (90.0 + 90.0 * face.facing) as u8;
            let is_under = under == Some(index) && response.as_ref().is_some_and(egui::Response::hovered);
            let fill = if is_under { Color32::from_rgb(255, 215, 150) } else { Color32::from_gray(grey) };
            let corners: Vec<_> = face.corners.iter().map(|corner| centre + *corner).collect();
            let edge = egui::Stroke::new(1.0, Color32::from_gray(50));
            ui.painter().add(egui::Shape::convex_polygon(corners, fill, edge));
        }
        if let (Some(under), true) = (under, response.is_some_and(|response| response.clicked())) {
            self.camera.look_from(faces[under].normal());
        }
    }

    fn paint_overlay(&mut self, ui: &egui::Ui, rect: egui::Rect, hit: Option<Picked>, pointer: Option<egui::Pos2>) {
        let painter = ui.painter().with_clip_rect(rect);
        let frame = Frame { rect, camera: &self.camera };
        let text = ui.visuals().text_color();
        overlay::scale_bar(&painter, frame, text);
        let Some(model) = &self.model else { return };
        let tool = self.tools[self.tool];
        let radius = self.settings.size * model.facts.hand.radius;
        let is_busy = model.hand.is_busy();
        if model.hand.is_by_device() {
            if let Some(felt) = model.tool() {
                let colour = if is_busy { Color32::from_rgb(255, 170, 40) } else { Color32::from_rgb(120, 210, 255) };
                overlay::ring(&painter, frame, felt.proxy.into(), self.camera.axes()[2], radius, colour);
            }
        } else if let (Some(at), false) = (self.ring_place(hit, pointer), tool.gesture() == Gesture::Slice) {
            let colour = if is_busy { Color32::from_rgb(255, 170, 40) } else { Color32::from_rgb(120, 210, 255) };
            overlay::ring(&painter, frame, at.point.into(), at.normal, radius, colour);
            if let Some(region) = tool.region() {
                let faint = colour.gamma_multiply(0.35);
                overlay::ring(&painter, frame, at.point.into(), at.normal, region * radius, faint);
            }
            let symmetry = model.symmetry(self.settings.symmetry);
            for image in symmetry.images() {
                let (point, normal) = (symmetry.point(at.point, image), mirrored(at.normal, image));
                overlay::ring(&painter, frame, point.into(), normal, radius, colour.gamma_multiply(0.6));
            }
        }
        if let (Some(at), true) = (pointer, tool.gesture() == Gesture::Slice && !model.hand.is_by_device()) {
            let colour = if is_busy { Color32::from_rgb(255, 110, 90) } else { text };
            painter.circle_stroke(at, 4.0, egui::Stroke::new(1.5, colour));
            painter.line_segment([at + vec2(6.0, -6.0), at + vec2(16.0, -16.0)], egui::Stroke::new(2.5, colour));
        }
        if let Some([Some(from), Some(to)]) = model.hand.line().map(|ends| ends.map(|end| frame.to_screen(&end.into())))
        {
            painter.line_segment([from, to], egui::Stroke::new(4.0, Color32::from_black_alpha(120)));
            painter.line_segment([from, to], egui::Stroke::new(2.0, Color32::from_rgb(255, 110, 90)));
        }
        let contact_places = model.contacts().iter().map(|contact| (Point3::from(contact.position), contact.share));
        overlay::contact_points(&painter, frame, contact_places);
        // The pointer draws its line; a device holds the blade itself.
        if tool.gesture() == Gesture::Slice && model.hand.is_by_device() {
            for blade in model.blades() {
                overlay::blade(&painter, frame, blade.ends.map(Point3::from));
            }
        }
        self.paint_messages(&painter, rect);
        if let Some(felt) = model.tool() {
            // Half of the longest arrow is the force that presses the spring to the hand by half of the tool's radius.
            let usual = 0.5 * self.settings.size * model.facts.hand.coupling * radius;
            overlay::force_arrow(&painter, frame, Point3::from(felt.proxy), felt.force, usual);
            self.force.add(ui.input(|input| input.time), felt.force.norm());
        }
    }
}

impl App {
    /// Where the ring of the tool lies. In a stroke it moves with the surface: with what is held, or with what the pointer was over.
    fn ring_place(&self, hit: Option<Picked>, pointer: Option<egui::Pos2>) -> Option<SurfacePoint> {
        let model = self.model.as_ref()?;
        match model.hand.gesture() {
            None => hit.filter(|_| pointer.is_some()).map(|picked| picked.hit.at),
            Some(Gesture::Drag) => model.present(&model.held?),
            Some(Gesture::Press | Gesture::Slice) => model.present(&hit?),
        }
    }

    /// The last messages over the picture, whole, in as many lines as they take.
    fn paint_messages(&self, painter: &egui::Painter, rect: egui::Rect) {
        let recent = self.messages.iter().rev().filter(|(when, text)| when.elapsed() < shown_for(text)).take(2);
        // Beside the axes in the corner, or where the picture is narrow below them.
        let beside = rect.width() - 2.0 * AXES_SIZE - 16.0;
        let is_beside = beside >= NARROWEST_MESSAGE;
        let width = if is_beside { beside.min(WIDEST_MESSAGE) } else { (rect.width() - 24.0).max(80.0) };
        let mut top = rect.top() + if is_beside { 14.0 } else { AXES_SIZE };
        for (_, text) in recent {
            let (font, colour) = (FontId::proportional(14.0), Color32::from_rgb(255, 225, 190));
            let galley = painter.layout(text.clone(), font, colour, width);
            let left_top = egui::pos2(rect.center().x - 0.5 * galley.size().x, top);
            let back = egui::Rect::from_min_size(left_top, galley.size()).expand2(vec2(8.0, 2.0));
            top = back.bottom() + 4.0;
            painter.rect_filled(back, 4.0, Color32::from_black_alpha(170));
            painter.galley(left_top, galley, Color32::WHITE);
        }
    }
}

/// Time for which a message is shown over the picture: as long as it takes to be read.
pub(super) fn shown_for(text: &str) -> Duration {
    SHOWN + READING.saturating_mul(text.len() as u32)
}

/// The pictures that are drawn: an eye, channels, and a part of the target for each.
fn eyes(stereo: Stereo, area: PixelArea) -> Vec<(Eye, Channels, PixelArea)> {
    match stereo {
        Stereo::Off => vec![(Eye::Both, Channels::All, area)],
        Stereo::Anaglyph => vec![(Eye::Left, Channels::Red, area), (Eye::Right, Channels::GreenAndBlue, area)],
        Stereo::SideBySide => {
            let half = area.width / 2;
            let left = PixelArea { width: half, ..area };
            let right = PixelArea { left: area.left + half, width: area.width - half, ..area };
            vec![(Eye::Left, Channels::All, left), (Eye::Right, Channels::All, right)]
        }
    }
}
