//! Weights of elements whose corners are weighted sums of nodes, for quadratic tetrahedra.
//!
//! At an integration point q of a quadratic tetrahedron the map from its barycentric coordinates to positions has an affine tangent. A linear tetrahedron
//! with corners `x(q) + s (dx/dxi) (xi_j - q)`, j = 0..3, has the deformation gradient of the point, and with `s^3` equal to the point's share of the volume its
//! volume at rest is the weight of the point. So the energy of a quadratic tetrahedron is a sum over linear ones, which every material knows. Their corners are
//! sums of the ten nodes with weights that are the same for all elements.
//!
//! A rule of four points is exact for polynomials of degree 2, which suffices where edges are straight. Where edges are curved the gradients of the volume by
//! the nodes have degree 3, so eight points are taken: otherwise the patch test fails there.

/// Nodes of a quadratic tetrahedron: its corners, and the middles of the edges 01, 12, 02, 03, 13 and 23.
pub(super) const NODES: usize = 10;

/// Corners of the elements of a material at a stencil of nodes, as weighted sums of the nodes.
#[derive(Debug)]
pub struct CornerWeights {
    /// The elements of a stencil.
    pub(super) parts: &'static [Part],
}

/// Weights of one element of a stencil.
#[derive(Debug)]
pub(super) struct Part {
    /// Weight of each node in each corner (4 x 10, padded with zeros to 12).
    pub by_corner: [[f64; 12]; 4],
    /// Weight of each node in each corner, by node (10 x 4).
    pub by_node: [[f64; 4]; NODES],
}

/// Ends of the edges whose middles are nodes 4 to 9.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Barycentric coordinate of a point of the four-point rule that is the largest one, `(5 + 3 sqrt 5) / 20`; the others are equal (Stroud 1971, T3:2-1).
const FOUR: f64 = 0.585_410_196_624_968_5;
/// Largest barycentric coordinate of the four outer points of the eight-point rule, and the least of the four inner ones; the others are equal. All
/// weights are equal, and the two numbers are those with which polynomials of degree 3 are exact.
const EIGHT_OUTER: f64 = 1.0 - 3.0 * 0.112_956_794_512_511_03;
const EIGHT_INNER: f64 = 1.0 - 3.0 * 0.328_861_649_930_202_9;
/// Cube root of a quarter: edge of a tetrahedron over that of one with four times its volume.
const CUBE_ROOT_OF_QUARTER: f64 = 0.629_960_524_947_436_6;

static FOUR_POINTS: [Part; 4] = [
    Part::at(0, FOUR, CUBE_ROOT_OF_QUARTER),
    Part::at(1, FOUR, CUBE_ROOT_OF_QUARTER),
    Part::at(2, FOUR, CUBE_ROOT_OF_QUARTER),
    Part::at(3, FOUR, CUBE_ROOT_OF_QUARTER),
];

static EIGHT_POINTS: [Part; 8] = [
    Part::at(0, EIGHT_OUTER, 0.5),
    Part::at(1, EIGHT_OUTER, 0.5),
    Part::at(2, EIGHT_OUTER, 0.5),
    Part::at(3, EIGHT_OUTER, 0.5),
    Part::at(0, EIGHT_INNER, 0.5),
    Part::at(1, EIGHT_INNER, 0.5),
    Part::at(2, EIGHT_INNER, 0.5),
    Part::at(3, EIGHT_INNER, 0.5),
];

static STRAIGHT: CornerWeights = CornerWeights { parts: &FOUR_POINTS };
static CURVED: CornerWeights = CornerWeights { parts: &EIGHT_POINTS };

impl CornerWeights {
    /// Four elements of a quadratic tetrahedron with straight edges; the i-th is nearest to corner i.
    pub fn straight_tetrahedra() -> &'static Self {
        &STRAIGHT
    }

    /// Eight elements of a quadratic tetrahedron with curved edges: four nearest to the corners, and four nearest to the middles of the faces opposite
    /// to them.
    pub fn curved_tetrahedra() -> &'static Self {
        &CURVED
    }

    /// Number of elements of a stencil.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Pairs of nodes that share an edge of the eight linear parts of a quadratic tetrahedron, in both directions: a corner and the middle of an edge that ends
    /// there, or the middles of edges that meet.
    pub(crate) fn near_pairs() -> impl Iterator<Item = [usize; 2]> {
        let corners_of = |node: usize| if node < 4 { vec![node] } else { EDGES[node - 4].to_vec() };
        let is_near = move |[a, b]: &[usize; 2]| {
            let common = corners_of(*a).into_iter().filter(|corner| corners_of(*b).contains(corner)).count();
            a != b && common == 1
        };
        (0..NODES).flat_map(|a| (0..NODES).map(move |b| [a, b])).filter(is_near)
    }

    /// Share of the mass of a quadratic tetrahedron at each of its nodes: the diagonal of its consistent mass matrix, scaled to the mass (Hinton, Rock
    /// and Zienkiewicz 1976), for constant density and straight edges. All are positive, while sums of rows are negative at corners.
    pub const MASS_SHARES: [f64; NODES] = {
        let (corner, middle) = (1.0 / 36.0, 4.0 / 27.0);
        [corner, corner, corner, corner, middle, middle, middle, middle, middle, middle]
    };
}

/// Shape functions of the nodes at a place in barycentric coordinates.
const fn shape_functions(place: [f64; 4]) -> [f64; NODES] {
    let mut values = [0.0; NODES];
    let mut corner = 0;
    while corner < 4 {
        values[corner] = place[corner] * (2.0 * place[corner] - 1.0);
        corner += 1;
    }
    let mut edge = 0;
    while edge < 6 {
        let [a, b] = EDGES[edge];
        values[4 + edge] = 4.0 * place[a] * place[b];
        edge += 1;
    }
    values
}

/// Derivatives of the shape functions of the nodes by the four barycentric coordinates.
const fn derivatives(place: [f64; 4]) -> [[f64; 4]; NODES] {
    let mut slopes = [[0.0; 4]; NODES];
    let mut corner = 0;
    while corner < 4 {
        slopes[corner][corner] = 4.0 * place[corner] - 1.0;
        corner += 1;
    }
    let mut edge = 0;
    while edge < 6 {
        let [a, b] = EDGES[edge];
        slopes[4 + edge][a] = 4.0 * place[b];
        slopes[4 + edge][b] = 4.0 * place[a];
        edge += 1;
    }
    slopes
}

impl Part {
    /// The element of the point whose barycentric coordinate number `of` is `own`, the others being equal, with edges `scale` times those of the tangent.
    const fn at(of: usize, own: f64, scale: f64) -> Self {
        let other = (1.0 - own) / 3.0;
        let mut place = [other; 4];
        place[of] = own;
        let (values, slopes) = (shape_functions(place), derivatives(place));
        let mut part = Self { by_corner: [[0.0; 12]; 4], by_node: [[0.0; 4]; NODES] };
        let mut node = 0;
        while node < NODES {
            let mut corner = 0;
            while corner < 4 {
                // The derivative along the way from the point to the corner.
                let mut along = 0.0;
                let mut axis = 0;
                while axis < 4 {
                    let way = if axis == corner { 1.0 - place[axis] } else { -place[axis] };
                    along += slopes[node][axis] * way;
                    axis += 1;
                }
                let weight = values[node] + scale * along;
                part.by_corner[corner][node] = weight;
                part.by_node[node][corner] = weight;
                corner += 1;
            }
            node += 1;
        }
        part
    }
}
