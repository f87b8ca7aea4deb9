//! Numbers of nodes and elements, where a file has its vertices in no order.
//!
//! A step reads the neighbours of a node with it, and cuts elements into ranges that share few nodes: both want neighbours to have
//! numbers that are near. Where those of the file are far from it, nodes go layer by layer from an end of the mesh, in reverse
//! (Cuthill and McKee 1969, George 1971), and triangles go with them.

use super::NONE;
use pliant_mesh::Surface;

/// How far the numbers of neighbours are from each other, on average, that are near in any order.
const NEAR: usize = 64;
/// How many times nearer they have to be for another order than that of the file.
const WORTH: usize = 4;

/// The vertices and triangles of a mesh in the order in which they are nodes and elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// Vertices that triangles use.
    pub vertices: Vec<u32>,
    /// Triangles.
    pub triangles: Vec<u32>,
    /// Vertices there were, used or not.
    count: usize,
}

impl Order {
    /// That of the file, or another if it is much better.
    pub fn of(surface: &Surface) -> Self {
        let graph = Graph::new(surface);
        let vertices: Vec<u32> = (0..surface.points.len() as u32).filter(|v| !graph.of(*v).is_empty()).collect();
        let file =
            Self { vertices, triangles: (0..surface.triangles.len() as u32).collect(), count: surface.points.len() };
        let span = graph.span(&file.vertices);
        if span <= NEAR * graph.neighbour.len() {
            return file;
        }
        let layers = graph.layers(&file.vertices);
        if span < WORTH * graph.span(&layers) {
            return file;
        }
        let place = places(&layers, file.count);
        let mut triangles = file.triangles;
        let key = |t: &u32| {
            let mut at = surface.triangles[*t as usize].map(|v| place[v as usize]);
            at.sort_unstable();
            at
        };
        triangles.sort_by_cached_key(key);
        Self { vertices: layers, triangles, count: file.count }
    }

    /// The same, and behind it what a blade has added to a mesh.
    pub fn and_more(&self, surface: &Surface) -> Self {
        let mut used = vec![false; surface.points.len()];
        surface.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        let more = (self.count..surface.points.len()).filter(|v| used[*v]).map(|v| v as u32);
        let triangles = self.triangles.len() as u32..surface.triangles.len() as u32;
        Self {
            vertices: self.vertices.iter().copied().chain(more).collect(),
            triangles: self.triangles.iter().copied().chain(triangles).collect(),
            count: surface.points.len(),
        }
    }
}

/// Where each of `count` is in a list, or `NONE`.
pub fn places(list: &[u32], count: usize) -> Vec<u32> {
    let mut place = vec![NONE; count];
    list.iter().zip(0..).for_each(|(of, at)| place[*of as usize] = at);
    place
}

/// Neighbours of each vertex, twice where two triangles join them.
struct Graph {
    start: Vec<u32>,
    neighbour: Vec<u32>,
}

impl Graph {
    fn new(surface: &Surface) -> Self {
        let mut start = vec![0_u32; surface.points.len() + 1];
        surface.triangles.iter().flatten().for_each(|v| start[*v as usize + 1] += 2);
        (1..start.len()).for_each(|v| start[v] += start[v - 1]);
        let (mut next, mut neighbour) = (start.clone(), vec![0; 6 * surface.triangles.len()]);
        for &[a, b, c] in &surface.triangles {
            for (of, ends) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let at = next[of as usize] as usize;
                neighbour[at..at + 2].copy_from_slice(&ends);
                next[of as usize] += 2;
            }
        }
        Self { start, neighbour }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        &self.neighbour[self.start[vertex as usize] as usize..self.start[vertex as usize + 1] as usize]
    }

    /// How far the numbers of neighbours are from each other, added up.
    fn span(&self, vertices: &[u32]) -> usize {
        let place = places(vertices, self.start.len() - 1);
        let of = |v: u32| self.of(v).iter().map(move |w| (v, *w));
        vertices.iter().flat_map(|v| of(*v)).map(|(v, w)| place[v as usize].abs_diff(place[w as usize]) as usize).sum()
    }

    /// Each part of the mesh layer by layer from one of its ends, in reverse.
    fn layers(&self, vertices: &[u32]) -> Vec<u32> {
        let mut met = vec![false; self.start.len() - 1];
        let mut out = Vec::with_capacity(vertices.len());
        for &first in vertices {
            if met[first as usize] {
                continue;
            }
            // The last of the layers around any vertex is at an end; around that, at the other.
            let begin = out.len();
            let mut from = first;
            for _ in 0..2 {
                self.spread(from, &mut met, &mut out);
                from = out[out.len() - 1];
                out.drain(begin..).for_each(|v| met[v as usize] = false);
            }
            self.spread(from, &mut met, &mut out);
        }
        out.reverse();
        out
    }

    /// Appends what is connected with a vertex, nearest first, those with few neighbours before others.
    fn spread(&self, from: u32, met: &mut [bool], out: &mut Vec<u32>) {
        let mut at = out.len();
        met[from as usize] = true;
        out.push(from);
        while at < out.len() {
            let begin = out.len();
            for &next in self.of(out[at]) {
                if !std::mem::replace(&mut met[next as usize], true) {
                    out.push(next);
                }
            }
            out[begin..].sort_by_key(|v| self.of(*v).len());
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::geometry::Vec3;

    /// A sheet of `n` by `n` vertices, numbered by `number`, and one vertex that nothing uses.
    fn sheet(n: u32, number: impl Fn(u32) -> u32) -> Surface {
        let at = |x: u32, y: u32| number(n * y + x);
        let cells = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (x, y)));
        let halves = |(x, y)| [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]];
        let triangles = cells.flat_map(halves).collect();
        Surface { points: vec![Vec3::zeros(); (n * n + 1) as usize], triangles, ..Surface::default() }
    }

    #[test]
    fn what_a_file_has_in_order_stays() {
        let order = Order::of(&sheet(20, |v| v));
        assert_eq!((order.vertices, order.triangles), ((0..400).collect(), (0..722).collect()));
        // With 36 vertices none is far from any other.
        let order = Order::of(&sheet(6, |v| v * 5 % 36));
        assert_eq!((order.vertices, order.triangles), ((0..36).collect(), (0..50).collect()));
    }

    #[test]
    fn neighbours_get_numbers_that_are_near_and_each_has_its_own() {
        let (n, shuffled) = (20, sheet(20, |v| v * 163 % 400));
        let order = Order::of(&shuffled);
        let mut sorted = order.clone();
        sorted.vertices.sort_unstable();
        sorted.triangles.sort_unstable();
        assert_eq!((sorted.vertices, sorted.triangles), ((0..400).collect(), (0..722).collect()));
        let place = places(&order.vertices, 401);
        assert_eq!(place[400], NONE);
        for [a, b, c] in shuffled.triangles.iter().map(|t| t.map(|v| place[v as usize])) {
            assert!(a.abs_diff(b).max(b.abs_diff(c)).max(c.abs_diff(a)) <= 2 * n, "{a} {b} {c}");
        }
        let first = |t: &u32| shuffled.triangles[*t as usize].map(|v| place[v as usize]).into_iter().min();
        assert!(order.triangles.is_sorted_by_key(first));
    }

    #[test]
    fn what_is_added_comes_last() {
        let (mut surface, order) = (sheet(20, |v| v * 163 % 400), Order::of(&sheet(20, |v| v * 163 % 400)));
        assert_eq!(order.and_more(&surface).vertices, order.vertices);
        surface.points.extend([Vec3::zeros(); 3]);
        surface.triangles.push([401, 403, 7]);
        let more = order.and_more(&surface);
        assert_eq!((&more.vertices[..400], &more.vertices[400..]), (&order.vertices[..], &[401, 403][..]));
        assert_eq!((&more.triangles[..722], &more.triangles[722..]), (&order.triangles[..], &[722][..]));
    }
}
