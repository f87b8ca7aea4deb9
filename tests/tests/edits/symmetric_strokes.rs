//! Mirrored strokes of an editor: a symmetric model stays symmetric to the bit, whatever tool has stroked it, and what was done to one side alone stays.

use nalgebra::UnitQuaternion;
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::body::{Axes, mirrored};
use pliant_engine::edit::{EditKind, KINDS};
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, HandPose, Session, SessionCommand};
use pliant_mesh::testing::Random;
use pliant_record::state_digest;
use pliant_solver::Vec3;
use pliant_tests::{Bench, asked_cases, open_drafted};
use std::collections::{HashMap, HashSet};
use std::fmt::Write;

/// m, largest half edge of a model's box
const HALF: f64 = 0.05;
/// Edges of the surface of a generated cube across half of it.
const CELLS: i32 = 7;

/// A rounded body, symmetric to the bit along all axes: a cube whose surface is pulled towards a sphere, with bumps that depend on the sizes of the
/// coordinates alone. Its quads are not divided, or along diagonals that are mirror images where `is_divided` is set.
fn symmetric_solid(random: &mut Random, is_divided: bool) -> String {
    let share = 0.5 + 0.3 * random.unit();
    let bump = [0, 1, 2].map(|_| 0.15 * random.signed());
    let wave = [0, 1, 2].map(|_| 2.0 + 3.0 * random.unit());
    let mut text = String::new();
    let mut index = HashMap::new();
    let range = || -CELLS..=CELLS;
    let grid = range().flat_map(|i| range().flat_map(move |j| range().map(move |k| [i, j, k])));
    for at in grid.filter(|at| at.iter().any(|c| c.abs() == CELLS)) {
        let size = at.map(|c| f64::from(c.abs()) / f64::from(CELLS));
        let length = (size[0] * size[0] + size[1] * size[1] + size[2] * size[2]).sqrt();
        let bumps = (0..3).map(|i| bump[i] * (wave[i] * size[i]).cos()).sum::<f64>();
        let factor = HALF * (1.0 - share + share / length) * (1.0 + bumps) / 1.5;
        let p: Vec<f64> = (0..3).map(|i| f64::from(at[i].signum()) * (size[i] * factor)).collect();
        index.insert(at, index.len() + 1);
        writeln!(text, "v {:?} {:?} {:?}", p[0], p[1], p[2]).expect("written");
    }
    for axis in 0..3 {
        for side in [-1, 1] {
            for (u, v) in (-CELLS..CELLS).flat_map(|u| (-CELLS..CELLS).map(move |v| (u, v))) {
                let corner = |du: i32, dv: i32| {
                    let mut at = [0; 3];
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side * CELLS, u + du, v + dv);
                    index[&at]
                };
                let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                // The diagonal of a quad and those of its mirror images lie away from the middle of the side.
                if (u < 0) != (v < 0) {
                    quad.rotate_left(1);
                }
                if side < 0 {
                    quad.swap(1, 3);
                }
                let [a, b, c, d] = quad;
                match is_divided {
                    true => writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("written"),
                    false => writeln!(text, "f {a} {b} {c} {d}").expect("written"),
                }
            }
        }
    }
    text
}

/// A sheet in the plane z = 0, symmetric to the bit along x and y, held at both ends.
fn symmetric_sheet(random: &mut Random) -> (String, Vec<u32>) {
    let stretch = 0.3 * random.signed();
    let (mut text, mut held) = (String::new(), Vec::new());
    let n = 2 * CELLS + 1;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i - CELLS, j - CELLS))) {
        let place = |c: i32| {
            let share = f64::from(c.abs()) / f64::from(CELLS);
            f64::from(c.signum()) * (HALF * share * (1.0 + stretch * (1.0 - share)))
        };
        if j.abs() == CELLS {
            held.push((i + CELLS) as u32 * n as u32 + (j + CELLS) as u32);
        }
        writeln!(text, "v {:?} {:?} 0.0", place(i), place(j)).expect("written");
    }
    for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
        let corner = |di: i32, dj: i32| (i + di) * n + (j + dj) + 1;
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
        match (i < CELLS) == (j < CELLS) {
            true => writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("written"),
            false => writeln!(text, "f {b} {c} {d}\nf {b} {d} {a}").expect("written"),
        }
    }
    (text, held)
}

/// A generated model, opened as an editor opens it.
struct Edited {
    session: Session,
    draft: Draft,
    _bench: Bench,
}

impl Edited {
    fn open(random: &mut Random, is_sheet: bool) -> Self {
        let bench = Bench::new();
        let (text, material, dt) = if is_sheet {
            let (text, held) = symmetric_sheet(random);
            (text, DraftMaterial::Sheet { plugin: "cloth".into(), fabric: "denim".into(), held }, 4e-3)
        } else {
            let is_divided = random.below(2) == 0;
            let preset = SOLIDS[random.below(SOLIDS.len() as u64) as usize];
            let plugin = if preset.flow.is_some() { "neo-hookean" } else { "mass-spring" };
            let level = 4 + random.below(2) as u32;
            (symmetric_solid(random, is_divided), DraftMaterial::Solid { plugin: plugin.into(), preset, level }, 1e-3)
        };
        bench.write("model.obj", text);
        let draft = Draft {
            mesh: bench.path("model.obj"),
            scale: 1.0,
            size: 2.0 * HALF,
            subdivide: false,
            weld: None,
            material,
            dt,
        };
        let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
        session.keep_history();
        Self { session, draft, _bench: bench }
    }

    fn mirror(&mut self, axes: Axes) {
        assert!(self.session.apply(SessionCommand::SetSymmetry { axes, centre: Vec3::zeros() }));
    }

    /// Holds a button of the hand over a place of the surface, goes into it, along it and away. Calls `each` after every step. Returns the shape right before
    /// the button is pressed.
    fn stroke(&mut self, random: &mut Random, kind: &dyn EditKind, mut each: impl FnMut(&mut Session)) -> Vec<Vec3> {
        self.session.update_surface();
        let body = &self.session.bodies[0];
        let triangles = &body.model.surface.triangles;
        let corners = triangles[random.below(triangles.len() as u64) as usize].map(|v| body.skin.x[v as usize]);
        let at = corners.iter().sum::<Vec3>() / 3.0;
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        let radius = self.draft.radius();
        let along = radius * random.vector();
        let way = [
            at + 1.5 * radius * normal,
            at + 0.95 * radius * normal,
            at + 0.6 * radius * normal,
            at + 0.6 * radius * normal + 0.5 * along,
            at + 3.0 * radius * normal,
        ];
        let button = 1 << stroke_button(kind, Release::Keep, PaintStroke::default());
        let steps = (0.05 / self.session.dt()).round() as usize;
        let mut before = Vec::new();
        for (leg, ends) in way.windows(2).enumerate() {
            if leg == 1 {
                before = self.surface();
            }
            for step in 1..=steps {
                let position = ends[0].lerp(&ends[1], step as f64 / steps as f64);
                let buttons = if leg == 0 || leg == 3 { 0 } else { button };
                self.session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
                self.session.step();
                each(&mut self.session);
            }
        }
        self.session.place_hand(0, None);
        // The hand is let go after 50 ms, and the model comes to rest.
        (0..2 * steps).for_each(|_| self.session.step());
        before
    }

    fn surface(&mut self) -> Vec<Vec3> {
        self.session.update_surface();
        self.session.bodies[0].skin.x.clone()
    }
}

/// The bits of a place. Zero has two signs.
fn key(place: &Vec3) -> [u64; 3] {
    [0, 1, 2].map(|i| (place[i] + 0.0).to_bits())
}

/// Vertices whose mirror image along an axis is no vertex.
fn unpaired(surface: &[Vec3], axis: usize) -> usize {
    let all: HashSet<_> = surface.iter().map(key).collect();
    let image = std::array::from_fn(|i| i == axis);
    surface.iter().filter(|place| !all.contains(&key(&mirrored(**place, image)))).count()
}

/// Largest distance between a vertex and the mirror image of its partner along an axis, m.
fn asymmetry(rest: &[Vec3], surface: &[Vec3], axis: usize) -> f64 {
    let image = std::array::from_fn(|i| i == axis);
    let index: HashMap<_, _> = rest.iter().enumerate().map(|(v, place)| (key(place), v)).collect();
    let partner = |v: usize| index[&key(&mirrored(rest[v], image))];
    (0..rest.len()).map(|v| (surface[v] - mirrored(surface[partner(v)], image)).norm()).fold(0.0, f64::max)
}

/// The kinds that leave the connectivity as it is: a cut has no vertices that could be paired.
fn kinds() -> Vec<&'static dyn EditKind> {
    KINDS.iter().copied().filter(|kind| !kind.changes_topology()).collect()
}

fn axes_of(bits: u64) -> Axes {
    std::array::from_fn(|axis| bits >> axis & 1 == 1)
}

/// A symmetry that is asked for during a stroke is that of the next: the stroke ends on both sides as it began.
#[test]
fn what_is_asked_for_during_a_stroke_is_for_the_next() {
    for seed in 0..6 {
        let kinds = kinds();
        let kind = kinds[seed as usize * kinds.len() / 6];
        let shapes = [false, true].map(|is_during| {
            let random = &mut Random(0x5377_0000 + seed);
            let mut edited = Edited::open(random, false);
            edited.mirror([true, false, false]);
            let mut was_asked = false;
            let start = edited.surface();
            edited.stroke(random, kind, |session| {
                if is_during && !was_asked && session.edits_under_way() > 0 {
                    was_asked = true;
                    let none = SessionCommand::SetSymmetry { axes: [false; 3], centre: Vec3::zeros() };
                    assert!(session.apply(none));
                }
            });
            assert!(was_asked == is_during, "{}, seed {seed}: the stroke was not under way", kind.name());
            let first = edited.surface();
            if !is_during {
                edited.mirror([false; 3]);
            }
            edited.stroke(random, kind, |_| {});
            [start, first, edited.surface()]
        });
        let apart = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let moved = apart(&shapes[0][1], &shapes[0][0]);
        for (now, then) in shapes[1].iter().zip(&shapes[0]) {
            // What is left of the motion after the stroke is made alike on both sides for longer in one of them. A stroke that lost a side would be off by what it moves.
            let off = apart(now, then);
            println!("{}, seed {seed}: {off} m off of {moved} m", kind.name());
            assert!(off < 0.01 * moved, "{}, seed {seed}: {off} m off of {moved} m", kind.name());
        }
    }
}

#[test]
fn strokes_of_every_tool_keep_a_symmetric_model_symmetric_to_the_bit() {
    let mut random = Random(34);
    for (at, kind) in kinds().into_iter().enumerate() {
        for is_sheet in [false, true] {
            let mut edited = Edited::open(&mut random, is_sheet);
            // A sheet in the plane z = 0 has its own two sides.
            let axes = axes_of(1 + random.below(if is_sheet { 3 } else { 7 }));
            edited.mirror(axes);
            let what = format!("{}, sheet: {is_sheet}, {axes:?}", kind.name());
            let first = edited.surface();
            let mut shapes = Vec::new();
            let mut last = first.clone();
            // The tool, then another one on what it has left.
            for kind in [kind, kinds()[(7 * at + 3) % kinds().len()]] {
                let before = edited.session.history().done;
                let pressed = edited.stroke(&mut random, kind, |_| {});
                assert_eq!(edited.session.events.count(EventKind::Quarantine), 0, "{what}");
                let surface = edited.surface();
                for axis in (0..3).filter(|axis| axes[*axis]) {
                    let off = asymmetry(&first, &surface, axis);
                    let count = unpaired(&surface, axis);
                    assert_eq!(count, 0, "{what}: {} along axis {axis}, off by {off:.1e} m", kind.name());
                }
                let after = edited.session.history().done;
                assert!(after <= before + 1, "{what}: a mirrored stroke is one stroke");
                if after > before {
                    shapes.push(pressed);
                }
                last = surface;
            }
            let moved = first.iter().zip(&last).filter(|(a, b)| a != b).count();
            let is_shape = !kind.changes_body();
            assert!(!is_shape || moved > 0, "{what}: nothing has moved");
            for shape in shapes.iter().rev() {
                assert!(edited.session.apply(SessionCommand::Undo), "{what}");
                assert!(edited.surface() == *shape, "{what}: one undo takes all images back, to the bit");
            }
        }
    }
}

#[test]
fn a_stroke_on_one_side_stays_there_when_symmetry_is_switched_on() {
    let mut random = Random(35);
    for name in ["touch", "grow", "smooth", "inflate"] {
        let kind = KINDS.iter().copied().find(|kind| kind.name() == name).expect("a kind");
        let mut edited = Edited::open(&mut random, false);
        edited.stroke(&mut random, kind, |_| {});
        // At rest: what moves by itself is not the symmetry's doing.
        (0..500).for_each(|_| edited.session.step());
        let before = edited.surface();
        assert!((0..3).any(|axis| unpaired(&before, axis) > 0), "{name}: a stroke on one side");
        for bits in [7, 0, 5] {
            edited.mirror(axes_of(bits));
            edited.session.step();
            let after = edited.surface();
            let most = before.iter().zip(&after).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            // Half of what counts as an error of the solver, once for each axis: 1e-4 of the model.
            assert!(most <= 1.5e-4 * 2.0 * HALF, "{name}: the shape has moved by {most} m");
        }
    }
}

/// What one side alone has is not shared with the other by strokes on both, by a layer that is hidden and shown, nor by an undo: the shape is what it is
/// without symmetry.
#[test]
fn strokes_on_one_side_and_on_both_keep_apart() {
    let kind = |name: &str| KINDS.iter().copied().find(|kind| kind.name() == name).expect("a kind");
    for name in ["touch", "grow", "smooth"] {
        let run = |axes: Axes| {
            let mut random = Random(38);
            let mut edited = Edited::open(&mut random, false);
            let mut shapes = Vec::new();
            assert!(edited.session.apply(SessionCommand::AddLayer { name: "one side".into() }));
            edited.stroke(&mut random, kind(name), |_| {});
            edited.mirror(axes);
            (0..300).for_each(|_| edited.session.step());
            shapes.push(edited.surface());
            for strength in [0.0, 1.0] {
                assert!(edited.session.apply(SessionCommand::SetLayerStrength { layer: 0, strength }));
                (0..300).for_each(|_| edited.session.step());
                shapes.push(edited.surface());
            }
            edited.stroke(&mut random, kind("touch"), |_| {});
            assert!(edited.session.apply(SessionCommand::Undo));
            shapes.push(edited.surface());
            shapes
        };
        let [without, with] = [run([false; 3]), run([true, true, false])];
        for (at, (without, with)) in without.iter().zip(&with).enumerate() {
            let most = without.iter().zip(with).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            // Half of what counts as an error of the solver, once for each axis: 1e-4 of the model.
            assert!(most <= 1e-4 * 2.0 * HALF, "{name}, shape {at}: symmetry has moved it by {most} m");
        }
    }
}

#[test]
fn only_the_axes_that_are_on_have_hands_and_their_hands_make_equal_strokes() {
    let mut random = Random(36);
    let touch = KINDS[0];
    for bits in 0..8_u64 {
        let mut edited = Edited::open(&mut random, false);
        edited.mirror(axes_of(bits));
        let mut most = 0;
        edited.stroke(&mut random, touch, |session| {
            most = most.max(session.tools.iter().filter(|slot| slot.hand.present).count());
        });
        assert_eq!(most, 1 << bits.count_ones(), "axes {bits:03b}");
    }
}

/// A window draws when it can; what it looks at does not change what is simulated.
#[test]
fn looking_at_a_mirrored_stroke_does_not_change_it() {
    for kind in ["touch", "grow", "smooth", "grab"] {
        let kind = KINDS.iter().copied().find(|other| other.name() == kind).expect("a kind");
        let run = |period: usize| {
            let mut random = Random(37);
            let mut edited = Edited::open(&mut random, false);
            edited.mirror([true, false, true]);
            let (mut digests, mut steps) = (Vec::new(), 0);
            for _ in 0..2 {
                edited.stroke(&mut random, kind, |session| {
                    steps += 1;
                    if steps % period == 0 {
                        session.update_surface();
                    }
                    digests.push(state_digest(session));
                });
            }
            (digests, edited.surface())
        };
        let seldom = run(1000);
        for period in [1, 7] {
            let often = run(period);
            assert!(often.0 == seldom.0, "{}: the state, looked at every {period} steps", kind.name());
            assert!(often.1 == seldom.1, "{}: the shape, looked at every {period} steps", kind.name());
        }
    }
}

/// A shape that was seen between two strokes.
struct Seen {
    /// The strokes so far.
    strokes: String,
    /// m
    shape: Vec<Vec3>,
    /// Whether it no longer moved.
    is_at_rest: bool,
}

/// Three strokes of random tools, mirrored in planes that are on all the time or during strokes alone, each followed by up to three seconds of rest. A window looks
/// every `period` steps. Returns what is seen before the strokes and after each one that can be taken back.
fn seen_strokes(seed: u64, period: usize) -> (Edited, Vec<Seen>) {
    let mut random = Random(seed);
    let is_sheet = seed % 4 == 3;
    let mut edited = Edited::open(&mut random, is_sheet);
    let always = Some(axes_of(random.below(4))).filter(|_| random.below(2) == 0);
    if let Some(axes) = always {
        edited.mirror(axes);
    }
    let mut steps = 0;
    let mut look = |session: &mut Session| {
        steps += 1;
        if steps % period == 0 {
            session.update_surface();
        }
    };
    let mut seen = vec![Seen { strokes: String::new(), shape: edited.surface(), is_at_rest: true }];
    let mut strokes = String::new();
    for _ in 0..3 {
        let kind = kinds()[random.below(kinds().len() as u64) as usize];
        let axes = axes_of(random.below(if is_sheet { 4 } else { 8 }));
        if always.is_none() {
            edited.mirror(axes);
        }
        let before = edited.session.history().done;
        edited.stroke(&mut random, kind, &mut look);
        if always.is_none() {
            edited.mirror([false; 3]);
        }
        let mut is_at_rest = false;
        let mut shape = edited.surface();
        for _ in 0..5 {
            for _ in 0..600 {
                edited.session.step();
                look(&mut edited.session);
            }
            let now = edited.surface();
            is_at_rest = now == shape;
            shape = now;
            if is_at_rest {
                break;
            }
        }
        write!(strokes, "{} in {:?}, ", kind.name(), always.unwrap_or(axes)).expect("written");
        if edited.session.history().done == before {
            // Nothing to take back, but a body that was not at rest may have moved.
            seen.pop();
        }
        seen.push(Seen { strokes: strokes.clone(), shape, is_at_rest });
    }
    (edited, seen)
}

/// Whatever is looked at and whenever symmetry is on, strokes give the same shapes, and undo and redo give those that were seen at rest, to the bit.
#[test]
fn undo_and_redo_give_the_shapes_that_were_seen() {
    let mut compared = 0;
    for seed in asked_cases("STROKES").unwrap_or(0..3) {
        let (mut edited, seen) = seen_strokes(seed, 7);
        let (_, unseen) = seen_strokes(seed, usize::MAX);
        for (Seen { strokes, shape, .. }, other) in seen.iter().zip(&unseen) {
            let off = shape.iter().zip(&other.shape).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(shape == &other.shape, "case {seed}: looking has moved the shape by {off} m: {strokes}");
        }
        let numbers = (0..seen.len() - 1).rev().map(|at| (SessionCommand::Undo, at));
        let again = (1..seen.len()).map(|at| (SessionCommand::Redo, at));
        for (command, at) in numbers.chain(again) {
            assert!(edited.session.apply(command.clone()), "case {seed}: {command:?}");
            let Seen { strokes, shape, is_at_rest } = &seen[at];
            // A shape that moves on is not there when the next stroke begins, which is what undo gives.
            for wait in [0, 300].into_iter().filter(|_| *is_at_rest) {
                (0..wait).for_each(|_| edited.session.step());
                let now = edited.surface();
                let off = now.iter().zip(shape).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                // A body that slept goes on from where it fell asleep, which is rest up to rounding.
                let is_seen = &now == shape || wait > 0 && off < 1e-12;
                assert!(is_seen, "case {seed}, {command:?}, after {wait} steps: {off} m off: {strokes}");
                compared += 1;
            }
        }
    }
    assert!(compared > 8, "{compared} shapes are at rest");
}
