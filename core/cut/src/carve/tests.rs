//! What is carved of noisy surfaces: closed, of the right volume, with nothing lost and nothing doubled.

use super::*;
use crate::CutMesh;
use pliant_mesh::testing::{Random, scan};
use pliant_mesh::tetrahedra::{FACES, NO_NEIGHBOUR, neighbours};
use pliant_mesh::{Placement, Surface};

/// Cubes of six tetrahedra around a box.
struct Lattice {
    edge: f64,
    nodes: Vec<Vec3>,
    tetrahedra: Vec<[u32; 4]>,
    neighbours: Vec<[u32; 4]>,
}

/// Cubes around a surface, `across` of them along its longest edge. `is_aligned` puts planes of nodes into its lowest corner.
fn lattice(surface: &Surface, across: u32, is_aligned: bool) -> Lattice {
    let bounds = surface.bounds();
    let edge = bounds.longest_edge() / f64::from(across);
    let margin = if is_aligned { 1.0 } else { 1.3 };
    let origin = bounds.min - Vec3::repeat(margin * edge);
    let count = [0, 1, 2].map(|i| ((bounds.max[i] - origin[i]) / edge).ceil() as u32 + 2);
    let node = |i: u32, j: u32, k: u32| (i * count[1] + j) * count[2] + k;
    let mut nodes = Vec::new();
    let mut tetrahedra = Vec::new();
    for (i, j, k) in (0..count[0]).flat_map(|i| (0..count[1]).flat_map(move |j| (0..count[2]).map(move |k| (i, j, k))))
    {
        let place = origin + edge * Vec3::new(f64::from(i), f64::from(j), f64::from(k));
        nodes.push(jitter(place, nodes.len() as u64, edge));
        if i + 1 == count[0] || j + 1 == count[1] || k + 1 == count[2] {
            continue;
        }
        for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]] {
            let mut at = [i, j, k];
            let mut corners = [node(i, j, k); 4];
            for (corner, axis) in corners[1..].iter_mut().zip([a, b, c]) {
                at[axis] += 1;
                *corner = node(at[0], at[1], at[2]);
            }
            if [[0, 1, 2], [1, 2, 0], [2, 0, 1]].contains(&[a, b, c]) {
                corners.swap(2, 3);
            }
            // With positive volume: the face opposite to a corner is counter-clockwise from outside.
            corners.swap(2, 3);
            tetrahedra.push(corners);
        }
    }
    let neighbours = neighbours(&tetrahedra);
    Lattice { edge, nodes, tetrahedra, neighbours }
}

/// What is left of a surface without tetrahedra.
fn carve(surface: &Surface, mesh: &CutMesh, lattice: &Lattice, gone: &[bool]) -> Carved {
    let mut faces = Vec::new();
    for (t, others) in lattice.neighbours.iter().enumerate().filter(|(t, _)| !gone[*t]) {
        for (face, other) in FACES.iter().zip(others) {
            if *other != NO_NEIGHBOUR && gone[*other as usize] {
                faces.push(face.map(|corner| lattice.tetrahedra[t][corner]));
            }
        }
    }
    let carving = Carving {
        points: &surface.points,
        triangles: &surface.triangles,
        nodes: &lattice.nodes,
        faces: &faces,
        spacing: lattice.edge,
    };
    let is_inside = |node: u32| mesh.encloses(lattice.nodes[node as usize]);
    let is_gone = |t: u32| {
        let place = surface.points[surface.triangles[t as usize][0] as usize];
        let around = lattice.tetrahedra.iter().position(|nodes| {
            let corners = nodes.map(|n| lattice.nodes[n as usize]);
            FACES.iter().all(|face| {
                let [a, b, c] = face.map(|corner| corners[corner]);
                (b - a).cross(&(c - a)).dot(&(place - a)) <= 0.0
            })
        });
        gone[around.expect("in the lattice")]
    };
    carving.carve(is_inside, is_gone)
}

/// Corners of all triangles of what is left.
fn triangles(surface: &Surface, carved: &Carved) -> Vec<[Corner; 3]> {
    let whole = carved.left.iter().zip(&surface.triangles).filter(|(left, _)| **left == Left::Whole);
    let whole = whole.map(|(_, corners)| corners.map(Corner::Vertex));
    whole.chain(carved.pieces.iter().chain(&carved.faces).map(|(_, corners)| *corners)).collect()
}

/// Number of directed edges without a partner.
fn open(triangles: &[[Corner; 3]]) -> usize {
    let mut count: BTreeMap<[Corner; 2], i32> = BTreeMap::new();
    for t in triangles {
        (0..3).for_each(|i| *count.entry([t[i], t[(i + 1) % 3]]).or_default() += 1);
    }
    count.iter().filter(|([a, b], n)| count.get(&[*b, *a]) != Some(n)).count()
}

/// Volume within triangles, m^3.
fn volume(surface: &Surface, lattice: &Lattice, carved: &Carved) -> f64 {
    let at = |corner: Corner| match corner {
        Corner::Vertex(v) => surface.points[v as usize],
        Corner::Node(n) => lattice.nodes[n as usize],
        Corner::Crossing(c) => {
            let Crossing { nodes, node_weights, .. } = carved.crossings[c as usize];
            nodes.iter().zip(node_weights).map(|(n, w)| w * lattice.nodes[*n as usize]).sum()
        }
    };
    triangles(surface, carved).iter().map(|t| t.map(at)).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

#[test]
fn what_is_left_and_what_has_gone_are_closed_and_add_up() {
    for seed in 0..24 {
        let mut random = Random(seed);
        let document = scan((seed % 3) as u32, 300 + 100 * (seed as u32 % 7), 0, seed).document();
        let surface = Surface::from_document(&document);
        let mesh = CutMesh::new(&document, &Placement::default());
        let lattice = lattice(&surface, 3 + random.below(8) as u32, seed % 2 == 0);
        let bounds = surface.bounds();
        let size = bounds.max - bounds.min;
        let balls: Vec<(Vec3, f64)> = (0..1 + random.below(4))
            .map(|_| {
                let centre = bounds.min + size.component_mul(&Vec3::from_fn(|_, _| random.unit()));
                (centre, 0.4 * random.unit() * bounds.longest_edge())
            })
            .collect();
        let is_in = |nodes: &[u32; 4]| {
            let middle = nodes.iter().map(|n| lattice.nodes[*n as usize]).sum::<Vec3>() / 4.0;
            balls.iter().any(|(centre, radius)| (middle - centre).norm() < *radius)
        };
        // Balls, and now and then single tetrahedra.
        let gone: Vec<bool> = lattice.tetrahedra.iter().map(|t| is_in(t) != (random.below(40) == 0)).collect();
        let others: Vec<bool> = gone.iter().map(|gone| !gone).collect();
        let whole = triangles_volume(&surface);
        let mut sum = 0.0;
        for gone in [&gone, &others] {
            let carved = carve(&surface, &mesh, &lattice, gone);
            assert_eq!(carved.doubtful, 0, "{seed}");
            assert_eq!(open(&triangles(&surface, &carved)), 0, "{seed}: closed");
            sum += volume(&surface, &lattice, &carved);
            // By vertices of the surface and by nodes a crossing is at one place.
            for crossing in &carved.crossings {
                let by_nodes: Vec3 =
                    crossing.nodes.iter().zip(crossing.node_weights).map(|(n, w)| w * lattice.nodes[*n as usize]).sum();
                let of_surface = crossing.vertices.iter().zip(crossing.vertex_weights);
                let by_vertices: Vec3 = of_surface.map(|(v, w)| w * surface.points[*v as usize]).sum();
                assert!((by_nodes - by_vertices).norm() < 1e-9 * bounds.longest_edge(), "{seed}: {crossing:?}");
            }
        }
        assert!((sum / whole - 1.0).abs() < 1e-9, "{seed}: {sum} of {whole} m^3");
    }
}

/// Volume of a surface, m^3.
fn triangles_volume(surface: &Surface) -> f64 {
    let corners = surface.triangles.iter().map(|t| t.map(|v| surface.points[v as usize]));
    corners.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}
