//! The tetrahedra of a file as cells of a lattice.
//!
//! A lattice knows cells of eight corners and weights at them. A tetrahedron is such a cell whose last four corners repeat others and have no weight; the
//! first four have its barycentric coordinates. So a surface, contact, fields and paint need not know which cells they are in.
//!
//! The cells of a quadratic tetrahedron are its eight parts, whose corners are its ten nodes: points inside follow the nodes around them linearly. Only elements
//! and masses are those of the whole.

use pliant_host::Region;
use pliant_mesh::geometry::TriangleTree;
use pliant_mesh::tetrahedra::PARTS;
use pliant_mesh::{Placement, Surface, TetMesh};
use pliant_plugin_api::abi::{self, Ball, Level};
use pliant_solver::{CornerWeights, Vec3};

/// How far a point may be outside of a tetrahedron and still be embedded in it, in barycentric coordinates: samples of a bent surface lie a little outside of it.
const BEYOND: f64 = 0.1;

/// Barycentric coordinates below which a point is on a face: far above their rounding, far below what can be seen.
const ROUNDING: f64 = 1e-10;

/// A tetrahedral mesh placed in the scene. Cell i is linear tetrahedron i of the mesh, node i its node i.
pub struct TetrahedralCells {
    mesh: TetMesh,
    /// Rest positions of the nodes, m (n x 3).
    rest: Vec<Vec3>,
    /// m^3, volume of each cell (c)
    volume: Vec<f64>,
    /// m^3, volume of each quadratic tetrahedron (q)
    quadratic_volume: Vec<f64>,
    /// Boxes around the tetrahedra with [`BEYOND`], in the form of triangles from the least to the greatest corner.
    tree: TriangleTree,
    /// Vertices of the surface, cell by cell.
    points: Vec<u32>,
    /// First of them in each cell (c + 1).
    starts: Vec<u32>,
    /// Whether each cell has a node of the surface (c).
    is_outer: Vec<bool>,
    facts: Level,
}

impl TetrahedralCells {
    /// The mesh in metres; `surface` is its placed boundary, whose vertices are those of [`TetMesh::vertices`].
    pub fn new(mesh: TetMesh, placement: &Placement, surface: &Surface) -> Self {
        let rest: Vec<Vec3> = mesh.points.iter().map(|point| placement.apply(*point)).collect();
        let volume: Vec<f64> = mesh.tetrahedra.iter().map(|nodes| TetMesh::six_volumes(&rest, *nodes) / 6.0).collect();
        let quadratic_volume = mesh.quadratic.iter().map(|nodes| TetMesh::quadratic_volume(&rest, nodes)).collect();
        let (mut corners, mut boxes, mut edges) = (Vec::new(), Vec::new(), 0.0);
        for nodes in &mesh.tetrahedra {
            let at = nodes.map(|node| rest[node as usize]);
            let centre = 0.25 * at.iter().sum::<Vec3>();
            // Barycentric coordinates of -BEYOND or more are those of a tetrahedron that is this much larger.
            let larger = at.map(|corner| centre + (1.0 + 4.0 * BEYOND) * (corner - centre));
            let least = larger.iter().fold(larger[0], |low, corner| low.inf(corner));
            let greatest = larger.iter().fold(larger[0], |high, corner| high.sup(corner));
            let first = corners.len() as u32;
            corners.extend([least, greatest]);
            boxes.push([first, first + 1, first + 1]);
            edges += [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
                .map(|[a, b]| (at[a] - at[b]).norm())
                .iter()
                .sum::<f64>();
        }
        let mut is_vertex = vec![false; rest.len()];
        mesh.vertices().iter().for_each(|node| is_vertex[*node as usize] = true);
        let is_outer: Vec<bool> =
            mesh.tetrahedra.iter().map(|nodes| nodes.iter().any(|node| is_vertex[*node as usize])).collect();
        let (count, outer) = (mesh.tetrahedra.len(), is_outer.iter().filter(|is| **is).count());
        let facts = Level {
            size: size_of::<Level>(),
            level: 1,
            cells_per_axis: 0,
            edge: edges / (6 * count) as f64,
            origin: surface.bounds().min.into(),
            surface_cells: outer as u64,
            inside_cells: (count - outer) as u64,
            nodes: rest.len() as u64,
        };
        let tree = TriangleTree::new(&corners, &boxes);
        let (points, starts) = (Vec::new(), Vec::new());
        let mut cells = Self { mesh, rest, volume, quadratic_volume, tree, points, starts, is_outer, facts };
        cells.embed_vertices(&surface.points);
        cells
    }

    /// Lists the vertices of the surface (m, v x 3) by cell.
    fn embed_vertices(&mut self, points: &[Vec3]) {
        // A vertex is a node, so a cell contains it.
        let cell_of: Vec<u32> = points.iter().map(|point| self.locate(*point).map_or(0, |(cell, _)| cell)).collect();
        self.points = (0..points.len() as u32).collect();
        self.points.sort_by_key(|vertex| cell_of[*vertex as usize]);
        let before = |cell: usize| self.points.partition_point(|vertex| (cell_of[*vertex as usize] as usize) < cell);
        self.starts = (0..=self.volume.len()).map(|cell| before(cell) as u32).collect();
    }

    /// The mesh as in the file.
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Displacement of each node from its place in the file, for nodes at `x` (m, n x 3) in a scene where the mesh is placed so: in file units and along the axes
    /// of the file (n x 3).
    pub fn displacements(&self, x: &[Vec3], placement: &Placement) -> Vec<Vec3> {
        let back = placement.rotation.inverse();
        x.iter().zip(&self.rest).map(|(x, rest)| back * ((x - rest) / placement.scale)).collect()
    }

    /// Number of cells, of nodes, and the mean edge (m), in the form of a level of a grid.
    pub fn facts(&self) -> Level {
        self.facts
    }

    /// Vertices of the surface, cell by cell.
    pub fn points(&self) -> &[u32] {
        &self.points
    }

    /// Vertices of the surface that are embedded in a cell.
    pub fn points_of(&self, cell: u32) -> &[u32] {
        &self.points[self.starts[cell as usize] as usize..self.starts[cell as usize + 1] as usize]
    }

    /// The cell that contains a rest position (m), with the barycentric coordinates there: of several the one in which the least coordinate is greatest, and of
    /// equal ones the first. `None` outside of all.
    pub fn locate(&self, point: Vec3) -> Option<(u32, [f64; 4])> {
        let mut best: Option<(f64, u32, [f64; 4])> = None;
        self.tree.near(point, 0.0, |cell| {
            let weights = self.weights_in(cell, point);
            let least = weights.into_iter().fold(f64::INFINITY, f64::min);
            let is_better = |(other, of, _): (f64, u32, _)| least > other || (least == other && cell < of);
            if least >= -BEYOND && best.is_none_or(is_better) {
                best = Some((least, cell, weights));
            }
        });
        best.map(|(_, cell, weights)| (cell, weights))
    }

    /// Barycentric coordinates of a rest position (m) in a cell.
    fn weights_in(&self, cell: u32, point: Vec3) -> [f64; 4] {
        let [a, b, c, d] = self.mesh.tetrahedra[cell as usize].map(|node| self.rest[node as usize]);
        let (u, v, w, p) = (b - a, c - a, d - a, point - a);
        let six_volumes = u.dot(&v.cross(&w));
        let [x, y, z] = [p.dot(&v.cross(&w)), p.dot(&w.cross(&u)), p.dot(&u.cross(&v))].map(|part| part / six_volumes);
        // At a node, on an edge or on a face the others have no weight at all, not one of rounding.
        let weights = [1.0 - x - y - z, x, y, z].map(|weight| if weight.abs() < ROUNDING { 0.0 } else { weight });
        let sum: f64 = weights.iter().sum();
        weights.map(|weight| weight / sum)
    }

    /// Cells, with the barycentric coordinates there, of rest positions (m, p x 3), as those of a grid: [`abi::NO_CELL`] and zeros outside of all cells.
    pub fn weights(&self, positions: &[[f64; 3]], cells: &mut [u64], weights: &mut [[f64; 8]]) {
        for ((position, cell), weights) in positions.iter().zip(cells).zip(weights) {
            (*cell, *weights) = (abi::NO_CELL, [0.0; 8]);
            if let Some((found, barycentric)) = self.locate((*position).into()) {
                *cell = found.into();
                weights[..4].copy_from_slice(&barycentric);
            }
        }
    }

    /// Cells whose boxes contain a rest position (m): at least those that have a node there.
    pub fn cells_at(&self, point: Vec3, mut visit: impl FnMut(u32)) {
        self.tree.near(point, 0.0, &mut visit);
    }

    /// Lists the cells that meet one of the `balls` and those in `listed` (ids, ascending), with their nodes.
    pub fn region(&self, balls: &[Ball], listed: &[u64], out: &mut Region) {
        out.clear();
        let is_whole = balls.iter().any(|ball| ball.radius == f64::INFINITY);
        let mut is_selected = vec![is_whole; self.volume.len()];
        for &cell in listed {
            is_selected[cell as usize] = true;
        }
        for ball in balls.iter().filter(|_| !is_whole) {
            self.tree.near(ball.centre.into(), ball.radius, |cell| is_selected[cell as usize] = true);
        }
        if !self.quadratic_volume.is_empty() {
            for parts in is_selected.chunks_exact_mut(PARTS) {
                parts.fill(parts.contains(&true));
            }
        }
        let (mut measure, mut is_used, mut is_border) =
            (vec![0.0; self.rest.len()], vec![false; self.rest.len()], vec![false; self.rest.len()]);
        for (nodes, (volume, is_selected)) in self.mesh.tetrahedra.iter().zip(self.volume.iter().zip(&is_selected)) {
            for node in nodes.map(|node| node as usize) {
                is_used[node] |= is_selected;
                is_border[node] |= !is_selected;
                measure[node] += if *is_selected { 0.25 * volume } else { 0.0 };
            }
        }
        if !self.quadratic_volume.is_empty() {
            measure.fill(0.0);
        }
        for (element, (nodes, volume)) in self.mesh.quadratic.iter().zip(&self.quadratic_volume).enumerate() {
            if is_selected[PARTS * element] {
                let shares = nodes.iter().zip(CornerWeights::MASS_SHARES);
                shares.for_each(|(node, share)| measure[*node as usize] += share * volume);
            }
        }
        let mut number = vec![0; self.rest.len()];
        for node in (0..self.rest.len()).filter(|node| is_used[*node]) {
            number[node] = out.node_id.len() as u32;
            out.node_id.push(node as u64);
            out.node_rest.push(self.rest[node].into());
            out.node_measure.push(measure[node]);
            out.node_border.push(u8::from(is_border[node]));
        }
        for cell in (0..self.volume.len()).filter(|cell| is_selected[*cell]) {
            let [a, b, c, d] = self.mesh.tetrahedra[cell].map(|node| number[node as usize]);
            out.cell_id.push(cell as u64);
            // Along the edges of a cube this order has all six edges of the tetrahedron, which viewers draw.
            out.cell_corners.push([a, b, c, d, d, c, d, d]);
            out.cell_points.push([self.starts[cell], self.starts[cell + 1]]);
            let state = if self.is_outer[cell] { abi::CELL_SURFACE } else { abi::CELL_INSIDE };
            out.cell_state.push(state as u8);
        }
        out.node_copy.resize(out.node_id.len(), 0);
        out.cell_fragment.resize(out.cell_id.len(), 0);
    }

    /// Volume whose mass a cell gives to each of its nodes in equal parts, m^3. Of a quadratic tetrahedron it is that of the whole for the parts at its corners,
    /// and zero for the others: each node has equal parts of the former alone.
    pub fn mass_volume(&self, cell: u32) -> f64 {
        match self.quadratic_volume.get(cell as usize / PARTS) {
            Some(volume) if (cell as usize % PARTS) < 4 => *volume,
            Some(_) => 0.0,
            None => self.volume[cell as usize],
        }
    }

    /// Weights of the nodes of quadratic tetrahedra in the corners of the elements that a material sees; `None` for linear tetrahedra.
    pub fn corner_weights(&self) -> Option<&'static CornerWeights> {
        match (self.mesh.quadratic.is_empty(), self.mesh.is_curved) {
            (true, _) => None,
            (false, true) => Some(CornerWeights::curved_tetrahedra()),
            (false, false) => Some(CornerWeights::straight_tetrahedra()),
        }
    }

    /// Estimate of the memory, bytes: the largest arrays.
    pub fn bytes(&self) -> usize {
        // Positions, numbers and tags of nodes; corners, volume, box and tag of cells.
        self.rest.len() * (24 + 24 + 8) + self.volume.len() * (16 + 8 + 8 + 96) + self.quadratic_volume.len() * (40 + 8)
    }
}
