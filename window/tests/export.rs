//! Files for other programs: a reader that is not ours finds in them what the OBJ has.

use image::RgbImage;
use pliant_engine::session::Session;
use pliant_host::{POSE_VALID, Pose};
use pliant_mesh::Surface;
use pliant_mesh::generate;
use pliant_window::opening::{OpenRequest, Opened, open};
use pliant_window::sim::write_bodies;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A ball of radius 100 mm in centimetres, its upper half with a texture and its lower one with a colour.
fn ball(folder: &Path) -> PathBuf {
    RgbImage::from_fn(16, 8, |x, y| image::Rgb([16 * x as u8, 32 * y as u8, 90]))
        .save(folder.join("skin.png"))
        .unwrap();
    let library = "newmtl top\nmap_Kd skin.png\nnewmtl bottom\nKd 0.5 0.25 1\n";
    std::fs::write(folder.join("ball.mtl"), library).unwrap();
    let document = generate::sphere(12, 10.0).unwrap();
    let mut text = String::from("mtllib ball.mtl\n");
    for p in document.positions() {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        writeln!(text, "vt {} {}", 0.5 + 0.05 * p.x, 0.5 + 0.05 * p.y).unwrap();
    }
    let is_top = |corners: &[usize]| corners.iter().map(|c| document.positions()[c - 1].z).sum::<f64>() > 0.0;
    let faces = document.faces().map(|face| face.corners.iter().map(|c| c.v as usize + 1).collect::<Vec<_>>());
    let faces: Vec<_> = faces.collect();
    for (name, top) in [("top", true), ("bottom", false)] {
        writeln!(text, "usemtl {name}").unwrap();
        for corners in faces.iter().filter(|corners| is_top(corners) == top) {
            let corners: Vec<String> = corners.iter().map(|c| format!("{c}/{c}")).collect();
            writeln!(text, "f {}", corners.join(" ")).unwrap();
        }
    }
    let path = folder.join("ball.obj");
    std::fs::write(&path, text).unwrap();
    path
}

/// Steps with a hand at `x` (m) beside the middle and `height` (m), with pressed buttons.
fn step(session: &mut Session, [x, height]: [f64; 2], buttons: u32, count: usize) {
    let pose = Pose {
        flags: POSE_VALID,
        buttons,
        position: [x, 0.0, height],
        orientation: [0.0, 0.0, 0.0, 1.0],
        ..Pose::default()
    };
    for _ in 0..count {
        session.step_with(&[[pose], [Pose::default()]]);
    }
}

/// Area (m^2) of all triangles of a GLB, and the number of them with each material.
fn measure(document: &gltf::Gltf) -> (f64, Vec<(Option<String>, usize)>) {
    let bytes = document.blob.as_deref().unwrap();
    let (mut area, mut counts) = (0.0, Vec::new());
    for node in document.nodes() {
        for primitive in node.mesh().unwrap().primitives() {
            let floats = |accessor: gltf::Accessor<'_>, width: usize| -> Vec<Vec<f64>> {
                let offset = accessor.view().unwrap().offset();
                let floats = bytes[offset..][..4 * width * accessor.count()].chunks_exact(4);
                let floats: Vec<f64> = floats.map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect();
                floats.chunks_exact(width).map(<[f64]>::to_vec).collect()
            };
            let positions = floats(primitive.get(&gltf::Semantic::Positions).unwrap(), 3);
            let normals = floats(primitive.get(&gltf::Semantic::Normals).unwrap(), 3);
            let indices = primitive.indices().unwrap();
            let offset = indices.view().unwrap().offset();
            let corners = bytes[offset..][..4 * indices.count()].chunks_exact(4);
            let corners: Vec<usize> = corners.map(|b| u32::from_le_bytes(b.try_into().unwrap()) as usize).collect();
            for triangle in corners.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| nalgebra::Vector3::from_row_slice(&positions[triangle[i]]));
                let normal = (b - a).cross(&(c - a));
                area += 0.5 * normal.norm();
                let shading = nalgebra::Vector3::from_row_slice(&normals[triangle[0]]);
                assert!((shading.norm() - 1.0).abs() < 1e-3, "normals are unit vectors");
            }
            counts.push((primitive.material().name().map(str::to_owned), corners.len() / 3));
        }
    }
    (area, counts)
}

#[test]
fn a_glb_has_shape_materials_and_textures_before_and_after_a_cut() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let Opened { mut session, facts, .. } =
        open(&OpenRequest { threads: 1, level: 4, ..OpenRequest::new(path) }).unwrap();
    let cut = pliant_window::tools::ToolKind::all().into_iter().find(|tool| tool.name() == "cut").unwrap();
    let buttons = cut.buttons(pliant_engine::scene::Release::Keep, pliant_editor::PaintStroke::default());
    let target = folder.path().join("ball.glb");
    for is_cut in [false, true] {
        if is_cut {
            for x in -60..=60 {
                step(&mut session, [2e-3 * f64::from(x), -0.15], buttons, 1);
            }
            step(&mut session, [0.12, -0.15], 0, 5);
        }
        session.update_surface();
        let problems = write_bodies(&session, &facts.cap_material, None, &target).unwrap();
        assert!(problems.is_empty(), "{problems:?}");
        let document = gltf::Gltf::open(&target).expect("a valid file");
        let (area, counts) = measure(&document);
        write_bodies(&session, &facts.cap_material, None, &folder.path().join("check.obj")).unwrap();
        let obj = Surface::from_document(&pliant_mesh::ObjDocument::read(&folder.path().join("check.obj")).unwrap());
        let of_triangle = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| 0.01 * obj.points[v as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        let expected: f64 = obj.triangles.iter().map(of_triangle).sum();
        assert!((area / expected - 1.0).abs() < 1e-5, "{area} m^2, the OBJ has {expected} m^2");
        assert_eq!(counts.iter().map(|(_, count)| count).sum::<usize>(), obj.triangles.len());
        let names: Vec<_> = counts.iter().filter_map(|(name, _)| name.as_deref()).collect();
        assert_eq!(names, if is_cut { &["top", "bottom", "cut"][..] } else { &["top", "bottom"] });
        let image = document.images().next().unwrap();
        let gltf::image::Source::View { view, mime_type } = image.source() else { panic!("an image beside the file") };
        let bytes = &document.blob.as_deref().unwrap()[view.offset()..][..view.length()];
        assert_eq!((mime_type, bytes), ("image/png", &std::fs::read(folder.path().join("skin.png")).unwrap()[..]));
        assert!(document.materials().next().unwrap().pbr_metallic_roughness().base_color_texture().is_some());
        let [_, green, _, _] = document.materials().nth(1).unwrap().pbr_metallic_roughness().base_color_factor();
        // 0.25 as screens have it is 0.0509 linear.
        assert!((green - 0.0509).abs() < 1e-3, "{green}");
    }
}
