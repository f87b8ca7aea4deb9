//! Edges and their adjacent triangles.

/// A side of a triangle: its use of an edge, with a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Index of the triangle the side belongs to.
    pub triangle: u32,
    /// Corner (0 to 2) at which the side starts; it ends at the next corner.
    pub corner: u8,
    /// Whether it leads from the lower vertex of the edge to the higher.
    pub upward: bool,
}

/// All edges of a set of triangles, each once, in ascending order of their vertices.
#[derive(Clone, Debug, Default)]
pub struct EdgeTable {
    vertices: Vec<[u32; 2]>, // lower, higher (e x 2)
    start: Vec<u32>,         // first side of each edge, then 3 m (e + 1)
    sides: Vec<Side>,        // edge after edge, triangles ascending (3 m)
}

impl EdgeTable {
    /// The edges of `triangles` (m x 3).
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        // A counting sort by the lower vertex leaves few sides to be sorted for each vertex.
        let vertex_count = triangles.iter().flatten().max().map_or(0, |&vertex| vertex as usize + 1);
        let mut bucket = vec![0_u32; vertex_count + 1];
        for (low, _, _) in all_sides(triangles) {
            bucket[low as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            bucket[vertex + 1] += bucket[vertex];
        }
        let mut fill = bucket.clone();
        let mut sorted = vec![(0, Side { triangle: 0, corner: 0, upward: false }); 3 * triangles.len()];
        for (low, high, side) in all_sides(triangles) {
            sorted[fill[low as usize] as usize] = (high, side);
            fill[low as usize] += 1;
        }
        let mut table = Self::default();
        for low in 0..vertex_count {
            let of_low = &mut sorted[bucket[low] as usize..bucket[low + 1] as usize];
            of_low.sort_by_key(|&(high, _)| high);
            for (at, &(high, _)) in of_low.iter().enumerate() {
                if at == 0 || of_low[at - 1].0 != high {
                    table.vertices.push([low as u32, high]);
                    table.start.push(bucket[low] + at as u32);
                }
            }
        }
        table.start.push(sorted.len() as u32);
        table.sides = sorted.into_iter().map(|(_, side)| side).collect();
        table
    }

    /// Number of edges, e.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there is no edge.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Lower and higher vertex of each edge (e x 2).
    pub fn vertices(&self) -> &[[u32; 2]] {
        &self.vertices
    }

    /// The sides on an edge: one on a border, two in the interior, more on a non-manifold edge.
    ///
    /// # Panics
    /// If `edge` is not below [`EdgeTable::len`].
    pub fn sides(&self, edge: usize) -> &[Side] {
        &self.sides[self.start[edge] as usize..self.start[edge + 1] as usize]
    }

    /// All edges: the vertices, lower first, and the sides on the edge.
    pub fn iter(&self) -> impl Iterator<Item = ([u32; 2], &[Side])> {
        self.vertices.iter().enumerate().map(|(edge, &vertices)| (vertices, self.sides(edge)))
    }
}

/// Lower vertex, higher vertex and side, triangle after triangle.
fn all_sides(triangles: &[[u32; 3]]) -> impl Iterator<Item = (u32, u32, Side)> {
    triangles.iter().enumerate().flat_map(|(index, triangle)| {
        [0, 1, 2].map(|corner| {
            let (from, to) = (triangle[corner], triangle[(corner + 1) % 3]);
            let side = Side { triangle: index as u32, corner: corner as u8, upward: from < to };
            (from.min(to), from.max(to), side)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_and_their_shared_edge() {
        let table = EdgeTable::new(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(table.vertices(), [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]);
        let sides = table.sides(2);
        assert_eq!(sides[0], Side { triangle: 0, corner: 1, upward: true });
        assert_eq!(sides[1], Side { triangle: 1, corner: 0, upward: false });
        assert!(table.iter().filter(|(_, sides)| sides.len() == 1).count() == 4);
    }

    #[test]
    fn agrees_with_a_sorted_list() {
        let mut random = crate::testing::Random(5);
        let triangles: Vec<[u32; 3]> = (0..300).map(|_| [0; 3].map(|_| random.below(50) as u32)).collect();
        let mut expected: Vec<_> = all_sides(&triangles).map(|(low, high, _)| [low, high]).collect();
        expected.sort_unstable();
        let table = EdgeTable::new(&triangles);
        let found: Vec<_> = table.iter().flat_map(|(edge, sides)| vec![edge; sides.len()]).collect();
        assert_eq!(found, expected);
        assert!(EdgeTable::new(&[]).is_empty());
    }
}
