use super::*;
use crate::testing::Random;
use crate::testing::tet_data::{TetData, VtuEncoding, VtuFormat};
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

/// A random box, linear or quadratic, with numbers.
fn random(seed: u64) -> (TetBox, TetData) {
    let mut random = Random(seed);
    let made = TetBox::random(seed);
    let made = if seed.is_multiple_of(2) { made } else { made.quadratic() };
    let mut numbers = |count: usize| (0..count).map(|_| 1e6 * random.signed()).collect();
    let data = TetData { nodes: numbers(made.points.len()), elements: numbers(made.tetrahedra.len()) };
    (made, data)
}

fn parse(bytes: &[u8]) -> Result<TetMesh, String> {
    TetMesh::parse(bytes, Path::new("test.vtu")).map_err(|error| error.to_string())
}

fn check(mesh: &TetMesh, made: &TetBox, data: &TetData, what: &dyn std::fmt::Debug) {
    assert_eq!((&mesh.points, &mesh.quadratic), (&made.points, &made.quadratic), "{what:?}");
    assert!(!made.quadratic.is_empty() || mesh.tetrahedra == made.tetrahedra, "{what:?}");
    let of =
        |name: &str| mesh.data.iter().find(|data| data.name == name).unwrap_or_else(|| panic!("{what:?}: no {name}"));
    assert_eq!((of("at nodes").place, &of("at nodes").values), (DataPlace::Nodes, &data.nodes), "{what:?}");
    assert_eq!((of("E").place, &of("E").values), (DataPlace::Elements, &data.elements), "{what:?}");
    assert_eq!(mesh.data.len(), 2, "{what:?}");
}

#[test]
fn every_format_gives_numbers_at_nodes_and_elements() {
    for seed in 0..12 {
        let (made, data) = random(seed);
        for format in FORMATS {
            check(&parse(&made.bytes_with(format, &data)).unwrap(), &made, &data, &format);
        }
        for format in VtuFormat::all() {
            check(&parse(&made.vtu_bytes(format, &data)).unwrap(), &made, &data, &format);
        }
    }
}

#[test]
fn arrays_of_several_components_are_noted_as_not_read() {
    let (made, data) = random(1);
    for bytes in [made.bytes_with(TetFormat::VtkBinary, &data), made.vtu_bytes(VtuFormat::all().next().unwrap(), &data)]
    {
        let mesh = parse(&bytes).unwrap();
        let notes: Vec<String> = mesh.notes.iter().map(ToString::to_string).collect();
        assert!(notes.iter().any(|note| note.contains("`velocity`") && note.contains('3')), "{notes:?}");
    }
}

#[test]
fn the_line_of_an_array_is_that_of_its_beginning() {
    let (made, data) = random(2);
    let text =
        VtuFormat { encoding: VtuEncoding::Text, is_compressed: false, is_big_endian: false, has_long_sizes: false };
    for (bytes, begins) in [
        (made.vtu_bytes(text, &data), "Name=\"E\""),
        (made.bytes_with(TetFormat::Vtk, &data), "E 1 "),
        (made.bytes_with(TetFormat::Msh4, &data), "$ElementData"),
    ] {
        let line = String::from_utf8(bytes.clone()).unwrap().lines().position(|line| line.contains(begins)).unwrap();
        let mesh = parse(&bytes).unwrap();
        assert_eq!(mesh.data.iter().find(|data| data.name == "E").unwrap().line as usize, line + 1, "{begins}");
    }
}

/// What is done to the text of a file, and what its error says.
const WRONG: [(&str, &str, &[&str]); 16] = [
    ("type=\"UnstructuredGrid\"", "type=\"PolyData\"", &["PolyData", "UNSTRUCTURED_GRID"]),
    ("byte_order=\"LittleEndian\"", "byte_order=\"Middle\"", &["byte_order", "Middle", "BigEndian"]),
    (
        "version=\"1.0\" byte",
        "compressor=\"vtkLZ4DataCompressor\" byte",
        &["compressor", "vtkLZ4DataCompressor", "vtkZLib"],
    ),
    ("NumberOfPoints=\"", "NumberOfPoints=\"-", &["NumberOfPoints", "-"]),
    ("NumberOfPoints=\"", "NumberOfPoints=\"9", &["Points"]),
    ("NumberOfCells=\"", "NumberOfCells=\"9", &["array `offsets`"]),
    ("<Points>", "<Pionts>", &["XML", "Pionts"]),
    ("Name=\"types\"", "Name=\"kinds\"", &["types"]),
    ("type=\"UInt8\"", "type=\"Bit\"", &["array `types`", "Bit", "Float64"]),
    ("format=\"ascii\"", "format=\"octal\"", &["format", "octal", "appended"]),
    (
        "Name=\"Points\" NumberOfComponents=\"3\"",
        "Name=\"Points\" NumberOfComponents=\"2\"",
        &["NumberOfComponents", "2"],
    ),
    ("<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY b \"c\">]>", &["XML"]),
    ("</Piece>", "</Piece><Piece/>", &["pieces", "2", "one"]),
    ("<Cells>", "<Cells>\u{1}", &["XML"]),
    ("<CellData>", "<CellData><DataArray Name=\"few\" type=\"Float64\">1</DataArray>", &["`few`", "cut short"]),
    ("<CellData>", "<CellData><DataArray Name=\"bad\" type=\"Float64\">1 x</DataArray>", &["`bad`", "`x`", "a number"]),
];

#[test]
fn errors_of_a_vtu_name_file_line_array_and_what_is_allowed() {
    let (made, data) = random(4);
    let text =
        VtuFormat { encoding: VtuEncoding::Text, is_compressed: false, is_big_endian: false, has_long_sizes: false };
    let good = String::from_utf8(made.vtu_bytes(text, &data)).unwrap();
    for (from, to, says) in WRONG {
        assert!(good.contains(from), "{from}");
        let bad = good.replacen(from, to, 1);
        let error = parse(bad.as_bytes()).err().unwrap_or_else(|| panic!("{to} is taken"));
        assert!(error.starts_with("test.vtu:") && says.iter().all(|said| error.contains(said)), "{to}: {error}");
    }
    let (before, points) = good.split_once("<Points>").unwrap();
    let error = parse(format!("{before}<Points>{}", points.replacen("Float64", "Int99", 1)).as_bytes()).err().unwrap();
    assert!(error.contains("Points") && error.contains("Int99"), "{error}");
}

#[test]
fn a_vtu_whose_bytes_are_changed_is_refused_or_read_and_never_more() {
    let mut random_numbers = Random(7);
    let (made, data) = random(0);
    for format in VtuFormat::all() {
        let good = made.vtu_bytes(format, &data);
        for _ in 0..60 {
            let mut bad = good.clone();
            match random_numbers.below(3) {
                0 => bad.truncate(random_numbers.below(bad.len() as u64) as usize),
                1 => {
                    let at = random_numbers.below(bad.len() as u64) as usize;
                    bad[at] = random_numbers.below(256) as u8;
                }
                _ => {
                    let at = random_numbers.below(bad.len() as u64) as usize;
                    bad[at..].iter_mut().take(8).for_each(|byte| *byte = 0xff);
                }
            }
            if let Err(error) = parse(&bad) {
                assert!(error.starts_with("test.vtu:"), "{error}");
            }
        }
    }
}

#[test]
fn blocks_that_claim_more_than_they_hold_take_no_memory() {
    let (made, data) = random(0);
    let format = VtuFormat {
        encoding: VtuEncoding::AppendedRaw,
        is_compressed: true,
        is_big_endian: false,
        has_long_sizes: true,
    };
    let good = made.vtu_bytes(format, &data);
    let begin = good.windows(2).position(|two| two == b" _").unwrap() + 2;
    for (word, value) in [(0, u64::MAX / 16), (0, 1 << 40), (1, 1 << 50), (2, u64::MAX), (3, 1 << 50)] {
        let mut bad = good.clone();
        bad[begin + 8 * word..][..8].copy_from_slice(&value.to_le_bytes());
        let error = parse(&bad).err().unwrap_or_else(|| panic!("{word} of {value} is taken"));
        assert!(error.contains("`at nodes`"), "{error}");
    }
}

#[test]
fn data_of_other_files_that_does_not_fit_is_refused_with_its_line() {
    let (made, data) = random(0);
    let vtk = String::from_utf8(made.bytes_with(TetFormat::Vtk, &data)).unwrap();
    let msh = String::from_utf8(made.bytes_with(TetFormat::Msh2, &data)).unwrap();
    let cells = made.tetrahedra.len();
    for (good, from, to, says) in [
        (&vtk, format!("CELL_DATA {cells}"), format!("CELL_DATA {}", cells + 1), "CELL_DATA"),
        (&vtk, format!("E 1 {cells}"), format!("E 1 {}", cells + 1), "array `E`"),
        (&vtk, "at%20nodes double".into(), "at%20nodes quad".into(), "quad"),
        (&vtk, "SCALARS at%20nodes double 1".into(), "SCALARS at%20nodes double one".into(), "one"),
        (&msh, "$ElementData\n1\n\"E\"".into(), "$ElementData\n1\nE".into(), "in quotes"),
        (&msh, format!("0\n1\n{cells}\n"), format!("0\n1\n{}\n", cells + 1), "array `E`"),
    ] {
        assert!(good.contains(&from), "{from}");
        let error = parse(good.replacen(&from, &to, 1).as_bytes()).err().unwrap_or_else(|| panic!("{to} is taken"));
        assert!(error.starts_with("test.vtu:") && error.contains(says), "{to}: {error}");
    }
}
