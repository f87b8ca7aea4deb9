use super::*;
use crate::Surface;
use crate::testing::tetrahedra::{TetBox, TetFormat};

const FORMATS: [TetFormat; 7] = [
    TetFormat::Msh2,
    TetFormat::Msh2Binary,
    TetFormat::Msh4,
    TetFormat::Msh4Binary,
    TetFormat::Vtk,
    TetFormat::VtkBinary,
    TetFormat::Vtk5,
];

/// Linear tetrahedra, and quadratic ones with straight and with curved edges.
fn random_boxes(seed: u64) -> [TetBox; 3] {
    let linear = TetBox::random(seed);
    let straight = linear.quadratic();
    let curved = straight.curved(0.015, seed);
    [linear, straight, curved]
}

fn parse(bytes: &[u8]) -> Result<TetMesh, String> {
    TetMesh::parse(bytes, Path::new("test.msh")).map_err(|error| error.to_string())
}

#[test]
fn every_format_gives_the_same_mesh() {
    for made in (0..20).flat_map(random_boxes) {
        for format in FORMATS {
            let mesh = parse(&made.bytes(format)).unwrap();
            assert_eq!(mesh.points, made.points, "{format:?}");
            assert_eq!(mesh.quadratic, made.quadratic, "{format:?}");
            if made.quadratic.is_empty() {
                assert_eq!(mesh.tetrahedra, made.tetrahedra, "{format:?}");
            }
            assert_eq!(mesh.elements(), made.tetrahedra.len(), "{format:?}");
            let first = u64::from(!matches!(format, TetFormat::Vtk | TetFormat::VtkBinary | TetFormat::Vtk5));
            assert!(mesh.node_number.iter().copied().eq(first..first + made.points.len() as u64));
            let names: Vec<&str> = mesh.groups.iter().map(|group| group.name.as_str()).collect();
            let named = &["low end", "high end", "body"][..];
            assert_eq!(names, if first == 1 { named } else { &[] }, "{format:?}");
            assert!(!mesh.notes.iter().any(Note::is_doubtful), "{:?}", mesh.notes);
        }
    }
}

#[test]
fn the_boundary_is_closed_and_outward_and_bounds_the_volume() {
    for (seed, made) in (0..40).flat_map(|seed| random_boxes(seed).map(|made| (seed, made))) {
        let mesh = parse(&made.bytes(TetFormat::Msh4)).unwrap();
        let document = mesh.surface().unwrap();
        let surface = Surface::from_document(&document);
        assert!(surface.edges().iter().all(|(_, sides)| sides.len() == 2 && sides[0].upward != sides[1].upward));
        let volume: f64 = mesh.tetrahedra.iter().map(|t| TetMesh::six_volumes(&mesh.points, *t) / 6.0).sum();
        let exact: f64 = made.size.iter().product::<f64>() * f64::from(made.parts);
        assert!((volume / exact - 1.0).abs() < 1e-12 && (surface.volume() / exact - 1.0).abs() < 1e-12, "{seed}");
        for (vertex, node) in mesh.vertices().iter().enumerate() {
            assert_eq!(surface.points[vertex], mesh.points[*node as usize]);
        }
        let parts =
            mesh.notes.iter().find_map(|note| if let Note::Parts { count } = note { Some(*count) } else { None });
        assert_eq!(parts.unwrap_or(1), made.parts as usize);
        let low = mesh.group("low end").unwrap();
        assert!(low.nodes.iter().all(|node| mesh.points[*node as usize].x == 0.0) && low.kind() == "faces");
        let on_surface = document.faces_named("low end").unwrap();
        assert_eq!(on_surface.iter().filter(|is| **is).count(), low.faces.len());
        assert_eq!(mesh.group("body").unwrap().tetrahedra.len(), mesh.tetrahedra.len());
        let whole: f64 = mesh.quadratic.iter().map(|nodes| TetMesh::quadratic_volume(&mesh.points, nodes)).sum();
        assert!(mesh.quadratic.is_empty() || (whole / exact - 1.0).abs() < 1e-12, "{seed}: {whole}");
    }
}

#[test]
fn tetrahedra_listed_the_other_way_around_are_turned_and_noted() {
    let made = TetBox::random(3);
    let straight = parse(&made.bytes(TetFormat::Vtk)).unwrap();
    let mut turned = made.clone();
    turned.tetrahedra.iter_mut().step_by(2).for_each(|nodes| nodes.swap(0, 3));
    let mesh = parse(&turned.bytes(TetFormat::Vtk)).unwrap();
    let count = made.tetrahedra.len().div_ceil(2);
    assert!(matches!(mesh.notes[0], Note::Reoriented { count: n, first: 0, .. } if n == count), "{:?}", mesh.notes);
    assert!(mesh.tetrahedra.iter().all(|t| TetMesh::six_volumes(&mesh.points, *t) > 0.0));
    assert_eq!(mesh.surface().unwrap().face_count(), straight.surface().unwrap().face_count());
}

#[test]
fn quadratic_tetrahedra_listed_the_other_way_around_are_turned_and_noted() {
    let made = TetBox::random(3).quadratic().curved(0.01, 3);
    let straight = parse(&made.bytes(TetFormat::Vtk)).unwrap();
    let mut turned = made.clone();
    // Corners 0 and 1, and with them the middles of their edges to the others.
    turned.quadratic.iter_mut().step_by(2).for_each(|nodes| {
        nodes.swap(0, 1);
        nodes.swap(5, 6);
        nodes.swap(7, 8);
    });
    let mesh = parse(&turned.bytes(TetFormat::Vtk)).unwrap();
    let count = made.quadratic.len().div_ceil(2);
    assert!(matches!(mesh.notes[0], Note::Reoriented { count: n, first: 0, .. } if n == count), "{:?}", mesh.notes);
    let volume = |mesh: &TetMesh| -> f64 {
        mesh.quadratic.iter().map(|nodes| TetMesh::quadratic_volume(&mesh.points, nodes)).sum()
    };
    assert!((volume(&mesh) / volume(&straight) - 1.0).abs() < 1e-12);
    assert_eq!(mesh.surface().unwrap().face_count(), straight.surface().unwrap().face_count());
}

#[test]
fn the_parts_of_a_quadratic_tetrahedron_fill_it_and_each_is_at_its_place() {
    for seed in 0..10 {
        let mesh = parse(&TetBox::random(seed).quadratic().shuffled(seed).bytes(TetFormat::Vtk)).unwrap();
        assert!(!mesh.is_curved);
        for (nodes, parts) in mesh.quadratic.iter().zip(mesh.tetrahedra.as_chunks::<PARTS>().0) {
            let whole = TetMesh::six_volumes(&mesh.points, [nodes[0], nodes[1], nodes[2], nodes[3]]);
            let middle_of_face = |corner: usize| {
                let face = (0..4).filter(|other| *other != corner);
                face.map(|other| mesh.points[nodes[other] as usize]).sum::<Vec3>() / 3.0
            };
            for (place, part) in parts.iter().enumerate() {
                assert!((8.0 * TetMesh::six_volumes(&mesh.points, *part) / whole - 1.0).abs() < 1e-9);
                if place < 4 {
                    assert_eq!(part[place], nodes[place]);
                } else {
                    let face = part[1..].iter().map(|node| mesh.points[*node as usize]).sum::<Vec3>() / 3.0;
                    assert!((face - middle_of_face(place - 4)).norm() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn a_written_mesh_is_read_as_it_was() {
    for seed in 0..10 {
        for made in random_boxes(seed) {
            let mesh = parse(&made.bytes(TetFormat::Msh2)).unwrap();
            let mut out = Vec::new();
            mesh.write_vtk(&vec![Vec3::new(1.0, -2.5e-20, 1e300); mesh.points.len()], None, &mut out).unwrap();
            let again = parse(&out).unwrap();
            assert_eq!(
                (again.points, again.tetrahedra, again.quadratic),
                (mesh.points, mesh.tetrahedra, mesh.quadratic)
            );
        }
    }
}

/// One tetrahedron as version 2 with replaced parts: nodes, elements.
fn one(nodes: &str, elements: &str) -> String {
    format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n$EndNodes\n$Elements\n{elements}\n$EndElements\n")
}

const FOUR: &str = "4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1";
const TET: &str = "1\n7 4 0 1 2 3 4";

#[test]
fn what_is_not_allowed_is_named_with_its_line() {
    let five = "5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1";
    let vtk = |cells: &str| {
        format!(
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n{cells}"
        )
    };
    let cases = [
        (String::new(), "test.msh:1: the file ends where `$MeshFormat` is expected"),
        ("solid x\n".into(), "test.msh:1: the file begins with `solid`"),
        ("$MeshFormat\n4 0 8\n$EndMeshFormat\n".into(), "test.msh:2: Gmsh version 4; allowed: 2 to 2.2, and 4.1"),
        ("$MeshFormat\n2.2 0 4\n$EndMeshFormat\n".into(), "the size of numbers in bytes: `4`; allowed: 8"),
        ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n".into(), "test.msh:4: the file has no $Nodes"),
        (
            one("4\n1 0 0 0\n2 1 0 0\n3 0 nan 0\n4 0 0 1", TET),
            "test.msh:8: a coordinate of node 3: `nan`; allowed: a finite number",
        ),
        (one("4\n1 0 0 0\n2 1 0 1e999\n3 0 0 0\n4 0 0 1", TET), "test.msh:7: a coordinate of node 2: `1e999`"),
        (one("4\n1 0 0 0\n2 1 0 0\n2 0 1 0\n4 0 0 1", TET), "test.msh:8: node 2 is there twice"),
        (one("4\n1 0 0 0\n2 1 0 0\n3 0 1 0", TET), "the number of a node: `$EndNodes`"),
        (one("99999999999999\n1 0 0 0", TET), "the number of a node: `$EndNodes`"),
        (one("3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1", TET), "test.msh:9: the end of `$Nodes`: `4`"),
        (one(FOUR, "1\n7 4 0 1 2 3 5"), "test.msh:13: tetrahedron 7 has node 5, which is not there; allowed: 1 to 4"),
        (one(FOUR, "1\n7 4 0 1 2 3 3"), "test.msh:13: tetrahedron 7 has node 3 twice"),
        (one(FOUR, "1\n7 4 0 1 2 3 -4"), "a node of an element: `-4`; allowed: a whole number, 0 or more"),
        (one(FOUR, "1\n7 2 0 1 2 3"), "the file has no tetrahedra, but 4 nodes, 1 triangles; allowed: one at least"),
        (one(FOUR, "1\n7 999 0 1 2 3"), "test.msh:13: element 7 has type 999"),
        (
            one(FOUR, "1\n7 5 0 1 2 3 4 1 2 3 4"),
            "test.msh:13: element 7 is a hexahedron; allowed: tetrahedra of 4 or of 10 nodes; divide",
        ),
        (
            one(FOUR, &format!("1\n7 29 0{}", " 1".repeat(20))),
            "element 7 is a tetrahedron of 20 nodes; allowed: tetrahedra of 4 or of 10 nodes; export",
        ),
        (one(FOUR, "2\n7 4 0 1 2 3 4"), "the number of an element: `$EndElements`"),
        (
            one("4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 1e-9", TET),
            "test.msh:13: tetrahedron 7 is flat: six times its volume is",
        ),
        (one("4\n1 0 0 0\n2 1 0 0\n3 0 0 0\n4 0 0 1", TET), "is flat: six times its volume is 0.0e0 times"),
        (
            one(&five.replace("0 0 -1", "0.1 0.1 0.5"), "2\n7 4 0 1 2 3 4\n8 4 0 1 2 3 5"),
            "test.msh:15: tetrahedra 7 and 8 are on the same side",
        ),
        (one(FOUR, "2\n7 4 0 1 2 3 4\n8 4 0 1 2 3 4"), "tetrahedra 7 and 8 are on the same side"),
        (
            one(five, "3\n7 4 0 1 2 3 4\n8 4 0 1 2 3 5\n9 4 0 1 2 3 5"),
            "test.msh:15: tetrahedra 7, 8 and 9 have a face in common",
        ),
        (one(FOUR, TET).replace("$EndElements\n", ""), "the file ends where `$EndElements` is expected"),
        (one(FOUR, TET) + "$Nodes\n0\n$EndNodes\n", "the section $Nodes is there twice"),
        (one(FOUR, TET) + "$NodeData\n1\n", "the file ends where the name of an array is expected"),
        (one(FOUR, TET) + "$Periodic\n1\n", "the file ends where `$EndPeriodic` is expected"),
        (
            one(FOUR, TET).replace("$Elements", "$PhysicalNames\n1\n2 1 side\n$EndPhysicalNames\n$Elements"),
            "a physical name: `side`",
        ),
        (
            vtk("CELLS 1 5\n4 0 1 2 4\nCELL_TYPES 1\n10\n"),
            "test.msh:8: tetrahedron 0 has node 4, which is not there; allowed: 0 to 3",
        ),
        (vtk("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n12\n"), "cell 0, a hexahedron: `4 nodes`"),
        (vtk("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 2\n10 10\n"), "CELL_TYPES of 1 cells: `2 types`"),
        (vtk("CELLS 1 5\n4 0 1 2 3\n"), "the file has no CELL_TYPES"),
        (vtk("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n99\n"), "element 0 has type 99"),
        (
            vtk("").replace("UNSTRUCTURED_GRID", "POLYDATA"),
            "test.msh:4: the data set is `POLYDATA`; allowed: UNSTRUCTURED_GRID",
        ),
        (vtk("").replace("3.0", "9"), "test.msh:1: VTK version 9; allowed: 2.0 to 5.1"),
        (vtk("POINTS 0 double\n"), "the section POINTS is there twice"),
        (vtk("METADATA\n"), "the file has no CELLS"),
        (
            vtk("CELLS 2 5\nOFFSETS vtktypeint64\n0 9\nCONNECTIVITY vtktypeint64\n0 1 2 3 0\n").replace("3.0", "5.1"),
            "test.msh:9: an offset: `9`; allowed: an ascending place in CONNECTIVITY",
        ),
        (vtk("CELLS 2 5\n4 0 1 2 3\n").replace("3.0", "5.1"), "the list of cells: `4`; allowed: OFFSETS and then CONN"),
    ];
    for (text, expected) in cases {
        let error = parse(text.as_bytes()).expect_err(expected);
        assert!(error.contains(expected), "{error}\nexpected: {expected}\n{text}");
        assert!(error.starts_with("test.msh:"), "{error}");
    }
}

/// Two quadratic tetrahedra at a face, with straight edges: nodes 1 to 5 are corners, 6 to 14 middles.
const TWO: [&str; 14] = [
    "0 0 0",
    "1 0 0",
    "0 1 0",
    "0 0 1",
    "0 0 -1",
    "0.5 0 0",
    "0.5 0.5 0",
    "0 0.5 0",
    "0 0 0.5",
    "0.5 0 0.5",
    "0 0.5 0.5",
    "0 0 -0.5",
    "0.5 0 -0.5",
    "0 0.5 -0.5",
];
/// The elements of [`TWO`] in the order of Gmsh.
const ABOVE: &str = "7 11 0 1 2 3 4 6 7 8 9 11 10";
const BELOW: &str = "8 11 0 1 3 2 5 8 7 6 12 13 14";

/// [`TWO`] with other places of some nodes, and other elements.
fn two(others: &[(usize, &str)], above: &str, below: &str) -> String {
    let mut places = TWO.to_vec();
    others.iter().for_each(|(node, place)| places[node - 1] = place);
    let nodes: Vec<String> = places.iter().zip(1..).map(|(place, number)| format!("{number} {place}")).collect();
    one(&format!("{}\n{}", nodes.len(), nodes.join("\n")), &format!("2\n{above}\n{below}"))
}

#[test]
fn quadratic_tetrahedra_that_are_not_allowed_are_named() {
    let mesh = parse(two(&[], ABOVE, BELOW).as_bytes()).unwrap();
    assert!(mesh.quadratic.len() == 2 && mesh.tetrahedra.len() == 16 && !mesh.is_curved && mesh.notes.is_empty());
    assert_eq!(mesh.surface().unwrap().face_count(), 24, "six outer faces of four triangles");
    let curved = parse(two(&[(7, "0.52 0.52 0")], ABOVE, BELOW).as_bytes()).unwrap();
    assert!(curved.is_curved && curved.notes.is_empty());
    let cases = [
        (
            two(&[], ABOVE, "8 11 0 1 3 2 5 8 7 6 12 13 99"),
            "test.msh:24: tetrahedron 8 has node 99, which is not there; allowed: 1 to 14",
        ),
        (
            two(&[], ABOVE, "8 11 0 1 3 2 5 8 7 6 12 13 13"),
            "test.msh:24: tetrahedron 8 has node 13 twice; allowed: ten",
        ),
        (
            two(&[], ABOVE, "8 4 0 1 3 2 5"),
            "test.msh:24: tetrahedron 8 has 4 nodes and tetrahedron 7 has 10; allowed: all with 4 or all with 10",
        ),
        (
            two(&[(12, "0.5 0.5 0"), (14, "0 0.5 -0.5")], ABOVE, "8 11 0 1 3 2 5 8 12 6 9 13 14"),
            "test.msh:24: tetrahedra 7 and 8 have nodes 7 and 12 in the middle of their common edge from node 2 to 3",
        ),
        (
            two(&[], ABOVE, "8 11 0 1 3 2 5 8 7 6 9 13 14"),
            "test.msh:24: node 9 is in the middle of the edges from node 1 to 4 of tetrahedron 7 and from 1 to 5 of tetrahedron 8",
        ),
        (
            two(&[], ABOVE, "8 11 0 1 3 2 9 8 7 6 12 13 14"),
            "test.msh:24: node 9 is in the middle of an edge of tetrahedron 7 and a corner of tetrahedron 8",
        ),
        // The order of the last two nodes is that of VTK.
        (
            two(&[], "7 11 0 1 2 3 4 6 7 8 9 10 11", "8 11 0 1 3 2 5 8 7 6 12 14 13"),
            "test.msh:23: tetrahedron 7 of 10 nodes is folded over",
        ),
        (
            two(&[(6, "0.8 0 0")], ABOVE, BELOW),
            "test.msh:23: tetrahedron 7 of 10 nodes is folded over at its node 2: its Jacobian determinant is -7.1e-2",
        ),
        // At a quarter of an edge the determinant is zero at its end.
        (
            two(&[(6, "0.25 0 0")], ABOVE, BELOW),
            "is folded over at its node 1: its Jacobian determinant is 0.0e0 times",
        ),
        (two(&[(9, "0 0 1e300"), (11, "nan 0 0")], ABOVE, BELOW), "a coordinate of node 11: `nan`"),
        (two(&[(9, "0 0 1e300")], ABOVE, BELOW), "test.msh:23: tetrahedron 7 of 10 nodes is folded over"),
        (two(&[(4, "1 1 1e-10")], ABOVE, BELOW), "test.msh:23: tetrahedron 7 is flat"),
        (
            two(&[], ABOVE, ABOVE).replace("8 11", "7 11"),
            "test.msh:24: tetrahedra 7 and 7 are on the same side of their common face",
        ),
    ];
    for (text, expected) in cases {
        let error = parse(text.as_bytes()).expect_err(expected);
        assert!(error.contains(expected), "{error}\nexpected: {expected}\n{text}");
    }
}

#[test]
fn what_a_file_holds_besides_is_noted() {
    let nodes = "6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 9 9 9\n6 0 0 0";
    let elements = "3\n1 3 0 1 2 3 4\n2 1 0 1 2\n7 4 0 1 2 3 4\n";
    let mesh = parse((one(nodes, elements) + "$Periodic\n0\n$EndPeriodic\n").as_bytes()).unwrap();
    let notes: Vec<String> = mesh.notes.iter().map(Note::to_string).collect();
    let expected = [
        "2 nodes are of no tetrahedron, the first is 5; they are left out",
        "1 cells of kind quadrangle are left out",
        "not read: $Periodic",
    ];
    assert_eq!(notes, expected);
    assert_eq!(mesh.node_number, [1, 2, 3, 4]);
    // Two tetrahedra that share an edge, and one of the same nodes' places.
    let nodes = "10\n1 0 0 0\n2 0 0 1\n3 1 0 0\n4 0 1 0\n5 -1 0 0\n6 0 -1 0\n7 0 0 0\n8 5 0 0\n9 5 1e-3 0\n10 5 0 1e-3";
    let mesh = parse(one(nodes, "3\n1 4 0 1 3 4 2\n2 4 0 1 5 6 2\n3 4 0 7 8 9 10").as_bytes()).unwrap();
    let notes: Vec<String> = mesh.notes.iter().map(Note::to_string).collect();
    let has = |text: &str| assert!(notes.iter().any(|note| note.contains(text)), "{text}: {notes:?}");
    has("1 tetrahedra are nearly flat, the worst is 3");
    has("1 nodes are at the place of another one, as 1 and 7");
    has("1 edges of the boundary have more than two of its triangles, as that of nodes 1 and 2");
    has("the mesh is in 2 parts that share no node");
}

#[test]
fn a_file_cut_short_or_altered_is_an_error_or_a_mesh_and_never_a_panic() {
    let mut random = crate::testing::Random(8);
    for (format, made) in FORMATS.into_iter().flat_map(|format| random_boxes(1).map(|made| (format, made))) {
        let bytes = made.bytes(format);
        for _ in 0..100 {
            let cut = random.below(bytes.len() as u64) as usize;
            drop(parse(&bytes[..cut]));
            let mut altered = bytes.clone();
            for _ in 0..3 {
                let at = random.below(altered.len() as u64) as usize;
                altered[at] = random.below(256) as u8;
            }
            if let Ok(mesh) = parse(&altered) {
                mesh.surface().unwrap();
            }
        }
    }
}
