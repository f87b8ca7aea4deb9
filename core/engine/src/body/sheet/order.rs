//! Order of the nodes and elements of a sheet: that of the file, or reverse Cuthill-McKee.
//!
//! A step reads the neighbours of a node together with it, and divides elements into chunks that share few nodes. Both are fast only if the
//! numbers of neighbours are close to each other. Where the numbers in the file are far from that, vertices are numbered by the reverse
//! Cuthill-McKee algorithm (Cuthill and McKee 1969, George 1971), and triangles in the order of their nodes.

use super::NONE;
use pliant_mesh::Surface;

/// Mean difference between the numbers of neighbours up to which the order of the file is kept.
const SMALL_SPAN: usize = 64;
/// Factor by which another order must reduce that difference to be used.
const MIN_IMPROVEMENT: usize = 4;

/// The order in which vertices are numbered as nodes, and triangles as elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// Vertices that triangles use, by node.
    pub vertices: Vec<u32>,
    /// Triangles, by element.
    pub triangles: Vec<u32>,
    /// Number of vertices of the mesh, used or not.
    count: usize,
}

impl Order {
    /// The order for a mesh: that of the file unless reverse Cuthill-McKee is much better.
    pub fn of(surface: &Surface) -> Self {
        let graph = Graph::new(surface);
        let vertices: Vec<u32> = (0..surface.points.len() as u32).filter(|v| !graph.of(*v).is_empty()).collect();
        let file =
            Self { vertices, triangles: (0..surface.triangles.len() as u32).collect(), count: surface.points.len() };
        let span = graph.span(&file.vertices);
        if span <= SMALL_SPAN * graph.neighbour.len() {
            return file;
        }
        let vertices = graph.reverse_cuthill_mckee(&file.vertices);
        if span < MIN_IMPROVEMENT * graph.span(&vertices) {
            return file;
        }
        let node_of = inverse(&vertices, file.count);
        let mut triangles = file.triangles;
        let key = |t: &u32| {
            let mut nodes = surface.triangles[*t as usize].map(|v| node_of[v as usize]);
            nodes.sort_unstable();
            nodes
        };
        triangles.sort_by_cached_key(key);
        Self { vertices, triangles, count: file.count }
    }

    /// This order, extended to `surface`, with the vertices of a part of it and its triangles, under the numbers that `triangle` gives them.
    pub fn of_part(
        &self,
        surface: &Surface,
        owns: impl Fn(u32) -> bool,
        triangle: impl Fn(u32) -> Option<u32>,
    ) -> Self {
        let Self { vertices, triangles, count } = self.extended(surface);
        Self {
            vertices: vertices.into_iter().filter(|vertex| owns(*vertex)).collect(),
            triangles: triangles.into_iter().filter_map(triangle).collect(),
            count,
        }
    }

    /// This order with the vertices and triangles that cuts have added to the mesh appended.
    pub fn extended(&self, surface: &Surface) -> Self {
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

/// The index of each number below `count` in a list, or [`NONE`]: the inverse of a permutation.
pub fn inverse(list: &[u32], count: usize) -> Vec<u32> {
    let mut index = vec![NONE; count];
    list.iter().zip(0..).for_each(|(of, at)| index[*of as usize] = at);
    index
}

/// Neighbours of each vertex in CSR form; a neighbour is listed once for each triangle that contains both.
struct Graph {
    /// Start of the neighbours of each vertex (n + 1).
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

    /// Neighbours of a vertex.
    fn of(&self, vertex: u32) -> &[u32] {
        &self.neighbour[self.start[vertex as usize] as usize..self.start[vertex as usize + 1] as usize]
    }

    /// Sum over all neighbours of the difference between their numbers, if `vertices` are numbered in this order.
    fn span(&self, vertices: &[u32]) -> usize {
        let number = inverse(vertices, self.start.len() - 1);
        let of = |v: u32| self.of(v).iter().map(move |w| (v, *w));
        vertices
            .iter()
            .flat_map(|v| of(*v))
            .map(|(v, w)| number[v as usize].abs_diff(number[w as usize]) as usize)
            .sum()
    }

    /// Reverse Cuthill-McKee order of `vertices`, connected part by part.
    fn reverse_cuthill_mckee(&self, vertices: &[u32]) -> Vec<u32> {
        let mut visited = vec![false; self.start.len() - 1];
        let mut out = Vec::with_capacity(vertices.len());
        for &first in vertices {
            if visited[first as usize] {
                continue;
            }
            // A pseudo-peripheral vertex as the start: the last one of a breadth-first search, twice (George and Liu 1979).
            let begin = out.len();
            let mut from = first;
            for _ in 0..2 {
                self.breadth_first(from, &mut visited, &mut out);
                from = out[out.len() - 1];
                out.drain(begin..).for_each(|v| visited[v as usize] = false);
            }
            self.breadth_first(from, &mut visited, &mut out);
        }
        out.reverse();
        out
    }

    /// Appends the vertices connected with `from` in breadth-first order; neighbours of a vertex by ascending degree.
    fn breadth_first(&self, from: u32, visited: &mut [bool], out: &mut Vec<u32>) {
        let mut at = out.len();
        visited[from as usize] = true;
        out.push(from);
        while at < out.len() {
            let begin = out.len();
            for &next in self.of(out[at]) {
                if !std::mem::replace(&mut visited[next as usize], true) {
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
    fn a_good_order_of_the_file_is_kept() {
        let order = Order::of(&sheet(20, |v| v));
        assert_eq!((order.vertices, order.triangles), ((0..400).collect(), (0..722).collect()));
        // With 36 vertices none is far from any other.
        let order = Order::of(&sheet(6, |v| v * 5 % 36));
        assert_eq!((order.vertices, order.triangles), ((0..36).collect(), (0..50).collect()));
    }

    #[test]
    fn neighbours_get_close_numbers() {
        let (n, shuffled) = (20, sheet(20, |v| v * 163 % 400));
        let order = Order::of(&shuffled);
        let mut sorted = order.clone();
        sorted.vertices.sort_unstable();
        sorted.triangles.sort_unstable();
        assert_eq!((sorted.vertices, sorted.triangles), ((0..400).collect(), (0..722).collect()));
        let place = inverse(&order.vertices, 401);
        assert_eq!(place[400], NONE);
        for [a, b, c] in shuffled.triangles.iter().map(|t| t.map(|v| place[v as usize])) {
            assert!(a.abs_diff(b).max(b.abs_diff(c)).max(c.abs_diff(a)) <= 2 * n, "{a} {b} {c}");
        }
        let first = |t: &u32| shuffled.triangles[*t as usize].map(|v| place[v as usize]).into_iter().min();
        assert!(order.triangles.is_sorted_by_key(first));
    }

    #[test]
    fn added_vertices_and_triangles_come_last() {
        let (mut surface, order) = (sheet(20, |v| v * 163 % 400), Order::of(&sheet(20, |v| v * 163 % 400)));
        assert_eq!(order.extended(&surface).vertices, order.vertices);
        surface.points.extend([Vec3::zeros(); 3]);
        surface.triangles.push([401, 403, 7]);
        let more = order.extended(&surface);
        assert_eq!((&more.vertices[..400], &more.vertices[400..]), (&order.vertices[..], &[401, 403][..]));
        assert_eq!((&more.triangles[..722], &more.triangles[722..]), (&order.triangles[..], &[722][..]));
    }
}
