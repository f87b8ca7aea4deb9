//! Intersection of a facet of the blade's swept surface with the mesh. The mesh is not changed.
//!
//! Two predicates are evaluated, each once per entity. The first is the side of the facet's plane of each vertex, exactly; vertices close to the
//! plane count as on it. The plane intersects the edges whose ends have different signs, and within a triangle the intersections are connected
//! by a straight run. Runs are the level set of a piecewise linear function, so they form unbroken lines whatever the signs are, and adjacent
//! triangles always agree. The second, in the plane, is whether the ends of a run are inside of the facet, again exactly with a margin; a run
//! is clipped once for all triangles that share it.
//!
//! Rejected: intersecting edges with facets and facet sides with triangles in space. With exact predicates this is consistent only without
//! snapping, and without snapping every second cut leaves slivers.

mod clip;
mod site;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use clip::{ClippedRun, End, clip, cross};
use site::Sites;
pub(super) use site::compare;

use super::blade::{Facet, turn};
use super::mesh::CutMesh;
use super::record::{NONE, OPEN};
use super::snap::SnapTolerances;
use pliant_mesh::geometry::Vec3;

/// Fraction of a run: if less of it is within the facet, that piece is collapsed to a point.
const MIN_PIECE: f64 = 1e-3;

/// Largest distance off the plane to which a node is moved along its edge, in lengths of the edge.
const MAX_SLIDE: f64 = 0.02;
/// Smallest distance from the last blade and from the ends of its edge at which a node is left that was moved, in lengths of the edge.
const CLEARANCE: f64 = 1e-3;
/// Largest number of nodes in a row that are moved.
const MAX_SLID: usize = 4;

/// The intersection of a facet with the mesh.
pub(super) struct Trace {
    sites: Sites,
    pub nodes: Vec<Node>,
    pub runs: Vec<Run>,
    on_edge: HashMap<[u32; 2], Vec<u32>>, // nodes on the edge between two sites, from the lower site
    at_site: Vec<u32>,                    // node of each site, or `NONE`
    chord: HashMap<[u32; 2], u32>,        // run between two nodes, lower first
    /// A node from which a line continues that the previous facet did not cut up to there, because it passes beside the seam.
    pub beside_seam: Option<u32>,
}

/// An intersection point of the facet's plane with the mesh.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub place: Location,
    pub x: Vec3,
    pub flat: [f64; 2],
    /// Position relative to each side of the facet: inside (1), on the side (0), outside (-1).
    pub rim: [i8; 3],
}

/// The mesh entity a node lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Location {
    /// At the vertices of a site.
    Vertex(u32),
    /// On an edge between two sites, at the parameter `t` in (0, 1) from the lower one.
    Edge([u32; 2], f64),
    /// In a triangle, on the run between two nodes, at the parameter `t` in (0, 1) from the first.
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

/// A triangle that a run crosses, or an edge that it follows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    pub body: u32,
    /// The interior of the body is to the left (1) or right (-1) of the run, or on both or neither side (0).
    pub flow: i8,
    /// Whether one of the faces lies in the plane.
    pub flat: bool,
}

/// A node moved along its edge.
struct SlidNode {
    node: u32,
    place: Location,
    x: Vec3,
    off_plane: f64, // in lengths of the edge
}

impl Run {
    /// Whether it is of closed bodies alone.
    fn is_solid(&self) -> bool {
        self.members.iter().all(|member| member.body != OPEN)
    }

    /// Whether it is the border of a former cut in the same plane, which is open already.
    pub fn is_open_already(&self) -> bool {
        self.along_edge && self.members.len() > 1 && self.members.iter().all(|member| member.flat)
    }
}

impl Trace {
    /// Intersects the triangles `near` (ascending) with a facet. Vertices of `seam` count as on side 0 of the facet, whatever their rounded and
    /// snapped coordinates are.
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
        if facet.continues {
            trace.beside_seam = trace.beside_seam.or_else(|| trace.abandoned(mesh, near, seam));
        }
        trace
    }

    /// A node at a vertex of `seam` on the surface of a closed body from which no line leads on.
    fn abandoned(&self, mesh: &CutMesh, near: &[u32], seam: &[u32]) -> Option<u32> {
        let leads_on = |run: &&Run| run.piece.is_some() && run.is_solid() && run.members.iter().any(|m| m.flow != 0);
        let mut led: Vec<u32> = self.runs.iter().filter(leads_on).flat_map(|run| run.ends).collect();
        led.sort_unstable();
        let skin = near.iter().filter(|t| mesh.body[**t as usize] != OPEN && !mesh.is_cap(**t));
        let corners = skin.flat_map(|t| mesh.surface.triangles[*t as usize]);
        let on_seam = corners.filter(|vertex| seam.binary_search(vertex).is_ok());
        on_seam.filter_map(|vertex| self.node_at(mesh, vertex)).find(|node| led.binary_search(node).is_err())
    }

    /// The site of a vertex; a vertex that is not near the facet has the site of a near one at the same position.
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

    /// The two nodes where the plane crosses the boundary of a triangle, counter-clockwise: first from left to right, then back, so that the left
    /// side of the plane is to the left of the line between them.
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

    /// Adds the edge of `half`, which lies in the plane, as a run.
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

    /// Side of the plane on which the triangle of a half-edge in the plane lies. The triangle may be too far away to have sites.
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

    /// Whether two triangles in the plane lie on the same side of their shared edge.
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
            self.at_site[site as usize] = self.add_node(Location::Vertex(site), self.sites.all[site as usize].x, facet);
        }
    }

    fn node_on_edge(&mut self, edge: [u32; 2], facet: &Facet) {
        if !self.on_edge.contains_key(&edge) {
            let [low, high] = edge.map(|site| &self.sites.all[site as usize]);
            let t = cross([[low.height; 3], [high.height; 3]], 0);
            let node = self.add_node(Location::Edge(edge, t), between(low.x, high.x, t), facet);
            self.on_edge.insert(edge, vec![node]);
        }
    }

    fn add_node(&mut self, place: Location, x: Vec3, facet: &Facet) -> u32 {
        self.nodes.push(Node { place, x, flat: facet.flatten(x), rim: [0; 3] });
        self.nodes.len() as u32 - 1
    }

    /// Computes the position of every node relative to the sides of the facet.
    fn place_on_rim(&mut self, mesh: &CutMesh, facet: &Facet, seam: &[u32], snap: SnapTolerances) {
        // Walls of earlier cuts have edges far longer than an advance.
        let farthest = snap.beside * facet.width();
        for node in &mut self.nodes {
            let length = match node.place {
                Location::Vertex(site) => self.sites.all[site as usize].shortest,
                Location::Edge([a, b], _) => self.sites.length(a, b),
                Location::Face(..) => 0.0,
            };
            let margin = (snap.on * length).min(farthest);
            for side in 0..3 {
                // Nodes on the side shared by two facets were determined with the first facet and are in `seam`. With a different margin here,
                // neither facet would cut what lies between.
                let decided = side == 0 && facet.continues;
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
                let margin = (snap.ends * (from + to)).min(farthest);
                if from < margin {
                    near.push((run.ends[0], side));
                } else if to < margin {
                    near.push((run.ends[1], side));
                }
            }
        }
        for (node, side) in near {
            self.nodes[node as usize].rim[side] = 0;
        }
        self.go_back_to_border(facet);
        self.slide_past_seam(facet);
    }

    /// Moves nodes of a closed body along their edges to the other side of the last blade, where a line that comes from a vertex on that blade turns back over it. The
    /// vertex was snapped to the last facet, so it is a little off the plane of this one: beside an edge nearly in the plane, the line then goes a little behind the blade
    /// before it goes on ahead, or the other way round, and what is cut ahead of the blade would begin beside the end of the cut.
    fn slide_past_seam(&mut self, facet: &Facet) {
        if !facet.continues {
            return;
        }
        let slid: Vec<SlidNode> = self
            .runs
            .iter()
            .filter(|run| run.is_solid() && self.seam_side(run.ends[0]) * self.seam_side(run.ends[1]) < 0)
            .flat_map(|run| {
                let ways = run.ends.map(|end| self.slide_way(end, facet));
                let farthest = |way: &[SlidNode]| way.iter().map(|slid| slid.off_plane).fold(0.0, f64::max);
                let nearest = ways.into_iter().flatten().min_by(|a, b| farthest(a).total_cmp(&farthest(b)));
                nearest.unwrap_or_default()
            })
            .collect();
        for SlidNode { node, place, x, .. } in slid {
            let node = &mut self.nodes[node as usize];
            (node.place, node.x, node.flat) = (place, x, facet.flatten(x));
            node.rim[0] = -node.rim[0];
        }
    }

    /// Side of the last blade that a node is on: ahead (1), on it (0), behind (-1).
    fn seam_side(&self, node: u32) -> i8 {
        self.nodes[node as usize].rim[0]
    }

    /// The nodes from `first` on along a line to a vertex on the last blade, all on one side of that, moved to its other side. `None` if there is no such line, or one
    /// of them cannot be moved.
    fn slide_way(&self, first: u32, facet: &Facet) -> Option<Vec<SlidNode>> {
        let mut way = vec![first];
        while way.len() <= MAX_SLID {
            let at = *way.last()?;
            let beside = self.runs.iter().filter(|run| run.is_solid() && run.ends.contains(&at));
            let others: Vec<u32> =
                beside.map(|run| if run.ends[0] == at { run.ends[1] } else { run.ends[0] }).collect();
            if let Some(on_blade) = others.iter().find(|node| self.seam_side(**node) == 0) {
                let beyond = depth(facet, 0, self.nodes[*on_blade as usize].flat).abs();
                return way.iter().map(|node| self.slide(*node, beyond, facet)).collect();
            }
            let next = |node: &&u32| self.seam_side(**node) == self.seam_side(first) && !way.contains(node);
            way.push(*others.iter().find(next)?);
        }
        None
    }

    /// Where a node on an edge comes to the other side of the last blade, farther than `beyond`, m; `None` if it is on no edge, or that is too far off the plane.
    fn slide(&self, node: u32, beyond: f64, facet: &Facet) -> Option<SlidNode> {
        let Location::Edge(sites, t) = self.nodes[node as usize].place else { return None };
        let [low, high] = sites.map(|site| self.sites.all[site as usize].x);
        let [from, to] = [low, high].map(|x| depth(facet, 0, facet.flatten(x)));
        let length = (high - low).norm();
        let target = -f64::from(self.seam_side(node)) * (2.0 * beyond + CLEARANCE * length);
        let there = (target - from) / (to - from);
        let off_plane = (there - t).abs() * (facet.height(high) - facet.height(low)).abs() / length;
        let is_near = off_plane <= MAX_SLIDE && (CLEARANCE..=1.0 - CLEARANCE).contains(&there);
        is_near.then(|| SlidNode { node, place: Location::Edge(sites, there), x: between(low, high, there), off_plane })
    }

    /// On a sheet, extends a line to the border if the previous facet did not reach it because the piece within was too short.
    fn go_back_to_border(&mut self, facet: &Facet) {
        if !facet.continues {
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
        match clip(rim, depths, MIN_PIECE) {
            ClippedRun::Nothing | ClippedRun::Location => {}
            // The front of the previous cut must be matched exactly. An edge of a face in the plane, with the interior on neither side, may pass
            // beside its end and is left unchanged.
            ClippedRun::Piece(piece) if facet.continues && piece.iter().any(is_on_seam) && self.is_idle(run) => {}
            ClippedRun::Piece(piece) => {
                if facet.continues && piece.iter().any(is_on_seam) {
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

    /// Whether no body's interior begins or ends at a run.
    fn is_idle(&self, run: usize) -> bool {
        self.runs[run].members.iter().all(|member| member.body != OPEN && member.flow == 0)
    }

    /// Adds a node on a run at the parameter `t`, 0 to 1.
    pub fn split(&mut self, ends: [u32; 2], along_edge: bool, t: f64, facet: &Facet) -> u32 {
        let [from, to] = ends.map(|end| self.nodes[end as usize].x);
        let upward = compare(from, to).is_lt();
        let (low, high, t) = if upward { (from, to, t) } else { (to, from, 1.0 - t) };
        let x = between(low, high, t);
        let [low, high] = if upward { ends } else { [ends[1], ends[0]] };
        if !along_edge {
            return self.add_node(Location::Face([low, high], t), x, facet);
        }
        // Runs along edges end at vertices.
        let sites =
            [low, high].map(|end| if let Location::Vertex(site) = self.nodes[end as usize].place { site } else { 0 });
        let node = self.add_node(Location::Edge(sites, t), x, facet);
        let nodes = self.on_edge.entry(sites).or_default();
        nodes.push(node);
        let at = |node: &u32| if let Location::Edge(_, t) = self.nodes[*node as usize].place { t } else { 0.0 };
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
