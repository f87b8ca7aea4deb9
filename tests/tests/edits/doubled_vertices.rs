//! Models whose patches meet without shared vertices, as spline patches and exported parts do: edits do not open their seams.

use pliant_engine::session::EventKind;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, scan};
use pliant_mesh::{ObjDocument, Surface};
use pliant_tests::{Bench, open_file};
use std::collections::BTreeMap;

/// A surface of patches that meet at its highest vertex, as OBJ, and the vertex of `surface` that each of its own was.
fn in_patches(surface: &Surface, random: &mut Random) -> (String, Vec<u32>) {
    let top = surface.points.iter().max_by(|a, b| a.z.total_cmp(&b.z)).expect("a vertex");
    let cuts = [random.direction(), random.direction()];
    let (mut number, mut of, mut faces) = (BTreeMap::new(), Vec::new(), String::new());
    for t in &surface.triangles {
        let middle = t.iter().map(|v| surface.points[*v as usize]).sum::<Vec3>() / 3.0;
        let patch = cuts.map(|cut| cut.dot(&(middle - top)) > 0.0);
        let corners = t.map(|v| {
            *number.entry((patch, v)).or_insert_with(|| {
                of.push(v);
                of.len()
            })
        });
        faces += &format!("f {} {} {}\n", corners[0], corners[1], corners[2]);
    }
    (points_text(of.iter().map(|v| surface.points[*v as usize])) + &faces, of)
}

fn points_text(points: impl Iterator<Item = Vec3>) -> String {
    points.map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect()
}

/// The surface at rest (m) before and after an edit goes over the highest place of a model.
fn edited(text: &str, kind: &str) -> [Vec<Vec3>; 2] {
    let bench = Bench::new();
    bench.write("model.obj", text);
    let body = "mesh = \"model.obj\"\nweld = false\nsize = 0.1\nmaterial = { plugin = \"neo-hookean\", params = { young = 2e4, damping-time = 0.005 } }\n\
                grid = { level = 5, region = \"whole\" }\nfixed = [{ box = [[-1, -1, -1], [1, 1, 0]] }]";
    let start = "format = 1\n[time]\nduration = 1\ndt = 0.004\nintegrator = \"backward-euler\"\npatience = \"1000 s\"\n[[body]]\n";
    let hand = |path: &str| {
        format!(
            "[[device]]\nname = \"hand\"\nparams = {{ path = [{path}] }}\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"8 mm\"\n\
             [[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\nradius = \"20 mm\"\n"
        )
    };
    let bare = format!("{start}{body}\n{}", hand("[0, 1, 1, 1]"));
    let before = open_file(&bench.write("bare.toml", bare), 1, None).bodies[0].skin.settled.to_vec();
    let top = before.iter().max_by(|a, b| a.z.total_cmp(&b.z)).expect("a vertex");
    let path = [(0.0, -0.005, 0.012), (0.05, -0.005, 0.007), (0.3, 0.005, 0.007), (0.4, 0.005, 0.03)]
        .map(|(t, x, z)| format!("[{t}, {}, {}, {}]", top.x + x, top.y, top.z + z));
    let hand = hand(&path.join(", "));
    let mut session = open_file(&bench.write("scene.toml", format!("{start}{body}\n{hand}")), 1, None);
    while session.time() < 0.45 {
        session.step();
    }
    assert_eq!(session.events.count(EventKind::Quarantine), 0, "{:?}", session.events.described());
    [before, session.bodies[0].skin.settled.to_vec()]
}

#[test]
fn no_edit_of_the_shape_at_rest_opens_a_seam_of_doubled_vertices() {
    let random = &mut Random(71);
    for kind in ["smooth", "flatten", "pinch", "relax", "grow", "shrink"] {
        let model = scan(random.below(3) as u32, 3000, 0, random.next_u64());
        let text = model.text.as_bytes().to_vec();
        let surface = Surface::from_document(&ObjDocument::parse(text, "model.obj".as_ref()).expect("an OBJ"));
        let (patches, of) = in_patches(&surface, random);
        let [before, after] = edited(&patches, kind);
        let moved = before.iter().zip(&after).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let mut places: BTreeMap<u32, Vec3> = BTreeMap::new();
        let (mut doubled, mut gap) = (0, 0.0_f64);
        for (v, x) in of.iter().zip(&after) {
            if let Some(first) = places.insert(*v, *x) {
                doubled += 1;
                gap = gap.max((first - x).norm());
            }
        }
        println!("{kind}, {}: moved by {:.3} mm, {doubled} doubled vertices, gap {gap:.1e} m", model.name, 1e3 * moved);
        assert!(moved > 1e-5 && doubled > 10, "{kind}: {moved} m, {doubled} doubled vertices");
        assert!(gap == 0.0, "{kind}: a gap of {gap} m");
    }
}
