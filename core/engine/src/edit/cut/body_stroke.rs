//! What a blade sweeps in one body.

use super::middle::Middle;
use super::rest_blade::mean_displacement;
use super::slit::Slit;
use crate::body::Body;
use pliant_cut::{Blade, CutMesh, Refused, Stroke};
use pliant_mesh::Surface;
use pliant_solver::Vec3;

/// The area that a blade sweeps in the rest shape of a body, from where the hand was before the edit to where it is. It has no gaps: it goes on
/// where the blade is in no body.
pub struct BodyStroke {
    /// The place on blades by which their motion is told.
    pub middle: Middle,
    /// Position up to which the body is cut.
    pub stroke: Stroke,
    /// The blade before the last advance that was made; `None` before the first.
    pub previous: Option<Blade>,
    /// The blade at the last attempt to advance.
    pub tried: Blade,
    /// The blade as it was mapped to the rest shape last.
    pub mapped: Blade,
    /// Mean displacement of a body that is simulated as a whole when the stroke began, m.
    pub drift: Vec3,
    /// Length of the way on which it has cut the body, m; 0 if it has not.
    pub way: f64,
    /// The first place where the mesh could be cut with a bridge only.
    pub bridge: Option<Bridge>,
    /// What it has cut right through since it began; `None` before the first cut, and where an end of the blade was inside of the body.
    pub section: Option<Section>,
    /// The slit of an earlier cut that the blade is in.
    pub(super) slit: Option<Slit>,
    /// How far it went in such slits; `None` if it was in none.
    pub along: Option<AlongSlit>,
    /// Whether a solid had cuts when the stroke began. If not, a slit that the blade meets was made by this stroke.
    pub was_cut: bool,
    /// The blade at the beginning.
    start: Blade,
    /// Number of triangles of the mesh at the beginning: walls from there on were made by this stroke.
    first_triangle: u32,
}

/// The way of a blade in the slits of earlier cuts, where it cuts nothing.
#[derive(Clone, Copy)]
pub struct AlongSlit {
    /// Mean position of the walls beside the blade where it came into the first one, in the rest shape, m.
    pub place: Vec3,
    /// Length of the way, m.
    pub way: f64,
    /// Whether it has come out of the body there.
    pub has_left: bool,
}

/// A cut through a whole cross-section of a body, as far as the blade tells: it was longer than the body is thick, all along.
#[derive(Clone, Copy)]
pub struct Section {
    /// Euler characteristic of the surface before.
    pub euler: i64,
    /// Middle of the blade where the mesh refused it first, or else where it cut first, in the rest shape, m.
    pub place: Vec3,
    /// Whether the mesh has refused it anywhere.
    pub was_refused: bool,
    /// Whether both ends of the blade were outside wherever it cut.
    pub spans: bool,
}

/// Euler characteristic of a closed surface. A cut right through adds two for each cross-section, whether the body falls apart or was a ring; one that
/// leaves a neck adds nothing, and one whose halves share a vertex adds one.
pub fn euler_characteristic(surface: &Surface) -> i64 {
    let mut is_used = vec![false; surface.points.len()];
    surface.triangles.iter().flatten().for_each(|v| is_used[*v as usize] = true);
    let vertices = is_used.iter().filter(|used| **used).count() as i64;
    // Three edges to a triangle, each shared by two.
    vertices - surface.triangles.len() as i64 / 2
}

/// Where a stroke may have left a bridge across its cut.
#[derive(Clone, Copy)]
pub struct Bridge {
    /// Middle of the blade there, in the rest shape, m.
    pub place: Vec3,
    /// Upper bound of the bridge's width, m.
    pub width: f64,
}

impl BodyStroke {
    /// A stroke that begins at `blade`.
    ///
    /// # Errors
    /// Returns why the mesh refuses the blade.
    pub fn begin(blade: Blade, body: &Body) -> Result<Self, Refused> {
        let lattice = body.discretization.lattice();
        let was_cut = lattice.is_some_and(|lattice| lattice.has_cuts());
        let whole = lattice.filter(|lattice| lattice.is_whole());
        let drift = whole.map_or_else(Vec3::zeros, |lattice| mean_displacement(lattice, body));
        let stroke = Stroke::begin(blade)?;
        Ok(Self {
            middle: Middle::of(body),
            stroke,
            previous: None,
            tried: blade,
            mapped: blade,
            drift,
            way: 0.0,
            bridge: None,
            section: None,
            slit: None,
            along: None,
            was_cut,
            start: blade,
            first_triangle: body.cut.as_ref().map_or(0, |mesh| mesh.surface().triangles.len() as u32),
        })
    }

    /// Whether a part of the surface has walls of both sides of the stroke, so that it holds together somewhere. So does a ring that was cut through once.
    pub fn has_joined_walls(&self, mesh: &CutMesh) -> bool {
        let blade = self.stroke.blade();
        let normal = (blade.heel - blade.tip).cross(&self.middle.way(&self.start, &blade));
        let (surface, parts) = (mesh.surface(), mesh.parts());
        let mut has_walls = vec![[false; 2]; parts.all.len()];
        for triangle in (self.first_triangle..surface.triangles.len() as u32).filter(|triangle| mesh.is_cap(*triangle))
        {
            let [a, b, c] = surface.triangles[triangle as usize].map(|v| surface.points[v as usize]);
            let side = usize::from((b - a).cross(&(c - a)).dot(&normal) > 0.0);
            has_walls[parts.of[triangle as usize] as usize][side] = true;
        }
        has_walls.contains(&[true; 2])
    }

    /// Notes what a solid is like before the first cut of the stroke.
    pub fn begin_section(&mut self, body: &Body) {
        let Some(mesh) = body.cut.as_ref().filter(|_| body.discretization.lattice().is_some()) else { return };
        let (blade, euler) = (self.stroke.blade(), || euler_characteristic(mesh.surface()));
        let begun = || Section { euler: euler(), place: self.middle.on(&blade), was_refused: false, spans: true };
        self.section.get_or_insert_with(begun);
    }

    /// Notes where the mesh has refused the stroke first.
    pub fn note_refusal(&mut self, blade: &Blade) {
        let middle = self.middle;
        if let Some(section) = self.section.as_mut().filter(|section| !section.was_refused) {
            (section.place, section.was_refused) = (middle.on(blade), true);
        }
    }

    /// Notes whether the blade up to which a solid was cut has an end inside.
    pub fn extend_section(&mut self, body: &Body, blade: &Blade) {
        if let (Some(section), Some(mesh)) = (&mut self.section, &body.cut) {
            section.spans &= !mesh.encloses(blade.tip) && !mesh.encloses(blade.heel);
        }
    }

    /// Whether a blade has moved by a stride (m) since the last attempt, or at all if it is the `last`.
    pub fn is_due(&self, blade: &Blade, stride: f64, last: bool) -> bool {
        travel(&self.tried, blade) >= stride || (last && travel(&self.stroke.blade(), blade) > 0.0)
    }
}

/// Larger one of the distances that the two ends of a blade have moved, m.
pub fn travel(from: &Blade, to: &Blade) -> f64 {
    let moved = |a: Vec3, b: Vec3| (b - a).norm();
    moved(from.tip, to.tip).max(moved(from.heel, to.heel))
}
