//! Frames from the simulation to a viewer. Positions go through a triple buffer, of which only the newest is read; changes of topology go through a
//! queue, which loses none. Neither side waits for the other, and only changed pages are copied.

use super::contact::{list_blades, list_contacts};
use super::frame::{BodyTopology, BodyView, TopologyPatch, ViewFrame, look_alike};
use pliant_engine::body::{Body, PAGE, TriangleLook, tint_of};
use pliant_engine::session::{Session, ToolFrame};
use pliant_solver::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};
use triple_buffer::{Input, Output, triple_buffer};

/// Time between two frames, ns.
const FRAME_PERIOD: u64 = 1_000_000_000 / 60;
/// Least time between two frames over the time that making one takes: frames of a large model take a fifth of the simulation's time at most.
const LEAST_PAUSE: u32 = 5;
/// Longest time between two frames, ns: one frame of a large change, as an undo of a million triangles, does not hold up those after it.
const LONGEST_PAUSE: u64 = 500_000_000;

/// Time (ns) from the beginning of a frame to that of the next one, where making it took `cost`.
fn pause_after(cost: Duration) -> u64 {
    let pause = (LEAST_PAUSE * cost).as_nanos().min(u128::from(LONGEST_PAUSE)) as u64;
    pause.max(FRAME_PERIOD)
}

/// The simulation's end.
pub struct ViewWriter {
    frames: Input<ViewFrame>,
    patches: Sender<TopologyPatch>,
    wants_cells: Arc<AtomicBool>,
    changes: Arc<AtomicU64>,
    bodies: Vec<BodyTrack>,
    /// Tools of the last frame that counted as another one.
    tools: Vec<ToolFrame>,
    /// Number of the last frame.
    number: u64,
    /// Time of the next frame, ns.
    next_frame_ns: u64,
}

/// The viewer's end.
pub struct ViewReader {
    frames: Output<ViewFrame>,
    patches: Receiver<TopologyPatch>,
    /// Patches of frames that have not been read yet.
    pending_patches: Vec<TopologyPatch>,
    wants_cells: Arc<AtomicBool>,
    changes: Arc<AtomicU64>,
    /// Topology of the bodies at the opening of the session: first moving bodies, then the others.
    pub bodies: Vec<BodyTopology>,
}

/// The writer's record of a body.
struct BodyTrack {
    origin: Vec3,
    /// Last change stamps of the surface and of the triangles that were copied.
    vertices_seen: u64,
    triangles_seen: u64,
    triangles: usize,
    patches: u64,
    /// Number of the frame in which each page of vertices last changed.
    stamps: Vec<u64>,
}

/// The two ends of a buffer for the views of a session.
pub fn view_buffer(session: &Session) -> (ViewWriter, ViewReader) {
    let (frames, output) = triple_buffer(&ViewFrame::default());
    let (sender, patches) = channel();
    let wants_cells = Arc::new(AtomicBool::new(false));
    let changes = Arc::new(AtomicU64::new(0));
    let moving = session.bodies.iter().map(|body| {
        let looks = (0..body.model.surface.triangles.len() as u32).map(|t| body.look(t)).collect();
        topology(&body.name, body.model.surface.bounds().centre(), &body.skin.x, looks, true)
    });
    let standing = session.standing.iter().map(|(name, model)| {
        let looks = (0..model.surface.triangles.len() as u32).map(|t| model.look(t, None)).collect();
        topology(name, model.surface.bounds().centre(), &model.surface.points, looks, false)
    });
    let bodies: Vec<BodyTopology> = moving.chain(standing).collect();
    let tracks = bodies.iter().zip(&session.bodies).map(|(topology, body)| BodyTrack {
        origin: topology.origin,
        vertices_seen: 0,
        triangles_seen: 0,
        triangles: body.model.surface.triangles.len(),
        patches: 0,
        stamps: vec![1; body.skin.x.len().div_ceil(PAGE)],
    });
    let writer = ViewWriter {
        frames,
        patches: sender,
        wants_cells: Arc::clone(&wants_cells),
        changes: Arc::clone(&changes),
        bodies: tracks.collect(),
        tools: Vec::new(),
        number: 0,
        next_frame_ns: 0,
    };
    (writer, ViewReader { frames: output, patches, pending_patches: Vec::new(), wants_cells, changes, bodies })
}

fn topology(name: &str, origin: Vec3, points: &[Vec3], looks: Vec<Option<TriangleLook>>, moves: bool) -> BodyTopology {
    let positions = points.iter().map(|point| (point - origin).map(|c| c as f32).into()).collect();
    BodyTopology { name: name.to_owned(), triangles: Arc::new(looks), origin, positions, moves }
}

impl ViewWriter {
    /// Publishes a frame of the session if one is due at `now` (ns): sixty per second, or as many as take a fifth of the time, but at least
    /// one every half second.
    pub fn publish_if_due(&mut self, session: &mut Session, now: u64) {
        if now >= self.next_frame_ns {
            let began = Instant::now();
            self.publish(session);
            self.next_frame_ns = now + pause_after(began.elapsed());
        }
    }

    /// Publishes a frame of the session.
    pub fn publish(&mut self, session: &mut Session) {
        session.update_surface();
        self.number += 1;
        let number = self.number;
        let frame = self.frames.input_buffer_mut();
        frame.number = number;
        frame.time = session.time();
        frame.steps = session.steps();
        let felt = session.frame();
        let mut changed = !look_alike(&self.tools, &felt.tools);
        if changed {
            self.tools.clone_from(&felt.tools);
        }
        frame.tools.clone_from(&felt.tools);
        list_contacts(session, &mut frame.contacts);
        list_blades(session, &mut frame.blades);
        (frame.nodes, frame.elements) = (felt.nodes, felt.elements);
        frame.bodies.resize_with(session.bodies.len(), BodyView::default);
        frame.cells.clear();
        // Bodies that were split are more than before, and after an undo fewer: new ones begin without triangles and send all of them.
        self.bodies.truncate(session.bodies.len());
        for body in &session.bodies[self.bodies.len()..] {
            self.bodies.push(BodyTrack::empty(body));
        }
        let wants_cells = self.wants_cells.load(Ordering::Relaxed);
        for (index, body) in session.bodies.iter_mut().enumerate() {
            let Some(track) = self.bodies.get_mut(index) else { continue };
            if let Some(patch) = track.patch(index, body) {
                // An error means the reader is gone; ignore it.
                let _ = self.patches.send(patch);
                changed = true;
            }
            changed |= track.copy(&mut frame.bodies[index], body, number);
            if wants_cells {
                frame.cells.extend(active_cells(body));
            }
        }
        self.frames.publish();
        if changed {
            self.changes.fetch_add(1, Ordering::Release);
        }
    }
}

impl BodyTrack {
    /// The record of a body that no viewer has seen yet.
    fn empty(body: &Body) -> Self {
        let origin = body.model.surface.bounds().centre();
        Self { origin, vertices_seen: 0, triangles_seen: 0, triangles: 0, patches: 0, stamps: Vec::new() }
    }

    /// Changes of a body's triangles since the last frame; `None` if there are none.
    fn patch(&mut self, index: usize, body: &mut Body) -> Option<TopologyPatch> {
        let count = body.model.surface.triangles.len();
        let seen = self.triangles_seen;
        self.triangles_seen = std::sync::Arc::make_mut(&mut body.model).pages.end_period();
        let mut changed = Vec::new();
        for page in body.model.pages.changed_after(seen) {
            let triangles = (page * PAGE) as u32..((page + 1) * PAGE).min(count) as u32;
            changed.extend(triangles.map(|t| (t, body.look(t))));
        }
        if changed.is_empty() && count == self.triangles {
            return None;
        }
        self.triangles = count;
        self.patches += 1;
        Some(TopologyPatch { body: index, number: self.patches, count, changed })
    }

    /// Updates one of the three buffers page by page. Returns whether any page has changed since the last frame.
    fn copy(&mut self, view: &mut BodyView, body: &mut Body, number: u64) -> bool {
        let (skin, tints) = body.skin_with_tints();
        let count = skin.x.len();
        self.stamps.resize(count.div_ceil(PAGE), number);
        let seen = self.vertices_seen;
        self.vertices_seen = skin.pages.end_period();
        let mut changed = false;
        for page in skin.pages.changed_after(seen) {
            if let Some(stamp) = self.stamps.get_mut(page) {
                *stamp = number;
                changed = true;
            }
        }
        view.origin = self.origin;
        view.patches = self.patches;
        view.positions.resize(count, [0.0; 3]);
        view.displacements.resize(count, 0.0);
        view.tints.resize(count, 0.0);
        view.stamps.resize(self.stamps.len(), 0);
        for (page, stamp) in self.stamps.iter().enumerate() {
            if view.stamps[page] == *stamp {
                continue;
            }
            for v in page * PAGE..((page + 1) * PAGE).min(count) {
                view.positions[v] = (skin.x[v] - self.origin).map(|c| c as f32).into();
                view.displacements[v] = (skin.x[v] - skin.settled[v]).norm() as f32;
                view.tints[v] = tint_of(tints, v as u32);
            }
            view.stamps[page] = *stamp;
        }
        changed
    }
}

/// Corners of the simulated cells of a body, m.
fn active_cells(body: &Body) -> impl Iterator<Item = [[f32; 3]; 8]> + '_ {
    let lattice = body.discretization.lattice();
    let corners = lattice.map_or(&[][..], |lattice| &lattice.region().cell_corners);
    let place = |node: u32| body.system.nodes.x[node as usize].map(|c| c as f32).into();
    corners.iter().map(move |cell| cell.map(place))
}

impl ViewReader {
    /// Reads the newest frame. Returns whether it is a new one.
    pub fn update(&mut self) -> bool {
        self.frames.update()
    }

    /// The frame that was read last.
    pub fn frame(&self) -> &ViewFrame {
        self.frames.output_buffer()
    }

    /// Returns the topology patches up to the frame that was read last, in order; each is returned once.
    pub fn take_patches(&mut self) -> Vec<TopologyPatch> {
        self.pending_patches.extend(self.patches.try_iter());
        let frame = self.frames.output_buffer();
        let ready = |patch: &TopologyPatch| frame.bodies.get(patch.body).is_some_and(|b| patch.number <= b.patches);
        let (now, later) = std::mem::take(&mut self.pending_patches).into_iter().partition(ready);
        self.pending_patches = later;
        now
    }

    /// A counter that increases with every frame in which a surface or a tool has changed. It can be read from any thread to decide whether to redraw.
    pub fn changes(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.changes)
    }

    /// Enables or disables the simulated cells in frames.
    pub fn set_cells_enabled(&self, enabled: bool) {
        self.wants_cells.store(enabled, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pause_after_a_frame_is_in_proportion_up_to_half_a_second() {
        let pause = |milliseconds| pause_after(Duration::from_millis(milliseconds));
        assert_eq!([0, 3].map(pause), [FRAME_PERIOD; 2], "sixty per second");
        assert_eq!([20, 80].map(pause), [100_000_000, 400_000_000], "a fifth of the time");
        assert_eq!([400, 60_000].map(pause), [LONGEST_PAUSE; 2]);
    }
}
