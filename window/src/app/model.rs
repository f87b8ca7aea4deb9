//! The model that is open, as the window sees it.

use super::ViewSettings;
use super::gauges::FrameTimes;
use crate::gl::{Line, Wireframe};
use crate::materials::{MaterialLoad, SurfaceMaterials};
use crate::opening::ModelFacts;
use crate::picture::Upload;
use crate::sim::OpenModel;
use crate::strings;
use crate::stroke::HandControl;
use crate::symmetry::Symmetry;
use crate::view::Camera;
use crate::view::overlay::round_length;
use eframe::egui;
use nalgebra::{Point3, Vector3};
use pliant_editor::surface::{Hit, Picker, ViewSurface};
use pliant_editor::{DeviceHand, PointerRay, SurfacePoint};
use pliant_engine::body::Axes;
use pliant_engine::session::ToolFrame;
use pliant_live::{BladeEdgeView, ContactPoint, PointerHandle, ViewReader};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The model that is open.
pub(super) struct Model {
    pub(super) facts: ModelFacts,
    pub(super) hand: HandControl,
    reader: ViewReader,
    surfaces: Vec<ViewSurface>,
    /// Number of bodies that moved when the model was opened, and of those that stand, which follow them in `surfaces`. Bodies that were split off come last.
    opened: [usize; 2],
    /// Materials of each body that was opened.
    looks: Vec<Arc<SurfaceMaterials>>,
    pickers: Vec<Picker>,
    /// What has moved of each body since the pickers were told: not during a stroke.
    untold: Vec<Untold>,
    /// Whether the edges that were uploaded last are those of the model.
    has_edges: bool,
    /// Whether `cut_edges` are those of the model.
    has_cut_edges: bool,
    /// When edges were listed last.
    edges_listed: Option<Instant>,
    /// Edges that cuts have made: the body, and mesh vertices at their ends.
    cut_edges: Vec<(usize, [u32; 2])>,
    /// m, least and greatest coordinates of all bodies when they were opened
    opened_bounds: [Vector3<f64>; 2],
    /// What was met where the stroke under way began.
    pub(super) held: Option<Picked>,
    /// Whether a cut was mirrored, of which people were told.
    pub(super) has_mirrored_cut: bool,
    /// Until the materials are there.
    materials: Option<MaterialLoad>,
    pub(super) uploads: Vec<Upload>,
    /// Whether the renderer still has the bodies of another model.
    pub(super) is_new: bool,
    /// Lives as long as the model.
    _waker: Waker,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picked {
    /// Index of the body among the surfaces that are drawn.
    body: usize,
    pub(super) hit: Hit,
}

/// Vertices and triangles that a picker has not been told of.
#[derive(Clone, Default)]
struct Untold {
    moved: Vec<u32>,
    triangles: Vec<u32>,
}

/// Time between two looks for a new frame: a quarter of the time between frames.
const POLL: Duration = Duration::from_millis(4);
/// Distance of lines on the surface from it towards the viewer, as a share of that of the camera.
const CUT_LINE_OFFSET: f64 = 1.5e-3;
/// Colour of the edges of a cut.
const CUT_LINE: [f32; 4] = [0.45, 0.06, 0.05, 0.9];
/// Shortest time between two lists of edges while a cut goes on.
const EDGE_PERIOD: Duration = Duration::from_millis(250);

impl Model {
    /// Tints of the drawn vertices that are pinned or painted.
    pub(super) fn tints(&self) -> impl Iterator<Item = f32> + '_ {
        let of = |surface: &'_ ViewSurface| {
            (0..surface.drawn().len()).map(|drawn| surface.tint(drawn)).collect::<Vec<f32>>()
        };
        self.surfaces.iter().flat_map(of).filter(|tint| *tint != 0.0)
    }

    /// `material_folder`: where the model's `mtllib` files are, if not beside the file that was opened.
    pub(super) fn new(opened: OpenModel, material_folder: Option<PathBuf>, context: egui::Context) -> Self {
        let OpenModel { facts, reader, surfaces, models, hand, device_hand, device_frame, .. } = opened;
        let materials = Some(MaterialLoad::start(models, material_folder, context.clone()));
        let pickers = surfaces.iter().map(Picker::new).collect();
        let uploads = surfaces.iter().enumerate().map(|(body, surface)| Upload::whole(body, surface)).collect();
        let mut control = HandControl::new(hand, device_hand, device_frame);
        // Somewhere beside the model, until the pointer is over it.
        control.wait_at(
            surfaces.first().map_or(Vector3::zeros(), |s| s.origin) + facts.hand.size * Vector3::new(0.0, 2.0, 0.0),
        );
        let moving = reader.bodies.iter().filter(|body| body.moves).count();
        let opened = [moving, surfaces.len() - moving];
        let (waker, opened_bounds) = (Waker::start(&reader, context), bounds_of(&surfaces));
        Self {
            facts,
            hand: control,
            reader,
            untold: vec![Untold::default(); surfaces.len()],
            opened,
            looks: Vec::new(),
            surfaces,
            pickers,
            has_edges: false,
            has_cut_edges: true,
            edges_listed: None,
            cut_edges: Vec::new(),
            opened_bounds,
            held: None,
            has_mirrored_cut: false,
            materials,
            uploads,
            is_new: true,
            _waker: waker,
        }
    }

    /// Its hand, and the device that can have it: the model is closed, and the hand goes on.
    pub(super) fn into_hand(self) -> (PointerHandle, Option<DeviceHand>) {
        self.hand.into_hand()
    }

    /// Takes in the newest frame, and lists what is to be uploaded.
    pub(super) fn update(&mut self, times: &mut FrameTimes, view: ViewSettings) {
        let began = Instant::now();
        self.reader.set_cells_enabled(view.cells);
        if self.reader.update() {
            let patches = self.reader.take_patches();
            let [moving, standing] = self.opened;
            self.follow_splits();
            let frame = self.reader.frame();
            for (index, shown) in frame.bodies.iter().enumerate() {
                let body = if index < moving { index } else { index + standing };
                let Some(surface) = self.surfaces.get_mut(body) else { continue };
                let of_body: Vec<_> = patches.iter().filter(|patch| patch.body == index).cloned().collect();
                let changes = surface.update(frame.number, shown, &of_body);
                if changes.is_empty() {
                    continue;
                }
                self.uploads.push(Upload::changes(body, surface, &changes));
                let untold = &mut self.untold[body];
                untold.moved.extend_from_slice(&changes.moved);
                let changed = changes.triangles.iter().flat_map(|range| range.clone().map(|t| t as u32));
                untold.triangles.extend(changed);
                if !changes.triangles.is_empty() {
                    (self.has_edges, self.has_cut_edges) = (false, false);
                }
            }
        }
        // The hand follows the surface as it was when the stroke began, not the dent that it makes.
        if !self.hand.is_busy() {
            for ((picker, surface), untold) in self.pickers.iter_mut().zip(&self.surfaces).zip(&mut self.untold) {
                untold.moved.sort_unstable();
                untold.moved.dedup();
                picker.update(surface, &untold.moved, untold.triangles.drain(..));
                untold.moved.clear();
            }
        }
        self.list_edges(view.wireframe != Wireframe::Off);
        times.copy(began.elapsed());
    }

    /// Lists the edges that cuts have made, and those of the wireframe if that is shown, where they have changed: each takes a look at the whole surface.
    fn list_edges(&mut self, shows_wireframe: bool) {
        if self.edges_listed.is_some_and(|listed| listed.elapsed() <= EDGE_PERIOD) {
            return;
        }
        if !self.has_cut_edges {
            (self.has_cut_edges, self.edges_listed) = (true, Some(Instant::now()));
            let each = self.surfaces.iter().enumerate();
            let edges = each.flat_map(|(body, surface)| surface.cut_edges().into_iter().map(move |ends| (body, ends)));
            self.cut_edges = edges.collect();
        }
        if shows_wireframe && !self.has_edges {
            (self.has_edges, self.edges_listed) = (true, Some(Instant::now()));
            for (body, surface) in self.surfaces.iter().enumerate() {
                let (vertices, triangles) = (surface.drawn().len(), surface.corners().len());
                let edges = Some(surface.edges());
                self.uploads.push(Upload { body, vertices, triangles, edges, ..Upload::default() });
            }
        }
    }

    /// Adds a surface for each body that was split off since the last frame, and takes those away that an undo has made part of another again.
    fn follow_splits(&mut self) {
        let bodies = &self.reader.frame().bodies;
        let count = self.surfaces.len().min(bodies.len() + self.opened[1]).max(self.opened.iter().sum());
        for body in count..self.surfaces.len() {
            self.uploads.push(Upload { body, ..Upload::default() });
        }
        self.surfaces.truncate(count);
        self.pickers.truncate(count);
        self.untold.truncate(count);
        for view in bodies.iter().skip(count - self.opened[1]) {
            let body = self.surfaces.len();
            let surface = ViewSurface::of_new_body(strings::SPLIT_OFF.to_owned(), view);
            self.pickers.push(Picker::new(&surface));
            self.untold.push(Untold::default());
            self.surfaces.push(surface);
            // Parts have the materials of the file; a scene of several bodies has those of the first.
            let materials = self.looks.first().cloned();
            self.uploads.push(Upload { body, materials, ..Upload::default() });
        }
    }

    /// The body and triangle that a ray meets first, as the session numbers them; `None` where it meets nothing that moves.
    pub(super) fn pick_body(&mut self, ray: &PointerRay, reach: f64) -> Option<(u32, u32)> {
        let [moving, standing] = self.opened;
        let Picked { body, hit } = self.pick(ray, reach)?;
        let stands = (moving..moving + standing).contains(&body);
        let body = if body < moving { body } else { body - standing };
        (!stands).then_some((body as u32, hit.triangle))
    }

    /// Number of bodies that move.
    pub(super) fn moving_bodies(&self) -> usize {
        self.surfaces.len() - self.opened[1]
    }

    /// Takes in the materials once they are read; gives a sentence for each that cannot be.
    pub(super) fn take_materials(&mut self) -> Vec<String> {
        let Some(read) = self.materials.as_ref().and_then(MaterialLoad::take) else { return Vec::new() };
        self.materials = None;
        let mut problems = Vec::new();
        for (body, (materials, of_body)) in read.into_iter().enumerate().take(self.surfaces.len()) {
            let surface = &self.surfaces[body];
            let (vertices, triangles) = (surface.drawn().len(), surface.corners().len());
            let materials = Arc::new(materials);
            self.looks.push(Arc::clone(&materials));
            self.uploads.push(Upload { body, vertices, triangles, materials: Some(materials), ..Upload::default() });
            problems.extend(of_body);
        }
        problems
    }

    /// What a ray meets first; in a stroke on the surface as it was when the stroke began.
    pub(super) fn pick(&mut self, ray: &PointerRay, reach: f64) -> Option<Picked> {
        let each = self.pickers.iter_mut().zip(&self.surfaces).enumerate();
        let hits = each.filter_map(|(body, (picker, s))| Some(Picked { body, hit: picker.pick(s, ray, reach)? }));
        hits.min_by(|a, b| a.hit.distance.total_cmp(&b.hit.distance))
    }

    /// Where the point of the surface that was met is in the newest frame; `None` once it has been cut away.
    pub(super) fn present(&self, picked: &Picked) -> Option<SurfacePoint> {
        self.surfaces.get(picked.body)?.point_at(picked.hit.triangle, &picked.hit.weights)
    }

    /// The tool of the newest frame.
    pub(super) fn tool(&self) -> Option<ToolFrame> {
        self.reader.frame().tools.first().copied()
    }

    /// Where tools touch in the newest frame.
    pub(super) fn contacts(&self) -> &[ContactPoint] {
        &self.reader.frame().contacts
    }

    /// Blades in the newest frame.
    pub(super) fn blades(&self) -> &[BladeEdgeView] {
        &self.reader.frame().blades
    }

    /// Triangles of all bodies.
    pub(super) fn triangles(&self) -> usize {
        self.surfaces.iter().map(|surface| surface.triangles().len()).sum()
    }

    /// m, places of the scene that positions of bodies are relative to
    pub(super) fn origins(&self) -> Vec<[f64; 3]> {
        self.surfaces.iter().map(|surface| surface.origin.into()).collect()
    }

    /// The planes in which strokes are mirrored along these axes. They are those of the model as it was opened, however its shape changes.
    pub(super) fn symmetry(&self, axes: Axes) -> Symmetry {
        Symmetry::of_model(axes, self.opened_bounds)
    }

    /// Centre and radius (m) of a ball around all bodies.
    pub(super) fn ball(&self) -> (Point3<f64>, f64) {
        ball_of(bounds_of(&self.surfaces))
    }

    /// m, least and greatest coordinates of all bodies when they were opened: what stands around the model stays while it moves, and
    /// looks at no vertex.
    pub(super) fn opened_bounds(&self) -> [Vector3<f64>; 2] {
        self.opened_bounds
    }

    /// The grid on the ground, edges of cuts and the simulated cells.
    pub(super) fn lines(&self, view: ViewSettings, camera: &Camera) -> Vec<Line> {
        let mut lines = Vec::new();
        if view.ground {
            self.ground(camera, &mut lines);
        }
        self.cut_lines(camera, &mut lines);
        if view.cells {
            for corners in &self.reader.frame().cells {
                // Corner i has the bits of i as its x, y and z.
                let edges = (0..8).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit))).filter(|(a, b)| a != b);
                let colour = [0.35, 0.75, 1.0, 0.35];
                lines.extend(edges.map(|(a, b)| Line { ends: [corners[a], corners[b]], colour }));
            }
        }
        lines
    }

    /// Edges that cuts have made, without which a cut that has not opened would not be seen.
    fn cut_lines(&self, camera: &Camera, lines: &mut Vec<Line>) {
        let nearer = CUT_LINE_OFFSET * camera.distance * camera.axes()[2];
        for (body, ends) in &self.cut_edges {
            let Some(surface) = self.surfaces.get(*body) else { continue };
            let place = |vertex: u32| surface.positions().get(vertex as usize).map(|p| Vector3::from(p.map(f64::from)));
            if let [Some(a), Some(b)] = ends.map(place) {
                let ends = [a, b].map(|place| (surface.origin + place + nearer).map(|c| c as f32).into());
                lines.push(Line { ends, colour: CUT_LINE });
            }
        }
    }

    fn ground(&self, camera: &Camera, lines: &mut Vec<Line>) {
        let (centre, radius) = ball_of(self.opened_bounds);
        let up = camera.up_direction();
        let step = round_length(0.5 * radius);
        let (u, v) = (Vector3::new(1.0, 0.0, 0.0), Vector3::new(1.0, 0.0, 0.0).cross(&up));
        let [low, _] = self.opened_bounds;
        let height = low.dot(&up.abs());
        let reach = (2.0 * radius / step).ceil() as i32;
        let round = |x: f64| (x / step).round() * step;
        let middle = round(centre.coords.dot(&u)) * u + round(centre.coords.dot(&v)) * v + height * up;
        let end = |across: f64, along: f64| (middle + across * step * u + along * step * v).map(|c| c as f32).into();
        let far = f64::from(reach);
        for n in -reach..=reach {
            let at = f64::from(n);
            let colour = [0.55, 0.58, 0.62, 0.28];
            lines.push(Line { ends: [end(at, -far), end(at, far)], colour });
            lines.push(Line { ends: [end(-far, at), end(far, at)], colour });
        }
    }
}

/// m, least and greatest coordinates of surfaces
fn bounds_of(surfaces: &[ViewSurface]) -> [Vector3<f64>; 2] {
    let mut bounds = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    for surface in surfaces {
        for place in surface.positions() {
            let place = surface.origin + Vector3::from(place.map(f64::from));
            bounds = [bounds[0].inf(&place), bounds[1].sup(&place)];
        }
    }
    bounds
}

/// Centre and radius (m) of the ball around a box (m).
fn ball_of([low, high]: [Vector3<f64>; 2]) -> (Point3<f64>, f64) {
    (Point3::from(0.5 * (low + high)), (0.5 * (high - low).norm()).max(1e-6))
}

/// Asks for a repaint when a frame differs from the last, so that a picture in which nothing moves costs nothing.
struct Waker {
    stop: Arc<AtomicBool>,
}

impl Waker {
    fn start(reader: &ViewReader, context: egui::Context) -> Self {
        let (stop, changes) = (Arc::new(AtomicBool::new(false)), reader.changes());
        let of_thread = Arc::clone(&stop);
        let watch = move || {
            let mut seen = 0;
            while !of_thread.load(Ordering::Relaxed) {
                let now = changes.load(Ordering::Acquire);
                if std::mem::replace(&mut seen, now) != now {
                    context.request_repaint();
                }
                std::thread::sleep(POLL);
            }
        };
        // Without the thread the picture follows twice a second.
        let _ = std::thread::Builder::new().name("waker".into()).spawn(watch);
        Self { stop }
    }
}

impl Drop for Waker {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
