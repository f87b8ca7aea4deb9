//! Directions of the fibres of a solid as functions of the rest position.

use super::fields::FieldSurface;
use super::fixing::Place;
use super::skin::nearest_triangle;
use pliant_solver::Vec3;

/// Number of nearest points of a cloud over which a direction is averaged.
const NEIGHBOURS: usize = 4;

/// Directions of the fibres of a body.
#[derive(Clone, Debug)]
pub struct Fibres {
    /// Entries in the order of the scene; of those whose part contains a point, the last one applies.
    entries: Vec<FibreEntry>,
    /// Model with a search tree, to find the triangle or tetrahedron at a point.
    surface: FieldSurface,
}

/// Directions in a part of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct FibreEntry {
    /// Part of the body that they fill.
    pub part: FibrePart,
    /// Field of lines whose tangents they are.
    pub lines: FibreLines,
}

/// A part of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum FibrePart {
    /// The whole body.
    Whole,
    /// Points within a box or ball.
    Place(Place),
    /// Points nearest to some triangles of the surface: `true` for each of these triangles (m).
    Triangles(Vec<bool>),
    /// Some tetrahedra of the model: `true` for each of these (t).
    Tetrahedra(Vec<bool>),
}

/// A field of lines.
#[derive(Clone, Debug, PartialEq)]
pub enum FibreLines {
    /// Parallel lines along a unit vector.
    Parallel(Vec3),
    /// Circles or helices around an axis.
    Around {
        /// Unit vector along the axis.
        axis: Vec3,
        /// A point of the axis, m.
        point: Vec3,
        /// Cosine and sine of the angle from the circle towards the axis; positive: right-handed helices.
        angle: [f64; 2],
    },
    /// Lines along a curve through points.
    Along(Curve),
    /// Directions at points, and weighted means between the points.
    Cloud(DirectionCloud),
}

impl Fibres {
    /// Directions of `entries`; of those whose part contains a point, the last one applies.
    pub fn new(entries: Vec<FibreEntry>, surface: FieldSurface) -> Self {
        Self { entries, surface }
    }

    /// The same with the lines of the first entry in the whole body: no part is without fibres.
    pub fn everywhere(&self) -> Self {
        let whole = |entry: &FibreEntry| FibreEntry { part: FibrePart::Whole, lines: entry.lines.clone() };
        Self { entries: self.entries.first().map(whole).into_iter().collect(), surface: self.surface.clone() }
    }

    /// The unit vector along the fibres at a point of the rest shape (m); zero where there are none.
    pub fn at(&self, point: Vec3) -> Vec3 {
        let FieldSurface { model, tree } = &self.surface;
        let on_surface = |entry: &FibreEntry| matches!(entry.part, FibrePart::Triangles(_));
        let nearest = self.entries.iter().any(on_surface).then(|| {
            let size = model.surface.bounds().longest_edge();
            nearest_triangle(tree, model, &model.surface.points, point, 0.02 * size, 1e3 * size)
        });
        let nearest = nearest.flatten().map(|nearest| nearest.triangle as usize);
        let applies = |entry: &&FibreEntry| match &entry.part {
            FibrePart::Whole => true,
            FibrePart::Place(place) => place.contains(u32::MAX, point),
            FibrePart::Tetrahedra(is_inside) => self.surface.is_in(is_inside, point),
            FibrePart::Triangles(all) => nearest.is_some_and(|triangle| all[triangle]),
        };
        self.entries.iter().rev().find(applies).map_or(Vec3::zeros(), |entry| entry.lines.at(point))
    }
}

impl FibreLines {
    /// The unit vector at a point (m); zero where it is not defined, as on the axis of circles.
    fn at(&self, point: Vec3) -> Vec3 {
        match self {
            Self::Parallel(direction) => *direction,
            Self::Around { axis, point: origin, angle: [cos, sin] } => {
                let around = axis.cross(&(point - origin));
                let circle = around.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
                (*cos * circle + *sin * axis).try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
            }
            Self::Along(curve) => curve.at(point),
            Self::Cloud(cloud) => cloud.at(point),
        }
    }
}

/// A curve through points, with tangents that are continuous.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Two or more points, m; no two neighbours coincide.
    points: Vec<Vec3>,
    /// Unit tangent at each point: the mean direction of the segments beside it.
    tangents: Vec<Vec3>,
}

impl Curve {
    /// The curve through two or more points (m).
    ///
    /// # Errors
    /// The index of a point that is where the one before is, or where the curve turns back on itself.
    pub fn new(points: Vec<Vec3>) -> Result<Self, usize> {
        let segment = |i: usize| (points[i + 1] - points[i]).try_normalize(f64::MIN_POSITIVE).ok_or(i + 1);
        let segments = (0..points.len() - 1).map(segment).collect::<Result<Vec<Vec3>, usize>>()?;
        let tangent = |i: usize| {
            let beside = &segments[i.saturating_sub(1)..(i + 1).min(segments.len())];
            beside.iter().sum::<Vec3>().try_normalize(1e-6).ok_or(i)
        };
        let tangents = (0..points.len()).map(tangent).collect::<Result<Vec<Vec3>, usize>>()?;
        Ok(Self { points, tangents })
    }

    /// The unit tangent at the place of the curve that is nearest to `point` (m).
    fn at(&self, point: Vec3) -> Vec3 {
        let mut nearest = (f64::INFINITY, Vec3::zeros());
        for (ends, tangents) in self.points.windows(2).zip(self.tangents.windows(2)) {
            let way = ends[1] - ends[0];
            let s = ((point - ends[0]).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            let distance = (ends[0] + s * way - point).norm_squared();
            if distance < nearest.0 {
                nearest = (distance, (1.0 - s) * tangents[0] + s * tangents[1]);
            }
        }
        nearest.1.try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
    }
}

/// Directions at points.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionCloud {
    /// Points (m) with their unit vectors, by x.
    samples: Vec<(Vec3, Vec3)>,
}

impl DirectionCloud {
    /// A cloud of one or more points (m) with their unit vectors.
    pub fn new(mut samples: Vec<(Vec3, Vec3)>) -> Self {
        samples.sort_by(|(a, _), (b, _)| a.x.total_cmp(&b.x));
        Self { samples }
    }

    /// The unit vector at a point (m): the mean of those at the nearest points, weighted by the inverse square of their distances, each turned to
    /// the side of the nearest one, for a line has no sign.
    fn at(&self, point: Vec3) -> Vec3 {
        let near = self.nearest(point);
        let (least, first) = near[0];
        if least == 0.0 {
            return self.samples[first].1;
        }
        let side = self.samples[first].1;
        let sum: Vec3 = near
            .iter()
            .map(|&(distance, i)| {
                let direction = self.samples[i].1;
                (least / distance).copysign(direction.dot(&side)) * direction
            })
            .sum();
        sum.try_normalize(f64::MIN_POSITIVE).unwrap_or(side)
    }

    /// Squared distances (m^2) and indices of the nearest points, the nearest first. Goes from the point's own x to both sides until x alone is farther.
    fn nearest(&self, point: Vec3) -> Vec<(f64, usize)> {
        let mut near: Vec<(f64, usize)> = Vec::with_capacity(NEIGHBOURS + 1);
        let middle = self.samples.partition_point(|(at, _)| at.x < point.x);
        let (mut below, mut above) = (middle, middle);
        loop {
            let gap = |i: usize| (self.samples[i].0.x - point.x).powi(2);
            let farthest = if near.len() < NEIGHBOURS { f64::INFINITY } else { near[NEIGHBOURS - 1].0 };
            let down = below.checked_sub(1).filter(|i| gap(*i) < farthest);
            let up = Some(above).filter(|i| *i < self.samples.len() && gap(*i) < farthest);
            let next = match (down, up) {
                (None, None) => return near,
                (Some(down), Some(up)) if gap(down) <= gap(up) => down,
                (Some(down), None) => down,
                (_, Some(up)) => up,
            };
            if next < middle {
                below = next
            } else {
                above = next + 1
            }
            let distance = (self.samples[next].0 - point).norm_squared();
            let place = near.partition_point(|known| *known < (distance, next));
            near.insert(place, (distance, next));
            near.truncate(NEIGHBOURS);
        }
    }
}

#[cfg(test)]
mod tests;
