//! Where a facet of the blade's way crosses the mesh: intersection only, nothing is changed.
//!
//! Two things are decided, each once. On which side of the facet's plane a vertex is, exactly, those close to it counting as
//! on it: where signs differ along an edge the plane crosses it, and within every triangle the crossings are joined by a
//! straight run. So runs form unbroken lines whatever the signs are (they are the level set of a continuous function), and
//! nothing can disagree between two triangles. Then, in the plane, whether the ends of a run are inside the facet, again
//! exactly and with a margin, and what is left of the run: so a run is cut short in the same way for all who share it.
//!
//! Rejected: testing edges against facets and facet sides against triangles in space. Exact signs alone keep that free of
//! contradiction only as long as nothing is snapped, and without snapping every second cut leaves splinters.

mod clip;
mod site;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use clip::{End, Left, clip, cross};
use site::Sites;
pub(super) use site::compare;

use super::blade::{Facet, turn};
use super::mesh::CutMesh;
use super::record::{NONE, OPEN};
use super::snap::SnapTolerances;
use pliant_mesh::geometry::Vec3;

/// Part of a run; less of it within a facet is a place.
const LEAST: f64 = 1e-3;

/// What a facet meets.
pub(super) struct Trace {
    sites: Sites,
    pub nodes: Vec<Node>,
    pub runs: Vec<Run>,
    on_edge: HashMap<[u32; 2], Vec<u32>>, // nodes on the edge between two sites, from the lower on
    at_site: Vec<u32>,                    // node of each site, or `NONE`
    chord: HashMap<[u32; 2], u32>,        // run between two nodes, lower first
    /// A node where a line goes on that was not cut up to there: next to the seam, and so past it.
    pub beside_seam: Option<u32>,
}

/// A place on the mesh that the facet passes.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub place: Place,
    pub x: Vec3,
    pub flat: [f64; 2],
    /// For each side of the facet: inside (1), on the side (0), outside (-1).
    pub rim: [i8; 3],
}

/// Where on the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// At the vertices of a site.
    Vertex(u32),
    /// On an edge between two sites, `t` of the way from the lower.
    Edge([u32; 2], f64),
    /// In a triangle, on the run between two nodes, `t` of the way from the first.
    Face([u32; 2], f64),
}

/// A straight line across a triangle or along an edge, and the piece of it within the facet.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub ends: [u32; 2], // nodes, lower first
    pub along_edge: bool,
    pub members: Vec<Member>,
    pub piece: Option<[u32; 2]>, // nodes, in the sense of `ends`
}

/// A triangle that a run crosses, or an edge that it goes along.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    pub body: u32,
    /// Inside of the body is to the left (1) or right (-1) of the run, or it does not change there (0).
    pub flow: i8,
    /// One of the faces lies in the plane.
    pub flat: bool,
}

impl Run {
    /// The rim of a former cut in the same plane: there is nothing to open.
    pub fn is_open_already(&self) -> bool {
        self.along_edge && self.members.len() > 1 && self.members.iter().all(|member| member.flat)
    }
}

impl Trace {
    /// Crosses the triangles `near` (rising) with a facet. Vertices of `seam` lie on side 0 of the facet, whatever rounding
    /// and snapping made of them.
    pub fn new(mesh: &CutMesh, near: &[u32], facet: &Facet, seam: &[u32], snap: SnapTolerances) -> Self {
        let triangles: Vec<[u32; 3]> = near.iter().map(|&t| mesh.surface.triangles[t as usize]).collect();
        let sites = Sites::new(&mesh.surface.points, &triangles, facet, seam, snap);
        let at_site = vec![NONE; sites.all.len()];
        let mut trace = Self {
            sites,
            nodes: Vec::new(),
            runs: Vec::new(),
            on_edge: HashMap::new(),
            at_site,
            chord: HashMap::new(),
            beside_seam: None,
        };
        let mut rims = Vec::new();
        for (&triangle, corners) in near.iter().zip(&triangles) {
            trace.cross_triangle(mesh, triangle, *corners, facet, &mut rims);
        }
        rims.sort_unstable();
        rims.dedup();
        for half in rims {
            trace.go_along(mesh, half, facet, snap);
        }
        trace.place_on_rim(mesh, facet, seam, snap);
        for run in 0..trace.runs.len() {
            trace.clip_run(run, facet);
        }
        trace
    }

    /// The site of a vertex, also of one further off that shares its place with one that is near.
    pub fn site(&self, mesh: &CutMesh, vertex: u32) -> Option<u32> {
        self.sites.of(vertex).or_else(|| self.sites.at(mesh.surface.points[vertex as usize]))
    }

    /// Node at a vertex, if it is on the plane.
    pub fn node_at(&self, mesh: &CutMesh, vertex: u32) -> Option<u32> {
        let node = self.at_site[self.site(mesh, vertex)? as usize];
        (node != NONE).then_some(node)
    }

    /// Nodes on the edge from one vertex to another, in this order.
    pub fn nodes_on(&self, mesh: &CutMesh, from: u32, to: u32) -> Vec<u32> {
        let (Some(a), Some(b)) = (self.site(mesh, from), self.site(mesh, to)) else { return Vec::new() };
        let mut nodes = self.on_edge.get(&[a.min(b), a.max(b)]).cloned().unwrap_or_default();
        if a > b {
            nodes.reverse();
        }
        nodes
    }

    /// The run across a triangle, if any.
    pub fn run_across(&self, corners: [u32; 3]) -> Option<u32> {
        let [from, to] = self.crossings(self.sites.of_corners(corners))?;
        self.chord.get(&[from.min(to), from.max(to)]).copied()
    }

    /// Nodes where the plane leaves the left and comes back to it, going round a triangle counter-clockwise: the left is to
    /// the left of the line from the first to the second.
    fn crossings(&self, sites: [u32; 3]) -> Option<[u32; 2]> {
        let sign = sites.map(|site| self.sites.sign(site));
        if !(sign.contains(&1) && sign.contains(&-1)) {
            return None;
        }
        let mut found = [NONE; 2];
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let edge = [sites[corner].min(sites[next]), sites[corner].max(sites[next])];
            let on_edge = || self.on_edge.get(&edge).and_then(|nodes| nodes.first()).copied().unwrap_or(NONE);
            match [sign[corner], sign[next]] {
                [1, -1] => found[0] = on_edge(),
                [-1, 1] => found[1] = on_edge(),
                [0, 1] => found[1] = self.at_site[sites[corner] as usize],
                [0, -1] => found[0] = self.at_site[sites[corner] as usize],
                _ => {}
            }
        }
        (!found.contains(&NONE) && found[0] != found[1]).then_some(found)
    }

    fn cross_triangle(&mut self, mesh: &CutMesh, triangle: u32, corners: [u32; 3], facet: &Facet, rims: &mut Vec<u32>) {
        let sites = self.sites.of_corners(corners);
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let [a, b] = [sites[corner].min(sites[next]), sites[corner].max(sites[next])];
            if self.sites.sign(sites[corner]) == 0 {
                self.node_of_site(sites[corner], facet);
            }
            match [self.sites.sign(a), self.sites.sign(b)] {
                [1, -1] | [-1, 1] => self.node_on_edge([a, b], facet),
                [0, 0] if a != b => {
                    let half = 3 * triangle + corner as u32;
                    rims.push(mesh.around(half).min().unwrap_or(half));
                }
                _ => {}
            }
        }
        if let Some([from, to]) = self.crossings(sites) {
            let flow = if from < to { 1 } else { -1 };
            self.add([from, to], false, Member { body: mesh.body[triangle as usize], flow, flat: false });
        }
    }

    /// Takes in the edge of `half`, which lies in the plane.
    fn go_along(&mut self, mesh: &CutMesh, half: u32, facet: &Facet, snap: SnapTolerances) {
        let [from, to] = [mesh.tail(half), mesh.head(half)].map(|vertex| self.node_at(mesh, vertex).unwrap_or(NONE));
        let side = |half: u32| self.third_side(mesh, half, facet, snap);
        let body = mesh.body[half as usize / 3];
        if body == OPEN {
            let below = mesh.around(half).filter(|&half| side(half) == -1).count();
            if below > 0 && below < mesh.around(half).count() {
                self.add([from, to], true, Member { body, flow: 1, flat: false });
            }
            return;
        }
        let other = mesh.link_of(half);
        let sides = [side(half), side(other)];
        if sides == [0, 0] && !self.folded(mesh, half, other, facet) {
            return;
        }
        let flow = i8::from(sides[1] == -1) - i8::from(sides[0] == -1);
        let flow = if from < to { flow } else { -flow };
        self.add([from, to], true, Member { body, flow, flat: sides[0] * sides[1] == 0 && sides != [0, 0] });
    }

    /// Side of the triangle of a half-edge that lies in the plane. The triangle may be too far off to have sites.
    pub fn third_side(&self, mesh: &CutMesh, half: u32, facet: &Facet, snap: SnapTolerances) -> i8 {
        let triangle = mesh.surface.triangles[half as usize / 3];
        let third = triangle[(half as usize + 2) % 3];
        if let Some(site) = self.site(mesh, third) {
            return self.sites.sign(site);
        }
        let here = mesh.surface.points[third as usize];
        let away = |vertex: u32| {
            let there = mesh.surface.points[vertex as usize];
            (0..3).map(|i| (here[i] - there[i]).powi(2)).sum::<f64>().sqrt()
        };
        let shortest = away(mesh.tail(half)).min(away(mesh.head(half)));
        if facet.height(here).abs() <= snap.on * shortest { 0 } else { facet.side(here) }
    }

    /// Whether two triangles in the plane lie on the same side of their edge.
    fn folded(&self, mesh: &CutMesh, half: u32, other: u32, facet: &Facet) -> bool {
        let flat = |vertex: u32| facet.flatten(mesh.surface.points[vertex as usize]);
        let third = |half: u32| flat(mesh.surface.triangles[half as usize / 3][(half as usize + 2) % 3]);
        let [a, b] = [flat(mesh.tail(half)), flat(mesh.head(half))];
        turn(a, b, third(half)) == turn(a, b, third(other))
    }

    fn add(&mut self, ends: [u32; 2], along_edge: bool, member: Member) {
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        if ends.contains(&NONE) || ends[0] == ends[1] {
            return;
        }
        match self.chord.entry(ends) {
            Entry::Occupied(run) => self.runs[*run.get() as usize].members.push(member),
            Entry::Vacant(place) => {
                place.insert(self.runs.len() as u32);
                self.runs.push(Run { ends, along_edge, members: vec![member], piece: None });
            }
        }
    }

    fn node_of_site(&mut self, site: u32, facet: &Facet) {
        if self.at_site[site as usize] == NONE {
            self.at_site[site as usize] = self.add_node(Place::Vertex(site), self.sites.all[site as usize].x, facet);
        }
    }

    fn node_on_edge(&mut self, edge: [u32; 2], facet: &Facet) {
        if !self.on_edge.contains_key(&edge) {
            let [low, high] = edge.map(|site| &self.sites.all[site as usize]);
            let t = cross([[low.height; 3], [high.height; 3]], 0);
            let node = self.add_node(Place::Edge(edge, t), between(low.x, high.x, t), facet);
            self.on_edge.insert(edge, vec![node]);
        }
    }

    fn add_node(&mut self, place: Place, x: Vec3, facet: &Facet) -> u32 {
        self.nodes.push(Node { place, x, flat: facet.flatten(x), rim: [0; 3] });
        self.nodes.len() as u32 - 1
    }

    /// Where every node is against the sides of the facet.
    fn place_on_rim(&mut self, mesh: &CutMesh, facet: &Facet, seam: &[u32], snap: SnapTolerances) {
        for node in &mut self.nodes {
            let margin = snap.on
                * match node.place {
                    Place::Vertex(site) => self.sites.all[site as usize].shortest,
                    Place::Edge([a, b], _) => self.sites.length(a, b),
                    Place::Face(..) => 0.0,
                };
            for side in 0..3 {
                // What is on the side that two facets share was decided with the first of them: those are in `seam`. With
                // another margin here, what lies between would be cut by neither.
                let decided = side == 0 && facet.goes_on;
                let near = !decided && depth(facet, side, node.flat).abs() <= margin;
                let [a, b] = facet.rim(side);
                node.rim[side] = if near { 0 } else { turn(a, b, node.flat) };
            }
        }
        for vertex in seam {
            if let Some(node) = self.node_at(mesh, *vertex) {
                self.nodes[node as usize].rim[0] = 0;
            }
        }
        let mut near = Vec::new();
        for run in &self.runs {
            let ends = run.ends.map(|end| &self.nodes[end as usize]);
            for side in (0..3).filter(|&side| ends[0].rim[side] * ends[1].rim[side] < 0) {
                let [from, to] = ends.map(|end| depth(facet, side, end.flat).abs());
                if from < snap.ends * (from + to) {
                    near.push((run.ends[0], side));
                } else if to < snap.ends * (from + to) {
                    near.push((run.ends[1], side));
                }
            }
        }
        for (node, side) in near {
            self.nodes[node as usize].rim[side] = 0;
        }
        self.go_back_to_border(facet);
    }

    /// On a sheet a line that the facet before did not reach, so little of it was within, is cut from where it begins.
    fn go_back_to_border(&mut self, facet: &Facet) {
        if !facet.goes_on {
            return;
        }
        let mut back = Vec::new();
        for run in self.runs.iter().filter(|run| run.members.iter().all(|member| member.body == OPEN)) {
            match run.ends.map(|end| self.nodes[end as usize].rim[0]) {
                [-1, 1] => back.push(run.ends[0]),
                [1, -1] => back.push(run.ends[1]),
                _ => {}
            }
        }
        back.into_iter().for_each(|node| self.nodes[node as usize].rim[0] = 0);
    }

    fn clip_run(&mut self, run: usize, facet: &Facet) {
        let Run { ends, along_edge, .. } = self.runs[run];
        let rim = ends.map(|end| self.nodes[end as usize].rim);
        let depths = ends.map(|end| [0, 1, 2].map(|side| depth(facet, side, self.nodes[end as usize].flat)));
        match clip(rim, depths, LEAST) {
            Left::Nothing | Left::Place => {}
            // The front of the cut so far must be met as it is. The edge of a face in the plane, with the inside on neither side
            // of it, may pass beside its end; it is left as it is.
            Left::Piece(piece) if facet.goes_on && piece.iter().any(is_on_seam) && self.is_idle(run) => {}
            Left::Piece(piece) => {
                if facet.goes_on && piece.iter().any(is_on_seam) {
                    self.beside_seam = Some(ends[0]);
                }
                let node = |trace: &mut Self, own: u32, end: End| match end {
                    End::Own => own,
                    End::Crossing { side, t } => {
                        let node = trace.split(ends, along_edge, t, facet);
                        trace.nodes[node as usize].rim = [1; 3];
                        trace.nodes[node as usize].rim[side] = 0;
                        node
                    }
                };
                let from = node(self, ends[0], piece[0]);
                let to = node(self, ends[1], piece[1]);
                self.runs[run].piece = Some([from, to]);
            }
        }
    }

    /// Whether the inside of no body begins or ends at a run.
    fn is_idle(&self, run: usize) -> bool {
        self.runs[run].members.iter().all(|member| member.body != OPEN && member.flow == 0)
    }

    /// A new node on a run, `t` of the way along.
    pub fn split(&mut self, ends: [u32; 2], along_edge: bool, t: f64, facet: &Facet) -> u32 {
        let [from, to] = ends.map(|end| self.nodes[end as usize].x);
        let upward = compare(from, to).is_lt();
        let (low, high, t) = if upward { (from, to, t) } else { (to, from, 1.0 - t) };
        let x = between(low, high, t);
        let [low, high] = if upward { ends } else { [ends[1], ends[0]] };
        if !along_edge {
            return self.add_node(Place::Face([low, high], t), x, facet);
        }
        let sites = [low, high].map(|end| match self.nodes[end as usize].place {
            Place::Vertex(site) => site,
            _ => 0, // runs along edges end at vertices
        });
        let node = self.add_node(Place::Edge(sites, t), x, facet);
        let nodes = self.on_edge.entry(sites).or_default();
        nodes.push(node);
        let at = |node: &u32| if let Place::Edge(_, t) = self.nodes[*node as usize].place { t } else { 0.0 };
        nodes.sort_by(|a, b| at(a).total_cmp(&at(b)));
        node
    }
}

fn is_on_seam(end: &End) -> bool {
    matches!(end, End::Crossing { side: 0, .. })
}

fn depth(facet: &Facet, side: usize, flat: [f64; 2]) -> f64 {
    let [a, b] = facet.rim(side);
    let along = [b[0] - a[0], b[1] - a[1]];
    (along[0] * (flat[1] - a[1]) - along[1] * (flat[0] - a[0])) / (along[0] * along[0] + along[1] * along[1]).sqrt()
}

pub(super) fn between(low: Vec3, high: Vec3, t: f64) -> Vec3 {
    low + t * (high - low)
}
