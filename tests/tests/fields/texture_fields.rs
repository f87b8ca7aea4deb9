//! Fields by grey images: against bars of two stiffnesses, as files of a run, and what is refused.

use pliant_engine::session::Session;
use pliant_mesh::testing::png::{BitDepth, ColorType};
use pliant_mesh::testing::{Random, grey_png, png_bytes};
use pliant_tests::bar::{FACTORS, MATERIALS, STRAIN, energy, energy_in_series, halves, open_bar};
use pliant_tests::{Bench, box_scene};

/// An atlas: where the texture coordinates of a place of the bar are.
#[derive(Clone, Copy, Debug)]
struct Atlas {
    /// Whether u runs along y and v along x.
    is_turned: bool,
    /// Whole tiles that are added to u and v, and whether both run backwards.
    tiles: [f64; 2],
    is_mirrored: bool,
}

impl Atlas {
    fn random(random: &mut Random) -> Self {
        let mut flip = || random.below(2) == 1;
        let [is_turned, is_mirrored] = [flip(), flip()];
        let tiles = [0, 1].map(|_| random.below(7) as f64 - 3.0);
        Self { is_turned, tiles, is_mirrored }
    }

    /// Texture coordinates at shares of the length and width of the bar, from a tenth to nine tenths of a tile.
    fn at(&self, along: f64, across: f64) -> [f64; 2] {
        let [along, across] =
            [along, across].map(|share| 0.1 + 0.8 * if self.is_mirrored { 1.0 - share } else { share });
        let [u, v] = if self.is_turned { [across, along] } else { [along, across] };
        [u + self.tiles[0], v + self.tiles[1]]
    }

    /// An image that is black where x < 0 and white beyond, with its step in the middle of the bar.
    fn step(&self, size: usize) -> Vec<u8> {
        let value = |i: usize| {
            let (column, row) = (i % size, i / size);
            let share = if self.is_turned { size - 1 - row } else { column };
            if (share < size / 2) == self.is_mirrored { 255 } else { 0 }
        };
        grey_png(size, size, &(0..size * size).map(value).collect::<Vec<u8>>())
    }
}

/// A bar of 0.08 x 0.04 x `depth` m about the origin as quads with texture coordinates; a sheet without depth.
fn bar_obj(atlas: Atlas, depth: f64) -> String {
    let (columns, rows) = (8, 4);
    let corner = |i: usize, j: usize, z: f64| {
        let (along, across) = (i as f64 / columns as f64, j as f64 / rows as f64);
        let [u, v] = atlas.at(along, across);
        format!("v {} {} {z}\nvt {u} {v}\n", 0.08 * along - 0.04, 0.04 * across - 0.02)
    };
    let (mut text, mut faces, mut count) = (String::new(), String::new(), 0);
    let mut quad = |corners: [(usize, usize, f64); 4]| {
        corners.iter().for_each(|(i, j, z)| text += &corner(*i, *j, *z));
        faces += "f";
        (1..=4).for_each(|k| faces += &format!(" {0}/{0}", count + k));
        faces += "\n";
        count += 4;
    };
    let (top, bottom) = (0.5 * depth, -0.5 * depth);
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        quad([(i, j, top), (i + 1, j, top), (i + 1, j + 1, top), (i, j + 1, top)]);
        if depth > 0.0 {
            quad([(i, j, bottom), (i, j + 1, bottom), (i + 1, j + 1, bottom), (i + 1, j, bottom)]);
        }
    }
    for i in (0..columns).filter(|_| depth > 0.0) {
        quad([(i, 0, bottom), (i + 1, 0, bottom), (i + 1, 0, top), (i, 0, top)]);
        quad([(i, rows, top), (i + 1, rows, top), (i + 1, rows, bottom), (i, rows, bottom)]);
    }
    for j in (0..rows).filter(|_| depth > 0.0) {
        quad([(0, j, bottom), (0, j, top), (0, j + 1, top), (0, j + 1, bottom)]);
        quad([(columns, j, top), (columns, j, bottom), (columns, j + 1, bottom), (columns, j + 1, top)]);
    }
    welded(&text, &faces)
}

/// The same with one `v` for equal places.
fn welded(text: &str, faces: &str) -> String {
    let (mut places, mut number): (Vec<&str>, Vec<usize>) = (Vec::new(), Vec::new());
    for line in text.lines().filter(|line| line.starts_with("v ")) {
        let at = places.iter().position(|known| *known == line).unwrap_or_else(|| {
            places.push(line);
            places.len() - 1
        });
        number.push(at + 1);
    }
    let coordinates: Vec<&str> = text.lines().filter(|line| line.starts_with("vt ")).collect();
    let corner = |word: &str| match word.split_once('/') {
        Some((v, vt)) => format!("{}/{vt}", number[v.parse::<usize>().expect("a number") - 1]),
        None => word.to_owned(),
    };
    let faces: Vec<String> =
        faces.lines().map(|line| line.split(' ').map(corner).collect::<Vec<_>>().join(" ")).collect();
    [places.join("\n"), coordinates.join("\n"), faces.join("\n")].join("\n") + "\n"
}

/// A bar of a model with texture coordinates, with fields.
fn bar(bench: &Bench, material: &str, params: &str, fields: &str) -> Session {
    let how = if material == "cloth" { "sheet = {}" } else { "grid = { level = 5, region = \"whole\" }" };
    open_bar(bench, &format!("mesh = \"bar.obj\"\n{how}"), material, params, fields)
}

/// A texture that is a step gives the bar of two stiffnesses in series or in parallel, whatever way its coordinates run.
#[test]
fn a_step_in_a_texture_is_a_bar_of_two_stiffnesses() {
    let mut random = Random(4);
    for (material, params, param) in MATERIALS {
        let bench = Bench::new();
        let (atlas, size) = (Atlas::random(&mut random), 64 << random.below(3));
        bench.write("bar.obj", bar_obj(atlas, if material == "cloth" { 0.0 } else { 0.04 }));
        bench.write("step.png", atlas.step(size));
        let uniform = energy(&mut bar(&bench, material, params, ""), [STRAIN, STRAIN]);
        let texture = format!("[[body.field]]\nparam = \"{param}\"\ntexture = \"step.png\"\nrange = {FACTORS:?}\n");
        let mut by_texture = bar(&bench, material, params, &texture);
        let mut by_boxes = bar(&bench, material, params, &halves(param, 0));
        for strains in [[STRAIN, STRAIN], [0.3 * STRAIN, 1.7 * STRAIN], [1.9 * STRAIN, 0.1 * STRAIN]] {
            let [found, exact] = [&mut by_texture, &mut by_boxes].map(|bar| energy(bar, strains));
            assert!((found / exact - 1.0).abs() < 1e-12, "{material} {param} {atlas:?}: {found}, by boxes {exact} J");
        }
        let found = energy_in_series(&mut by_texture) / uniform;
        let exact = 2.0 / (1.0 / FACTORS[0] + 1.0 / FACTORS[1]);
        assert!((found / exact - 1.0).abs() < 0.01, "{material} {param} in series: {found}, exact {exact}");
    }
}

/// A bench with a bar and the scene of a run over it that reads `texture`.
fn run_bench(obj: &str, texture: &str, rest: &str) -> Bench {
    let bench = Bench::new();
    bench.write("bar.obj", obj);
    let field = format!("[[body.field]]\nparam = \"young\"\ntexture = \"{texture}\"\n{rest}\n[[device]]");
    let scene = box_scene("", "", "").replace("[[device]]", &field);
    let shape = r#"shape = { kind = "box", cells = 12, size = [0.04, 0.04, 0.04] }"#;
    bench.write("scene.toml", scene.replace(shape, "mesh = \"bar.obj\""));
    bench
}

const ATLAS: Atlas = Atlas { is_turned: false, tiles: [0.0, 0.0], is_mirrored: false };

#[test]
fn a_texture_is_a_file_of_the_run() {
    let bench = run_bench(&bar_obj(ATLAS, 0.04), "map.png", "");
    bench.write("map.png", grey_png(2, 1, &[0, 255]));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "hand.rec"]).expect(0);
    let inputs = bench.summary("out")["inputs"].clone();
    let field = inputs.as_array().expect("a list").iter().find(|input| input["role"] == "field").expect("a field");
    assert!(field["name"].as_str().expect("a name").ends_with("map.png") && field["blake3"].is_string(), "{field}");
    bench
        .pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "map.png"])
        .expect(2)
        .says(&["a file of a field, of fibres or of a `fixed` of this run"]);
    bench.pliant(&["replay", "hand.rec", "--verify", "-q"]).expect(0);
    bench.write("map.png", grey_png(2, 1, &[0, 254]));
    bench.pliant(&["replay", "hand.rec"]).expect(2).says(&["map.png has changed since it was recorded"]);
}

#[test]
fn what_a_texture_cannot_be_is_refused() {
    let bench = Bench::new();
    let whole = bar_obj(ATLAS, 0.04);
    // Without the coordinates of one corner of one face.
    let last = whole.trim_end().rsplit(' ').next().expect("a corner");
    let missing = format!("{}{}\n", whole.trim_end().trim_end_matches(last), last.split('/').next().expect("a vertex"));
    let line = format!("bar.obj: line {}: a face without texture coordinates", whole.lines().count());
    let (images, folder) = (bench.path(""), bench.path("folder.png"));
    std::fs::create_dir(&folder).expect("a folder");
    bench.write("grey.png", grey_png(2, 1, &[0, 255]));
    bench.write("16.png", png_bytes(2, 2, ColorType::Grayscale, BitDepth::Sixteen, &[7; 8]));
    bench.write("2.png", png_bytes(2, 2, ColorType::Grayscale, BitDepth::Two, &[7; 2]));
    bench.write("palette.png", png_bytes(2, 2, ColorType::Indexed, BitDepth::Eight, &[7; 4]));
    bench.write("large.png", png_bytes(70_000, 1000, ColorType::Grayscale, BitDepth::One, &vec![0; 8750 * 1000]));
    bench.write("text.png", "not an image");
    bench.write("short.png", &grey_png(32, 32, &[7; 1024])[..60]);
    let cases: [(&str, &str, &str, &[&str]); 11] = [
        (&missing, "grey.png", "", &[&line, "allowed is `f v/vt"]),
        (&whole, "none.png", "", &["none.png: cannot be read"]),
        (&whole, "folder.png", "", &["folder.png: cannot be read: a folder; allowed is a regular file"]),
        (&whole, "16.png", "", &["16.png: 16 bits a channel, grey; allowed is 8 bits a channel"]),
        (&whole, "2.png", "", &["2.png: 2 bits a channel"]),
        (&whole, "palette.png", "", &["palette.png: 8 bits a channel, indexed by a palette; allowed is"]),
        (&whole, "large.png", "", &["large.png: 70000 x 1000 pixels; allowed is at most 67108864 pixels"]),
        (&whole, "text.png", "", &["text.png: not a PNG image"]),
        (&whole, "short.png", "", &["short.png: not a PNG image"]),
        (&whole, "grey.png", "range = [0.05, 2.0]", &["range [0.05, 2]", "0.1 to 10"]),
        (&whole, "grey.png", "factor = 2.0", &["`texture` and `factor`", "allowed is"]),
    ];
    for (obj, texture, rest, said) in cases {
        let path = images.join(texture).display().to_string();
        let ran = run_bench(obj, &path, rest).pliant(&["run", "scene.toml", "--out", "out"]);
        assert_eq!(ran.code, 2, "{texture}: {}", ran.err);
        assert!(ran.err.starts_with("error: scene.toml:"), "{texture}: {}", ran.err);
        ran.says(said);
    }
}
