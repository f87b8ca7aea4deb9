//! Sides of a facet's plane for the vertices near it.
//!
//! All further decisions use these signs, one for each position: vertices that a former cut has separated but that still coincide share one
//! sign, so that the plane crosses both sides of an open cut alike.

use std::cmp::Ordering;

use crate::blade::Facet;
use crate::snap::SnapTolerances;
use pliant_mesh::geometry::Vec3;

/// A position with one or more vertices. Sites are numbered in the order of their coordinates.
pub(super) struct Site {
    pub x: Vec3,
    pub height: f64, // signed distance from the plane, m; 0 on it
    pub sign: i8,
    pub shortest: f64, // length of the shortest adjacent edge, m
}

/// The sites of some vertices.
pub(super) struct Sites {
    pub all: Vec<Site>,
    vertices: Vec<u32>, // ascending
    site: Vec<u32>,     // site of each vertex
}

impl Sites {
    /// Sites of the corners of `triangles`, with their signs. Vertices of `seam` count as on the plane whatever their coordinates are.
    pub fn new(x: &[Vec3], triangles: &[[u32; 3]], facet: &Facet, seam: &[u32], snap: SnapTolerances) -> Self {
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
        let place = |at: u32| x[vertices[at as usize] as usize];
        order.sort_by(|&a, &b| compare(place(a), place(b)));
        let mut sites = Self { all: Vec::new(), site: vec![0; vertices.len()], vertices: Vec::new() };
        for &at in &order {
            let here = place(at);
            if sites.all.last().is_none_or(|last| compare(last.x, here).is_ne()) {
                let (sign, height) = (facet.side(here), facet.height(here));
                sites.all.push(Site { x: here, height, sign, shortest: f64::INFINITY });
            }
            sites.site[at as usize] = sites.all.len() as u32 - 1;
        }
        sites.vertices = vertices;
        sites.measure(triangles);
        for site in &mut sites.all {
            if site.height.abs() <= snap.on * site.shortest {
                site.lay();
            }
        }
        for site in seam.iter().filter_map(|&vertex| sites.of(vertex)).collect::<Vec<_>>() {
            sites.all[site as usize].lay();
        }
        sites.snap_ends(triangles, snap);
        sites
    }

    /// The site of a vertex, if it is one of these.
    pub fn of(&self, vertex: u32) -> Option<u32> {
        self.vertices.binary_search(&vertex).ok().map(|at| self.site[at])
    }

    /// The site at a position.
    pub fn at(&self, x: Vec3) -> Option<u32> {
        self.all.binary_search_by(|site| compare(site.x, x)).ok().map(|at| at as u32)
    }

    pub fn of_corners(&self, triangle: [u32; 3]) -> [u32; 3] {
        triangle.map(|vertex| self.of(vertex).unwrap_or(0))
    }

    pub fn sign(&self, site: u32) -> i8 {
        self.all[site as usize].sign
    }

    pub fn length(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|site| self.all[site as usize].x);
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }

    fn measure(&mut self, triangles: &[[u32; 3]]) {
        for triangle in triangles {
            let sites = self.of_corners(*triangle);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let length = self.length(sites[a], sites[b]);
                for end in [a, b] {
                    let shortest = &mut self.all[sites[end] as usize].shortest;
                    *shortest = shortest.min(length);
                }
            }
        }
    }

    /// Snaps vertices to the plane if it intersects one of their edges so close to them that a new vertex would leave a sliver.
    fn snap_ends(&mut self, triangles: &[[u32; 3]], snap: SnapTolerances) {
        let mut near = Vec::new();
        for triangle in triangles {
            let sites = self.of_corners(*triangle);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let [from, to] = [a, b].map(|end: usize| &self.all[sites[end] as usize]);
                if from.sign * to.sign >= 0 {
                    continue;
                }
                let both = from.height.abs() + to.height.abs();
                for (end, site) in [(a, from), (b, to)] {
                    if site.height.abs() < snap.ends * both && site.height.abs() < snap.reach * site.shortest {
                        near.push(sites[end]);
                    }
                }
            }
        }
        for site in near {
            self.all[site as usize].lay();
        }
    }
}

impl Site {
    fn lay(&mut self) {
        self.height = 0.0;
        self.sign = 0;
    }
}

/// Lexicographic order of coordinates; zeros of both signs are equal.
pub(crate) fn compare(a: Vec3, b: Vec3) -> Ordering {
    let key = |x: Vec3| x.map(|c| c + 0.0);
    let (a, b) = (key(a), key(b));
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
}
