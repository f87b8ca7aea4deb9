//! A tip on a sheet as springs: where vertices lie too far apart to be constrained, and for comparison.
//!
//! Between vertices a tip meets the points of triangles, edges and vertices whose distance from it is a local
//! minimum. Each pushes with a spring whose force is carried on from step to step, so that the remaining depth goes to
//! zero (the multiplier method of Hestenes 1969 and Powell 1969, one iteration a step). As a penalty, springs at the vertices
//! inside the tip push for what they are deep, and no more. Friction is a spring along the surface that gives way where
//! Coulomb's law says so.

use super::fingertip::Tip;
use super::reach::Reach;
use super::sums::Sums;
use pliant_mesh::geometry::{Closest, closest_point};
use pliant_solver::{Block, NodeSprings, Nodes, Vec3, matrix3};

/// Where a soft tip meets a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meets {
    /// On triangles, edges and vertices, until it is not inside any more.
    Triangles,
    /// At vertices, with a force that stands for a depth.
    Vertices,
}

/// A tip of one tool on one sheet.
pub struct SoftTip {
    meets: Meets,
    /// Whether forces last: between two tips they would grow against each other.
    pub learns: bool,
    near: Reach,
    found: Vec<Found>,
    stays: Vec<bool>,
    spots: Vec<Spot>,
    before: Vec<Spot>,
    sums: Sums,
}

/// How a soft tip presses in a step.
#[derive(Clone, Copy, Debug)]
pub struct SoftPress {
    /// Stiffness of its springs, N/m.
    pub stiffness: f64,
    /// How far nodes of the sheet may have moved since the last step, m.
    pub moved: f64,
    /// Length of the step, s.
    pub dt: f64,
}

/// One place of a tip on its way through a step.
#[derive(Clone, Copy)]
struct Look {
    /// Centre, m.
    centre: Vec3,
    /// Stiffness, N/m.
    stiffness: f64,
    /// Motion of the tip in the step, m.
    drive: Vec3,
    /// Length of the step, s.
    dt: f64,
}

/// A point of a sheet that may be pressed on.
#[derive(Clone, Copy, Debug)]
struct Found {
    corners: [u32; 3],
    bary: Vec3,
    point: Vec3,
    distance: f64,
}

/// A point that is pressed on: the force on it is `force - stiffness (x - point) - damping v`.
#[derive(Clone, Copy, Debug)]
struct Spot {
    corners: [u32; 3],
    bary: Vec3,
    point: Vec3,
    normal: Vec3,
    force: Vec3,
    stiffness: Block,
    damping: Block,
    /// What the spring of a depth has come to, N.
    lasting: f64,
    sticks: bool,
}

/// Of a tip's length scale: how far a point may have moved along the sheet and still be the same contact.
const SAME: f64 = 0.5;
/// Of what a depth adds to the force in a step, the most that lasts.
const LASTS: f64 = 0.25;
/// Of a tip's length scale: how far off the sheet may be before what lasts of a force is forgotten.
const GAP: f64 = 0.1;
/// Largest radius at which turning a tip counts as motion, m: a shape without end has no speed there.
const FAR: f64 = 1.0;
/// Of a distance: less than this apart, two are one.
const TIE: f64 = 1e-9;

impl SoftTip {
    /// A tip in contact with nothing.
    pub fn new(meets: Meets) -> Self {
        Self {
            meets,
            learns: true,
            near: Reach::default(),
            found: Vec::new(),
            stays: Vec::new(),
            spots: Vec::new(),
            before: Vec::new(),
            sums: Sums::default(),
        }
    }

    /// The nodes of the body have changed.
    pub fn forget(&mut self) {
        self.near.forget();
        self.leave();
    }

    /// Forgets all contacts.
    pub fn leave(&mut self) {
        self.spots.clear();
    }

    /// Points it pressed on in the last step.
    pub fn held(&self) -> usize {
        self.spots.len()
    }

    /// What it presses on: the direction from its centre, N, and how fast the sheet slides past it, m/s, once nodes have moved.
    pub fn pressed<'a>(&'a self, tip: &'a Tip, nodes: &'a Nodes) -> impl Iterator<Item = (Vec3, f64, Vec3)> + 'a {
        self.spots.iter().map(|spot| {
            let v = carried(&nodes.v, spot.corners, spot.bary);
            let slip = v - tip.velocity_at(spot.point);
            let size = (spot.felt(&nodes.x) - matrix3(&spot.damping) * v).dot(&spot.normal);
            (spot.normal, size.max(0.0), slip - slip.dot(&spot.normal) * spot.normal)
        })
    }

    /// What friction takes in a step of `dt` (s) where the sheet slides, once nodes have moved, J.
    pub fn friction_work(&self, tip: &Tip, nodes: &Nodes, dt: f64) -> f64 {
        let sliding = self.spots.iter().filter(|spot| !spot.sticks);
        let lost = sliding.map(|spot| {
            let slip = carried(&nodes.v, spot.corners, spot.bary) - tip.velocity_at(spot.point);
            let along = spot.force - spot.force.dot(&spot.normal) * spot.normal;
            -along.dot(&slip) * dt
        });
        lost.sum()
    }

    /// Finds what `tip` presses on among the `count` triangles of a sheet, whose nodes `triangles` returns, and adds the springs to `out`.
    pub fn press(
        &mut self,
        tip: &Tip,
        triangles: impl Fn(u32) -> [u32; 3],
        count: u32,
        nodes: &Nodes,
        press: SoftPress,
        out: &mut NodeSprings,
    ) {
        let SoftPress { stiffness, moved, dt } = press;
        std::mem::swap(&mut self.spots, &mut self.before);
        self.spots.clear();
        let drive = tip.velocity * dt;
        let shape = tip.shape.shape();
        let turned = if shape.is_round() { 0.0 } else { dt * tip.spin.norm() * shape.bounding_radius().min(FAR) };
        let travel = drive.norm();
        if let Some(reach) = self.near.renew(tip.position, shape, moved, travel) {
            let within = |t: &u32| {
                let at = closest_point(tip.position, triangles(*t).map(|n| nodes.x[n as usize])).point;
                let d = at - tip.position;
                d.norm_squared() <= reach * reach
            };
            self.near.list.extend((0..count).filter(within));
        }
        // A tip that goes far in a step is looked at on its way, so that it cannot jump over the sheet.
        let looks = (2.0 * (travel + turned) / tip.length_scale()).ceil().clamp(1.0, 1000.0);
        for look in 1..=looks as u32 {
            let centre = tip.position + (f64::from(look) / looks - 1.0) * drive;
            let margin = if self.before.is_empty() { 0.0 } else { GAP * tip.length_scale() };
            self.find(tip, centre, margin, &triangles, &nodes.x);
            if !self.found.is_empty() {
                let look = Look { centre, stiffness, drive, dt };
                self.judge(tip, &look, nodes);
                break;
            }
        }
        self.give(nodes, out);
    }

    /// Lists the points within `margin`, m, of a tip at `centre`.
    fn find(&mut self, tip: &Tip, centre: Vec3, margin: f64, triangles: &impl Fn(u32) -> [u32; 3], x: &[Vec3]) {
        self.found.clear();
        let mut add = |corners: [u32; 3], Closest { point, bary }| {
            let distance = tip.shape.distance(point - centre);
            if distance < margin {
                self.found.push(Found { corners, bary, point, distance });
            }
        };
        for corners in self.near.list.iter().map(|t| triangles(*t)) {
            match self.meets {
                Meets::Triangles => {
                    add(corners, tip.shape.closest_on_triangle(centre, corners.map(|n| x[n as usize])));
                }
                Meets::Vertices => corners
                    .into_iter()
                    .for_each(|n| add([n; 3], Closest { point: x[n as usize], bary: Vec3::new(1.0, 0.0, 0.0) })),
            }
        }
        match self.meets {
            Meets::Triangles => self.keep_least(TIE * tip.length_scale()),
            Meets::Vertices => {
                self.found.sort_unstable_by_key(|f| f.corners[0]);
                self.found.dedup_by_key(|f| f.corners[0]);
            }
        }
    }

    /// Keeps of points on shared edges and vertices one, and none where a triangle that shares it comes closer.
    fn keep_least(&mut self, tie: f64) {
        let all = &self.found;
        let is_part = |f: &Found, g: &Found| {
            let mut of = f.corners.iter().zip(&f.bary).filter(|(_, w)| **w > 0.0);
            of.all(|(n, _)| g.corners.contains(n))
        };
        self.stays.clear();
        self.stays.extend((0..all.len()).map(|i| {
            let f = &all[i];
            let beats = |(j, g): (usize, &Found)| {
                let same = (g.distance - f.distance).abs() <= tie;
                j != i && is_part(f, g) && if same { j < i } else { g.distance < f.distance }
            };
            !all.iter().enumerate().any(beats)
        }));
        let mut stays = self.stays.iter();
        self.found.retain(|_| *stays.next().expect("one for each"));
    }

    /// Computes the force on each point found.
    fn judge(&mut self, tip: &Tip, look: &Look, nodes: &Nodes) {
        let Look { centre, stiffness: k, drive, dt } = *look;
        for found in &self.found {
            let mut normal = tip.shape.normal(found.point - centre).unwrap_or_else(Vec3::z);
            let old = self.before.iter().filter_map(|spot| {
                let d = carried(&nodes.x, spot.corners, spot.bary) - found.point;
                let away = d.norm();
                (away <= SAME * tip.length_scale()).then_some((away, spot))
            });
            let old = old.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, spot)| spot);
            if old.is_some_and(|spot| spot.normal.dot(&normal) < 0.0) {
                normal = -normal; // the sheet has come past the centre
            }
            let depth = tip.depth(found.point, normal);
            let speed = tip.velocity_at(found.point);
            let last = old.map_or(Vec3::zeros(), |spot| spot.felt(&nodes.x));
            let slip = speed - carried(&nodes.v, found.corners, found.bary);
            // Critical for the mass at this point. What lasts grows no faster than this damping can follow.
            let mass = found
                .corners
                .iter()
                .zip(&found.bary)
                .map(|(n, w)| w * w / nodes.mass[*n as usize])
                .sum::<f64>()
                .recip();
            let drag = (k * mass).sqrt();
            let lasts = LASTS.min(0.5 * dt * (k / mass).sqrt());
            let lasting =
                if self.meets == Meets::Triangles && self.learns { old.map_or(0.0, |spot| spot.lasting) } else { 0.0 };
            let push = lasting + k * depth + drag * slip.dot(&normal);
            if push <= 0.0 || (old.is_none() && depth <= 0.0) {
                continue;
            }
            let lasting = (lasting + lasts * k * depth).max(0.0);
            let tangent = |v: Vec3| v - v.dot(&normal) * normal;
            let rub = tangent(last);
            let trial = rub + k * dt * tangent(slip);
            let size = trial.norm();
            let stuck = old.is_none_or(|spot| spot.sticks);
            let most = push * if stuck { tip.friction.fixed } else { tip.friction.sliding };
            let sticks = size <= most;
            let along = if sticks { rub + k * tangent(drive) } else { trial * tip.friction.sliding * push / size };
            let across: Block = std::array::from_fn(|e| normal[e / 3] * normal[e % 3]);
            let stiffness =
                if sticks { std::array::from_fn(|e| if e % 4 == 0 { k } else { 0.0 }) } else { across.map(|c| k * c) };
            let damping = across.map(|c| drag * c);
            let Found { corners, bary, point, .. } = *found;
            // The drag is on a sheet that stands still; what moves it away from the tip is in `damping`.
            let held = push + drag * (speed - slip).dot(&normal);
            let force = along + held * normal;
            self.spots.push(Spot { corners, bary, point, normal, force, stiffness, damping, lasting, sticks });
        }
    }

    fn give(&mut self, nodes: &Nodes, out: &mut NodeSprings) {
        self.sums.begin(nodes.len());
        for spot in &self.spots {
            for (node, weight) in spot.corners.into_iter().zip(&spot.bary).filter(|(_, w)| **w > 0.0) {
                self.sums.add(node, *weight, spot.force, &spot.stiffness, &spot.damping);
            }
        }
        self.sums.give(1.0, &nodes.x, out);
    }
}

impl Spot {
    /// Force on the sheet with its nodes at `x`, N.
    fn felt(&self, x: &[Vec3]) -> Vec3 {
        let moved = carried(x, self.corners, self.bary) - self.point;
        self.force - matrix3(&self.stiffness) * moved
    }
}

/// The value at a point of a triangle.
fn carried(of: &[Vec3], corners: [u32; 3], bary: Vec3) -> Vec3 {
    (0..3).map(|i| bary[i] * of[corners[i] as usize]).sum()
}
