//! What a document is read as, against tobj, awkward files and real models.

use std::path::Path;
use std::time::Instant;

use super::*;
use crate::geometry::Vec3;
use crate::testing::{Random, document, models, shared_models};
use crate::{Surface, generate};

fn parse(bytes: &[u8]) -> Result<ObjDocument, ObjError> {
    ObjDocument::parse(bytes.to_vec(), Path::new("test.obj"))
}

/// The message with which `text` is refused.
#[track_caller]
fn refusal(text: impl AsRef<[u8]>) -> String {
    parse(text.as_ref()).expect_err("should be refused").to_string()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn everything_a_line_can_say() {
    let text = b"\xef\xbb\xbf# K\xf6nig \\\nmtllib a b.mtl\r\n\tv  1 2.5\t-3e-2 # note\r\n\
        v 1 0 0 0.5\nv 0 1 0 1 0 0\nv 0 0 1 1 0 0 1\n\
        vt 0.25\nvt 0.5 0.75 9\nvn 0 0 2\no t\xc3\xb6pf\ng left  wing\nusemtl K\xf6nig\ns 3\nf 1/1/1 2//1 \\\n  3/2\n\
        call other.obj\np 1\nl 1 2\ng\ns off\nf -4 -3 -2 -1\nf 4/ 3// 2";
    let document = parse(text).unwrap();
    assert_eq!(document.positions(), [Vec3::new(1.0, 2.5, -0.03), Vec3::x(), Vec3::y(), Vec3::z()]);
    assert_eq!(document.texcoords(), [[0.25, 0.0], [0.5, 0.75]]);
    assert_eq!(document.normals(), [Vec3::new(0.0, 0.0, 2.0)]);
    assert_eq!((document.groups(), document.objects()), (&["left  wing".to_owned()][..], &["töpf".to_owned()][..]));
    assert_eq!((document.materials(), document.libraries()), (&["König".to_owned()][..], &["a b.mtl".to_owned()][..]));
    assert_eq!(document.line_of_vertex(1), Some(4));
    let faces: Vec<Face> = document.faces().collect();
    let corners = |face: usize| faces[face].corners.iter().map(|c| (c.v, c.vt(), c.vn())).collect::<Vec<_>>();
    assert_eq!(corners(0), [(0, Some(0), Some(0)), (1, None, Some(0)), (2, Some(1), None)]);
    assert_eq!(corners(1), [0, 1, 2, 3].map(|v| (v, None, None)));
    assert_eq!(corners(2), [3, 2, 1].map(|v| (v, None, None)));
    assert_eq!([faces[0].line, faces[1].line, faces[2].line], [14, 21, 22]);
    let named = Attributes { group: Some(0), object: Some(0), material: Some(0), smoothing: 3 };
    assert_eq!(faces[0].attributes, named);
    assert_eq!(faces[2].attributes, Attributes { group: None, smoothing: 0, ..named });
    assert!(document.face(3).is_none() && document.line_of_vertex(4).is_none());
}

#[test]
fn line_ends_of_every_system() {
    for line_end in ["\n", "\r\n", "\r"] {
        let document = document(&TRIANGLE.replace('\n', line_end));
        assert_eq!((document.positions().len(), document.face(0).unwrap().line), (3, 4));
        let continued = TRIANGLE.replace("1 2 3", "1\\\n2 3").replace('\n', line_end);
        assert_eq!(super::super::testing::document(&continued).corners(0).len(), 3);
    }
}

#[test]
fn positive_indices_may_point_down_the_file() {
    assert_eq!(document("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0").face_count(), 1);
}

#[test]
fn a_line_of_five_megabytes() {
    let text = format!("# {}\n{TRIANGLE}f {}\n", "x".repeat(5_000_000), "1 \\\n");
    assert!(refusal(text).contains("f` has 1 corners"));
    let many = 700_000;
    let mut text = "v 0 1 2\n".repeat(many) + "f";
    (1..=many).for_each(|vertex| text.push_str(&format!(" {vertex}")));
    assert_eq!(document(&text).corners(0).len(), many);
    text.push_str(" 5");
    assert!(refusal(text).contains("vertex 5 twice"));
}

#[test]
fn numbers_that_are_none() {
    for token in ["nan", "inf", "-Infinity", "1e999", "1,5", "0x10", "one"] {
        let message = refusal(format!("# head\nv 0 {token} 0\n"));
        assert!(
            message.starts_with(&format!("test.obj:2: `v`: `{token}` is not usable; allowed: a finite")),
            "{message}"
        );
        assert!(refusal(format!("vn 0 {token} 0\n")).contains("`vn`"));
        assert!(refusal(format!("vt {token}\n")).contains("`vt`"));
    }
    let message = refusal("v 0 0 ".to_owned() + &"ü".repeat(99));
    assert!(message.contains(&format!("`{}…`", "ü".repeat(40))), "{message}");
}

#[test]
fn lines_that_are_too_short() {
    assert!(refusal("v 1 2").contains("`v` has 2 numbers; allowed: 3 (is the file cut short?)"));
    assert!(refusal("vn\n").contains("`vn` has 0 numbers"));
    assert!(refusal("vt # 1 2\n").contains("`vt` has 0 numbers; allowed: 1"));
    assert!(refusal(format!("{TRIANGLE}f 1 2\n")).starts_with("test.obj:5: `f` has 2 corners; allowed: 3 or more"));
    assert!(refusal(format!("{TRIANGLE}f\n")).contains("`f` has 0 corners"));
}

#[test]
fn weights() {
    assert_eq!(document(&TRIANGLE.replace("v 1 0 0", "v 1 0 0 2")).positions()[1], Vec3::x(), "not divided");
    assert!(refusal(TRIANGLE.replace("v 1 0 0", "v 1 0 0 -0.0")).contains("test.obj:2: `v` has the weight w = `-0.0`"));
    assert!(refusal("v 1 0 0 nan").contains("`nan`"));
    document(&TRIANGLE.replace("v 1 0 0", "v 1 0 0 0 0 0"));
}

#[test]
fn corners_that_name_nothing() {
    let with = |corner: &str| refusal(TRIANGLE.replace("2 3", &format!("2 {corner}")));
    assert!(with("0").starts_with("test.obj:4: `f` corner `0`: there is no such v; allowed: 1 to 3, or -1 to -3"));
    assert!(with("4").starts_with("test.obj:4: `f` corner `4`: there is no such v; allowed: 1 to 3"));
    assert!(with("-4").contains("`-4`: there is no such v"));
    assert!(with("99999999999999999999").contains("`99999999999999999999`: there is no such v"));
    assert!(with("4294967296").contains("no such v"));
    assert!(with("3/1").contains("there is no such vt; allowed: none, as the file has none"));
    assert!(with("3//-1").contains("`3//-1`: there is no such vn"));
    for token in ["1.5", "1e0", "a", "/1", "1/2/3/4", "+3", "--1", "-", "3\\x"] {
        assert!(with(token).contains(&format!("corner `{token}` is not usable; allowed: v, v/vt")), "{}", with(token));
    }
    assert!(with("2").contains("names vertex 2 twice"));
}

#[test]
fn files_that_are_no_model() {
    assert!(refusal("").contains("test.obj:1: the file is empty"));
    assert!(refusal(" \n\r\n").contains("the file is empty"));
    assert!(refusal("# nothing\n").contains("no vertices"));
    assert!(refusal("v 0 0 0\nl 1 1\n").contains("1 vertices but no faces"));
    assert!(refusal(b"v 0 0 0\nv\0\n").starts_with("test.obj:2: a NUL byte: this is a binary file or UTF-16"));
    let error = ObjDocument::read(Path::new("no/such.obj")).unwrap_err();
    assert!(matches!(error, ObjError::Read { .. }) && error.to_string().contains("no/such.obj"));
}

/// Whatever is cut off or overwritten, there is a document or an error, never a panic.
#[test]
fn damaged_files_never_panic() {
    let whole =
        "v 0 0 0\r\nv 1 0 0 1\nvt 0 1\nvn 0 0 1\nv 0 1 0\n# c\\\nf 1/1/1 2//1 \\\n 3/1\nf -1 -2 -3\ng a\\\r\n b";
    let mut random = Random(4);
    for _ in 0..20_000 {
        let mut bytes = whole.as_bytes()[..random.below(whole.len() as u64 + 1) as usize].to_vec();
        for _ in 0..random.below(3) {
            let at = random.below(bytes.len() as u64 + 1) as usize;
            bytes.insert(at, random.pick(b"\\\r\n /-#0.e\xff\t"));
        }
        _ = parse(&bytes);
    }
}

/// Positions of the corners of every face, in order: what survives tobj's renumbering.
fn by_tobj(bytes: &[u8]) -> Vec<Vec3> {
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    // It refuses a comment behind data.
    let lines = bytes.split(|byte| *byte == b'\n').map(|line| line.split(|byte| *byte == b'#').next().unwrap());
    let bytes = lines.collect::<Vec<_>>().join(&b'\n');
    let (models, _) = tobj::load_obj_buf(&mut &bytes[..], &tobj::LoadOptions::default(), no_materials).unwrap();
    let corner = |mesh: &tobj::Mesh, index: u32| Vec3::from_fn(|axis, _| mesh.positions[3 * index as usize + axis]);
    models.iter().flat_map(|m| m.mesh.indices.iter().map(|&index| corner(&m.mesh, index))).collect()
}

#[track_caller]
fn agrees_with_tobj(document: &ObjDocument) {
    let corners = document.faces().flat_map(|face| face.corners.iter().map(|corner| corner.v));
    let ours: Vec<_> = corners.map(|v| document.positions()[v as usize]).collect();
    assert!(ours == by_tobj(document.bytes()), "{}", document.name().display());
}

/// Reads as tobj reads it, and is written back byte for byte.
fn agrees_and_comes_back_whole(document: &ObjDocument, name: &str) {
    agrees_with_tobj(document);
    let mut back = Vec::new();
    document.write(document.positions(), Some(document.normals()), &mut back).unwrap();
    assert!(back == document.bytes(), "{name}");
    assert!(Surface::from_document(document).triangles.len() >= document.face_count(), "{name}");
}

#[test]
fn models_of_every_kind_agree_with_tobj_and_come_back_whole() {
    for seed in 0..6 {
        for model in models(4 + 2 * seed as u32, seed) {
            agrees_and_comes_back_whole(&model.document(), &model.name);
        }
    }
}

#[test]
#[ignore = "needs ../shared/meshes"]
fn real_models_agree_with_tobj_and_come_back_whole() {
    for path in shared_models() {
        agrees_and_comes_back_whole(&ObjDocument::read(&path).unwrap(), &path.display().to_string());
    }
}

#[test]
fn generated_models_agree_with_tobj() {
    agrees_with_tobj(&generate::grid([6, 5], [1.0, 0.3], generate::Pattern::Equilateral).unwrap());
    agrees_with_tobj(&generate::cuboid(3, [0.1, 1.0 / 3.0, 7.0]).unwrap());
    agrees_with_tobj(&generate::cylinder(9, 2, 1.0, 2.0).unwrap());
    let mut random = Random(9);
    let mut text = String::new();
    for _ in 0..500 {
        let [x, y, z] = [0; 3].map(|_| (random.unit() - 0.5) * 10_f64.powi(random.below(30) as i32 - 15));
        text += &format!("v {x} {y:e} {z:.6}\n");
        let last = text.matches("v ").count() as u64;
        if last > 3 {
            let first = 1 + random.below(last - 3);
            text += &format!("f {first} {} -1\n", first + 1);
        }
    }
    agrees_with_tobj(&document(&text));
}

/// Loads a model of `PLIANT_TRIANGLES` triangles (by default few) and says how long it took: `--nocapture`.
#[test]
#[allow(clippy::print_stderr, reason = "a measurement to be read")]
fn load_time() {
    let triangles: f64 = std::env::var("PLIANT_TRIANGLES").ok().and_then(|text| text.parse().ok()).unwrap_or(2e4);
    let cells = (triangles / 12.0).sqrt().ceil() as u32;
    let ball = Surface::from_document(&generate::sphere(cells, 0.1).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.obj");
    std::fs::write(&path, generate::to_obj(&ball)).unwrap();
    for _ in 0..3 {
        let start = Instant::now();
        let document = ObjDocument::read(&path).unwrap();
        let loaded = start.elapsed();
        assert_eq!(document.face_count(), ball.triangles.len());
        let size = document.bytes().len() as f64 / 1e6;
        eprintln!("{} triangles, {size:.1} MB: {loaded:.3?}", document.face_count());
    }
}
