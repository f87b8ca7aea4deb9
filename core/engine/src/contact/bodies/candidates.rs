//! Features whose ways over a step come near each other, and the times at which they meet.

use super::features::{Kind, time_of_impact};
use super::surface::{CollisionSurface, NO_EDGE};
use super::tree::{self, are_near};
use super::{LEAST, LISTED, Member, Pair};
use pliant_solver::Vec3;
use std::collections::HashSet;

/// Two features that may meet in this step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub kind: Kind,
    /// Vertices, by their numbers among all.
    pub vertices: [u32; 4],
    /// Index of the pair.
    pub pair: u32,
    /// Time of their impact as a fraction of the step; infinite for none.
    pub impact: f64,
}

/// Lists the features of pairs of members whose ways from `from` to `to` (m) come near each other. Boxes of the trees must be up to date.
pub(super) fn list(
    surfaces: &[CollisionSurface],
    members: &[Member],
    pairs: &[Pair],
    from: &[Vec3],
    to: &[Vec3],
    stack: &mut Vec<[u32; 2]>,
    candidates: &mut Vec<Candidate>,
) {
    candidates.clear();
    for (number, pair) in pairs.iter().enumerate() {
        let [a, b] = pair.members.map(|at| members[at]);
        let [of_a, of_b] = [a, b].map(|member| &surfaces[member.body as usize]);
        let reach = LISTED * pair.thickness;
        let mut list = Lister { reach, pair: number as u32, from, to, candidates };
        let visit = |s: u32, t: u32| {
            let of_a = SurfaceTriangle { surface: of_a, first: a.vertex, triangle: s };
            let of_b = SurfaceTriangle { surface: of_b, first: b.vertex, triangle: t };
            list.add_vertices(of_a, of_b);
            list.add_vertices(of_b, of_a);
            list.add_edges(of_a, of_b);
        };
        match pair.members[0] == pair.members[1] {
            true => of_a.tree.own_pairs(reach, stack, visit),
            false => of_a.tree.pairs(&of_b.tree, reach, stack, visit),
        }
    }
}

/// Finds the candidates that meet on their ways from `from` to `to` (m). Returns the time of the first impact as a fraction of the step, infinite if there is
/// none.
pub(super) fn find_impacts(candidates: &mut [Candidate], pairs: &[Pair], from: &[Vec3], to: &[Vec3]) -> f64 {
    let mut first = f64::INFINITY;
    for candidate in candidates {
        let least = LEAST * pairs[candidate.pair as usize].thickness;
        let [from, to] = [from, to].map(|x| candidate.vertices.map(|v| x[v as usize]));
        candidate.impact = time_of_impact(candidate.kind, &from, &to, least).unwrap_or(f64::INFINITY);
        first = first.min(candidate.impact);
    }
    first
}

/// The first impacts of vertices and of edges, with their buffers.
#[derive(Default)]
pub(super) struct FirstImpacts {
    /// Candidates with an impact, in the order of their times.
    order: Vec<u32>,
    /// Vertices, as a pair of equal numbers, and edges that have met something.
    met: HashSet<[u32; 2]>,
}

impl FirstImpacts {
    /// Finds the candidates with the first impact of a vertex or of an edge, in the order of their times: what a feature would meet later, as the far side of
    /// a body, it does not come to meet.
    pub fn find(&mut self, candidates: &[Candidate]) -> &[u32] {
        let Self { order, met } = self;
        order.clear();
        order.extend((0..candidates.len() as u32).filter(|at| candidates[*at as usize].impact.is_finite()));
        let time = |at: &u32| candidates[*at as usize].impact;
        order.sort_unstable_by(|a, b| time(a).total_cmp(&time(b)).then(a.cmp(b)));
        met.clear();
        order.retain(|at| {
            let Candidate { kind, vertices: [a, b, c, d], .. } = candidates[*at as usize];
            match kind {
                Kind::VertexTriangle => met.insert([a, a]),
                Kind::EdgeEdge => met.insert([a.min(b), a.max(b)]) | met.insert([c.min(d), c.max(d)]),
            }
        });
        order
    }
}

/// Lists candidates of two triangles that are near each other.
struct Lister<'a> {
    /// Distance within which features are listed, m.
    reach: f64,
    pair: u32,
    from: &'a [Vec3],
    to: &'a [Vec3],
    candidates: &'a mut Vec<Candidate>,
}

/// A triangle of the surface of a member.
#[derive(Clone, Copy)]
struct SurfaceTriangle<'a> {
    surface: &'a CollisionSurface,
    /// Number of the first vertex of the surface among the vertices of all members.
    first: u32,
    /// Number of the triangle on the surface.
    triangle: u32,
}

impl Lister<'_> {
    /// Adds the vertices that a triangle looks after with another triangle.
    fn add_vertices(&mut self, of: SurfaceTriangle<'_>, other: SurfaceTriangle<'_>) {
        let (s, t) = (of.triangle as usize, other.triangle as usize);
        let corners = other.surface.triangles[t].map(|v| other.first + v);
        let own = of.surface.triangles[s].iter().zip(of.surface.own_vertices[s]);
        for vertex in own.filter(|(_, own)| *own).map(|(v, _)| of.first + v) {
            if !corners.contains(&vertex) {
                self.add(Kind::VertexTriangle, [vertex, corners[0], corners[1], corners[2]], 1);
            }
        }
    }

    /// Adds the edges that one triangle looks after with those of the other.
    fn add_edges(&mut self, of: SurfaceTriangle<'_>, other: SurfaceTriangle<'_>) {
        let (s, t) = (of.triangle as usize, other.triangle as usize);
        for e in of.surface.own_edges[s].into_iter().filter(|e| *e != NO_EDGE) {
            let [a, b] = of.surface.edges[e as usize].map(|v| of.first + v);
            for f in other.surface.own_edges[t].into_iter().filter(|f| *f != NO_EDGE) {
                let [c, d] = other.surface.edges[f as usize].map(|v| other.first + v);
                if a != c && a != d && b != c && b != d {
                    self.add(Kind::EdgeEdge, [a, b, c, d], 2);
                }
            }
        }
    }

    /// Adds a candidate if the ways of its first `count` vertices and of the others come near each other.
    fn add(&mut self, kind: Kind, vertices: [u32; 4], count: usize) {
        let swept = |of: &[u32]| {
            of.iter().fold(tree::EMPTY, |[low, high], v| {
                let (from, to) = (&self.from[*v as usize], &self.to[*v as usize]);
                [low.inf(from).inf(to), high.sup(from).sup(to)]
            })
        };
        if are_near(&swept(&vertices[..count]), &swept(&vertices[count..]), self.reach) {
            self.candidates.push(Candidate { kind, vertices, pair: self.pair, impact: f64::INFINITY });
        }
    }
}
