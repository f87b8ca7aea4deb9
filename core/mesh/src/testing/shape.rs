//! Polygon meshes to build test models from: made of voxels, smoothed, bent, roughened and taken apart.

use super::Random;
use crate::geometry::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Points and polygons; polygons turn counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    pub points: Vec<Vec3>, // n x 3
    pub faces: Vec<Vec<u32>>,
    /// The part each face belongs to.
    pub part: Vec<u32>,
}

impl Shape {
    /// The boundary of the voxels of `counts` for which `solid` holds, as quads of edge 1 about the origin.
    ///
    /// It is a manifold if no two solid voxels share an edge or a corner without a solid voxel between them.
    pub fn of_voxels(counts: [i32; 3], solid: impl Fn([i32; 3]) -> bool) -> Self {
        let inside = |at: [i32; 3]| (0..3).all(|a| (0..counts[a]).contains(&at[a])) && solid(at);
        let (mut shape, mut index) = (Self::default(), BTreeMap::new());
        let cells =
            (0..counts[2]).flat_map(|k| (0..counts[1]).flat_map(move |j| (0..counts[0]).map(move |i| [i, j, k])));
        for cell in cells.filter(|cell| inside(*cell)) {
            for (axis, up) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                let mut beside = cell;
                beside[axis] += 2 * up - 1;
                if inside(beside) {
                    continue;
                }
                let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut corner = cell;
                    corner[axis] += up;
                    corner[(axis + 1) % 3] += u;
                    corner[(axis + 2) % 3] += v;
                    *index.entry(corner).or_insert_with(|| {
                        shape.points.push(Vec3::from_fn(|a, _| f64::from(corner[a]) - 0.5 * f64::from(counts[a])));
                        shape.points.len() as u32 - 1
                    })
                });
                let mut face = corners.to_vec();
                if up == 0 {
                    face.reverse();
                }
                shape.faces.push(face);
                shape.part.push(0);
            }
        }
        shape
    }

    /// A flat sheet of `columns` x `rows` quads of edge 1 about the origin, seen from +z.
    pub fn sheet(columns: u32, rows: u32) -> Self {
        let place = |i: u32, count: u32| f64::from(i) - 0.5 * f64::from(count);
        let vertices = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
        let points = vertices.map(|(i, j)| Vec3::new(place(i, columns), place(j, rows), 0.0)).collect();
        let vertex = |i: u32, j: u32| i + (columns + 1) * j;
        let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
        let faces: Vec<_> =
            cells.map(|(i, j)| vec![vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]).collect();
        Self { points, part: vec![0; faces.len()], faces }
    }

    /// Every edge with the vertices of `face` around it, once for each face.
    fn edges(face: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
        (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]])
    }

    /// Vertices on edges of one face only.
    fn border(&self) -> BTreeSet<u32> {
        let mut count = BTreeMap::new();
        for [a, b] in self.faces.iter().flat_map(|face| Self::edges(face)) {
            *count.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        }
        count.iter().filter(|(_, count)| **count == 1).flat_map(|(edge, _)| *edge).collect()
    }

    /// Moves each vertex half-way to the mean of its neighbours, `rounds` times. The border stays.
    pub fn smooth(mut self, rounds: u32) -> Self {
        let fixed = self.border();
        for _ in 0..rounds {
            let mut sums = vec![(Vec3::zeros(), 0.0); self.points.len()];
            for [a, b] in self.faces.iter().flat_map(|face| Self::edges(face)) {
                for (to, from) in [(a, b), (b, a)] {
                    let (sum, count) = &mut sums[to as usize];
                    *sum += self.points[from as usize];
                    *count += 1.0;
                }
            }
            for (v, (sum, count)) in sums.into_iter().enumerate() {
                if count > 0.0 && !fixed.contains(&(v as u32)) {
                    self.points[v] = 0.5 * (self.points[v] + sum / count);
                }
            }
        }
        self
    }

    /// Puts every point where `to` says.
    pub fn map(mut self, to: impl Fn(Vec3) -> Vec3) -> Self {
        self.points.iter_mut().for_each(|p| *p = to(*p));
        self
    }

    /// Bends space by three random waves of about its own size. Their slopes are below 1 / 2 together, so nothing meets.
    pub fn warp(self, random: &mut Random) -> Self {
        let reach = self.points.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        let waves = [(); 3].map(|()| (random.direction(), random.direction(), std::f64::consts::TAU * random.unit()));
        let number = 2.5 / reach; // rad per length
        self.map(|p| {
            let mut out = p;
            for (along, by, phase) in waves {
                let height = 0.16 / number * libm::sin(number * along.dot(&p) + phase);
                out += height * by;
            }
            out
        })
    }

    /// Moves every point by up to `amount` along each axis.
    pub fn roughen(mut self, amount: f64, random: &mut Random) -> Self {
        for point in &mut self.points {
            *point += amount * random.vector();
        }
        self
    }

    /// Splits a share of the quads into triangles, along a random diagonal each.
    pub fn split(mut self, share: f64, random: &mut Random) -> Self {
        let (faces, parts) = (std::mem::take(&mut self.faces), std::mem::take(&mut self.part));
        for (face, part) in faces.into_iter().zip(parts) {
            let pieces = match face[..] {
                [a, b, c, d] if random.unit() < share => {
                    if random.below(2) == 0 {
                        vec![vec![a, b, c], vec![a, c, d]]
                    } else {
                        vec![vec![b, c, d], vec![b, d, a]]
                    }
                }
                _ => vec![face],
            };
            self.part.extend(pieces.iter().map(|_| part));
            self.faces.extend(pieces);
        }
        self
    }

    /// Takes away all faces around up to `count` vertices that have no face in common with one another or with a border.
    pub fn punch(mut self, count: usize, random: &mut Random) -> Self {
        let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            face.iter().for_each(|v| around.entry(*v).or_default().push(f));
        }
        let (mut gone, mut taken) = (BTreeSet::new(), self.border());
        let mut vertices: Vec<u32> = around.keys().copied().collect();
        random.shuffle(&mut vertices);
        for v in vertices {
            let ring: BTreeSet<u32> = around[&v].iter().flat_map(|f| self.faces[*f].iter().copied()).collect();
            if gone.len() == count || ring.iter().any(|v| taken.contains(v)) {
                continue;
            }
            gone.insert(v);
            taken.extend(ring);
        }
        let keep: Vec<bool> = self.faces.iter().map(|face| !face.iter().any(|v| gone.contains(v))).collect();
        let mut kept = keep.iter();
        self.faces.retain(|_| *kept.next().expect("one each"));
        let mut kept = keep.iter();
        self.part.retain(|_| *kept.next().expect("one each"));
        self
    }

    /// Adds another shape as a part of its own.
    pub fn add(&mut self, other: Shape) {
        let (first, part) = (self.points.len() as u32, self.part.iter().max().map_or(0, |part| part + 1));
        self.points.extend(other.points);
        self.part.extend(other.part.iter().map(|p| p + part));
        self.faces.extend(other.faces.into_iter().map(|face| face.into_iter().map(|v| v + first).collect()));
    }

    /// Numbers the vertices that faces use by their first use and leaves the others out.
    pub fn compact(mut self) -> Self {
        let mut new = BTreeMap::new();
        let mut points = Vec::new();
        for v in self.faces.iter_mut().flatten() {
            *v = *new.entry(*v).or_insert_with(|| {
                points.push(self.points[*v as usize]);
                points.len() as u32 - 1
            });
        }
        self.points = points;
        self
    }
}
