//! Scenes that cannot be used are refused with file, line, key, value and what is allowed, and nothing is written.

use pliant_tests::{Bench, box_scene};

const SCENE: &str = r#"format = 1
title = "sound"
gravity = [0, 0, 0]
[time]
duration = 0.01
dt = 0.001
[solver]
tolerance = 1e-6
[[body]]
name = "block"
shape = { kind = "box", cells = 8, size = [0.04, 0.04, 0.04] }
material = { plugin = "mass-spring", params = { young = 1e4 } }
[body.grid]
level = 4
[[body.fixed]]
box = [[-1, -1, -1], [1, 1, -0.019]]
path = [[0, 0, 0, 0], [1, 0, 0, 0]]
[[device]]
name = "hand"
frame = { body = "block", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }
params = { path = [[0.0, 0.0, 0.0, 0.006], [0.01, 0.0, 0.0, 0.001]] }
[[tool]]
name = "finger"
device = "hand"
radius = "4 mm"
[[edit]]
kind = "touch"
tool = "finger"
[[probe]]
name = "most"
quantity = "force"
[output]
trace = true
"#;

/// A text of the scene, what stands there instead, how many lines after it the error is, and what is said of it.
type Case = (&'static str, &'static str, isize, &'static [&'static str]);

fn refuses(cases: &[Case]) {
    for (sound, bad, after, said) in cases {
        assert_eq!(SCENE.matches(sound).count(), 1, "`{sound}` is there once");
        let line = SCENE[..SCENE.find(sound).expect("there")].matches('\n').count() as isize + 1 + after;
        let bench = Bench::new();
        bench.write("scene.toml", SCENE.replace(sound, bad));
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]);
        assert_eq!(ran.code, 2, "{bad}: {}", ran.err);
        assert!(ran.err.starts_with(&format!("error: scene.toml:{line}:")), "{bad}: line {line}, not {}", ran.err);
        assert!(ran.err.len() < 900 && !ran.err.contains("panicked"), "{bad}: {}", ran.err);
        for part in *said {
            assert!(ran.err.contains(part), "{bad}: `{part}` is not in {}", ran.err);
        }
        assert_eq!(bench.names("."), ["scene.toml"], "{bad}: nothing was written");
    }
}

#[test]
fn the_scene_they_are_made_of_is_sound() {
    let bench = Bench::new();
    bench.write("scene.toml", SCENE);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
}

#[test]
fn what_is_no_scene_is_refused() {
    for (what, text, said) in [
        ("nothing", &b""[..], &["scene.toml: missing field `format`"][..]),
        ("no bodies", b"format = 1\n", &["scene.toml: no [[body]]", "one at least"]),
        ("cut off", b"format = 1\n[[body", &["scene.toml:2:", "[[body"]),
        ("cut off in a text", b"format = 1\ntitle = \"a", &["scene.toml:2:", "title = \"a"]),
        ("a key twice", b"format = 1\nformat = 1\n", &["scene.toml:2:1: duplicate key"]),
        (
            "Latin-1",
            b"format = 1\ntitle = \"\xe9\"\n",
            &["scene.toml:2:10: not UTF-8", "allowed is a TOML file in UTF-8"],
        ),
        ("zeros", &[0; 512], &["scene.toml:1:"]),
        ("an OBJ", b"v 0 0 0\nv 1 0 0\n", &["scene.toml:1:"]),
        ("JSON", b"{ \"format\": 1 }", &["scene.toml:1:"]),
        ("another format", b"format = 2\n", &["scene.toml:1:10: format 2; allowed is 1"]),
    ] {
        let bench = Bench::new();
        bench.write("scene.toml", text);
        for verb in [&["run", "scene.toml", "--out", "out"][..], &["plan", "scene.toml"]] {
            let ran = bench.pliant(verb).expect(2).says(said);
            assert!(ran.err.len() < 900 && !ran.err.contains("panicked"), "{what}: {}", ran.err);
        }
        assert_eq!(bench.names("."), ["scene.toml"], "{what}");
    }
    let bench = Bench::new();
    std::fs::create_dir(bench.path("folder.toml")).expect("a folder");
    for name in ["nowhere.toml", "folder.toml", "no/folder/scene.toml"] {
        bench.pliant(&["run", name, "--out", "out"]).expect(2).says(&[name, "cannot be read"]);
    }
    assert_eq!(bench.names("."), ["folder.toml"]);
}

#[test]
fn unknown_keys_are_told_with_those_there_are() {
    refuses(&[
        ("title = \"sound\"", "titel = \"\"", 0, &["unknown field `titel`", "`format`, `title`, `time`"]),
        ("dt = 0.001", "step = 0.001", 0, &["unknown field `step`", "`duration`, `dt`, `integrator`"]),
        (
            "tolerance = 1e-6",
            "tol = 1",
            0,
            &["unknown field `tol`", "`tolerance`, `iterations`, `newton`, `newton-tolerance`"],
        ),
        ("name = \"block\"", "colour = 3", 0, &["unknown field `colour`", "`name`, `mesh`, `shape`"]),
        ("cells = 8", "cell = 8", 0, &["unknown field `cell`", "`kind`, `cells`, `size`"]),
        ("level = 4", "levle = 4", 0, &["unknown field `levle`", "`plugin`, `params`, `level`"]),
        ("box = [[-1", "bocks = [[-1", 0, &["unknown field `bocks`", "`box`, `ball`, `radius`"]),
        ("from = [", "form = [", 0, &["unknown field `form`", "`body`, `from`, `toward`"]),
        ("radius = \"4 mm\"", "size = 1", 0, &["unknown field `size`", "`radius`, `shape`, `stiffness`"]),
        ("kind = \"touch\"", "knd = \"touch\"", 0, &["unknown field `knd`", "`kind`, `tool`, `start`"]),
        ("quantity = \"force\"", "what = 1", 0, &["unknown field `what`", "`name`, `quantity`, `of`"]),
        ("trace = true", "tarce = true", 0, &["unknown field `tarce`", "`trace`, `energy`"]),
        ("young = 1e4", "yuong = 1e4", 0, &["material `mass-spring`: no parameter `yuong`", "allowed is mode, young"]),
        ("path = [[0.0", "paht = [[0.0", 0, &["device `scripted`: no parameter `paht`", "allowed is path, buttons"]),
        (
            "level = 4",
            "level = 4\nparams = { order = 2 }",
            1,
            &["grid `octree-grid`: no parameter `order`", "embedding"],
        ),
    ]);
}

#[test]
fn wrong_types_are_told_with_what_is_expected() {
    refuses(&[
        ("format = 1", "format = \"1\"", 0, &["string \"1\"", "a whole number, 0 or more"]),
        ("title = \"sound\"", "title = 5", 0, &["integer `5`", "expected a string"]),
        ("gravity = [0, 0, 0]", "gravity = 9.81", 0, &["`9.81`", "an array of length 3"]),
        ("gravity = [0, 0, 0]", "gravity = [0, 0]", 0, &["length 2", "an array of length 3"]),
        ("dt = 0.001", "dt = true", 0, &["boolean `true`", "expected a time: a number in s or text such as \"2 s\""]),
        ("dt = 0.001", "dt = [1]", 0, &["sequence", "expected a time"]),
        ("dt = 0.001", "integrator = 4", 0, &["wrong type; allowed is a text"]),
        ("dt = 0.001", "substeps = 1.5", 0, &["`1.5`", "a whole number, 0 or more"]),
        ("dt = 0.001", "substeps = -1", 0, &["`-1`", "a whole number, 0 or more"]),
        ("dt = 0.001", "force-unstable = 1", 0, &["`1`", "expected a boolean"]),
        ("tolerance = 1e-6", "tolerance = \"x\"", 0, &["string \"x\"", "expected a number"]),
        ("tolerance = 1e-6", "iterations = 1e3", 0, &["`1000.0`", "a whole number, 0 or more"]),
        ("plugin = \"mass-spring\"", "plugin = 3", 0, &["integer `3`", "expected a string"]),
        ("young = 1e4", "young = true", 0, &["parameter `young`: true is a boolean", "a number from 0.000001 to"]),
        ("young = 1e4", "young = [1]", 0, &["parameter `young`: [1] is an array", "allowed is a number"]),
        ("young = 1e4", "mode = 3", 0, &["parameter `mode`: 3 is an integer", "one of physical, paper"]),
        ("level = 4", "level = \"four\"", 0, &["level \"four\"", "a whole number from 1, or \"auto\""]),
        ("path = [[0, 0, 0, 0], [1, 0, 0, 0]]", "path = [[0, 0, 0]]", 0, &["length 3", "an array of length 4"]),
        ("[[0.0, 0.0, 0.0, 0.006], [", "[[0.0, 0.0], [", 0, &["`path`: row 1: [0.0, 0.0]", "[time, x, y, z]"]),
        ("[[0.0, 0.0, 0.0, 0.006], [", "[[0, 0, 0, \"6 mm\"], [", 0, &["`path`: row 1", "\"6 mm\"", "[time, x, y, z]"]),
        ("device = \"hand\"", "device = \"hand\"\nfriction = 0.3", 1, &["`0.3`", "an array of length 2"]),
        ("quantity = \"force\"", "quantity = \"force\"\nexpected = \"3 N\"", 1, &["\"3 N\"", "expected a number"]),
        ("trace = true", "trace = 1", 0, &["integer `1`", "expected a boolean"]),
    ]);
}

#[test]
fn wrong_units_are_told_with_those_that_fit() {
    refuses(&[
        ("dt = 0.001", "dt = \"1 mm\"", 0, &["`1 mm` is a length; allowed is a time", "one of s, ms, us"]),
        ("dt = 0.001", "dt = \"1e-3\"", 0, &["`1e-3` has no unit; allowed is a time"]),
        ("dt = 0.001", "dt = \"fast\"", 0, &["`fast` has no number before its unit; allowed is a time"]),
        ("duration = 0.01", "duration = \"1 N\"", 0, &["`1 N` is a force; allowed is a time"]),
        ("gravity = [0, 0, 0]", "gravity = [0, 0, \"9.81 m\"]", 0, &["`9.81 m` is a length", "an acceleration"]),
        ("[0.04, 0.04, 0.04]", "[\"4 s\", 1, 1]", 0, &["`4 s` is a time; allowed is a length", "m, cm, mm, um"]),
        ("young = 1e4", "young = \"5 mm\"", 0, &["`young`: `5 mm` is a length", "a pressure", "Pa, kPa, MPa, GPa"]),
        ("young = 1e4", "density = \"1 kg\"", 0, &["`density`: `1 kg` is a mass", "a density", "kg/m^3, g/cm^3"]),
        ("radius = \"4 mm\"", "radius = \"4 kg\"", 0, &["`4 kg` is a mass; allowed is a length"]),
        ("radius = \"4 mm\"", "radius = \"4 furlongs\"", 0, &["`furlongs` is not a unit; allowed is a length"]),
        ("radius = \"4 mm\"", "radius = 1\nstiffness = \"3 N\"", 1, &["`3 N` is a force; allowed is a stiffness"]),
        ("trace = true", "frames = \"25 s\"", 0, &["`25 s` is a time; allowed is a frequency", "Hz, kHz"]),
    ]);
}

#[test]
fn times_and_solvers_that_make_no_sense_are_refused() {
    refuses(&[
        ("dt = 0.001", "dt = 0", 0, &["dt is 0 s; allowed is a number above 0"]),
        ("dt = 0.001", "dt = \"-1 ms\"", 0, &["dt is -0.001 s; allowed is a number above 0"]),
        ("dt = 0.001", "dt = nan", 0, &["NaN is not finite; allowed is a time"]),
        ("dt = 0.001", "dt = inf", 0, &["inf is not finite; allowed is a time"]),
        ("dt = 0.001", "dt = \"nan s\"", 0, &["`nan s` is not finite; allowed is a time"]),
        ("dt = 0.001", "dt = 1e-300", 0, &["dt is 1e-300 s, 1e298 steps; allowed is 1e9 steps at most"]),
        ("dt = 0.001", "dt = 1e300", 0, &["dt is 1e300 s; allowed is 1e9 s at most"]),
        ("duration = 0.01", "duration = 0", 0, &["duration is 0 s; allowed is a number above 0"]),
        ("duration = 0.01", "duration = 1e300", 0, &["duration is 1e300 s; allowed is 1e9 s at most"]),
        ("duration = 0.01", "duration = 1e8", 1, &["1e11 steps; allowed is 1e9 steps at most"]),
        ("dt = 0.001", "integrator = \"rk4\"", 0, &["`rk4`", "`auto`, `explicit-euler`, `symplectic-euler`"]),
        ("dt = 0.001", "substeps = 4294967295", 0, &["substeps is 4294967295; allowed is 0 to most-substeps, 64"]),
        ("dt = 0.001", "most-substeps = 0", 0, &["most-substeps is 0; allowed is 1 or more"]),
        ("tolerance = 1e-6", "tolerance = 0", 0, &["tolerance is 0; allowed is a number above 0 and below 1"]),
        ("tolerance = 1e-6", "tolerance = 1", 0, &["tolerance is 1; allowed is a number above 0 and below 1"]),
        ("tolerance = 1e-6", "tolerance = nan", 0, &["tolerance is NaN; allowed is a number above 0"]),
        ("tolerance = 1e-6", "iterations = 0", 0, &["iterations is 0; allowed is 1 or more"]),
        ("gravity = [0, 0, 0]", "gravity = [0, nan, 0]", 0, &["NaN is not finite; allowed is an acceleration"]),
    ]);
}

#[test]
fn bodies_that_make_no_sense_are_refused() {
    refuses(&[
        ("name = \"block\"", "name = \"\"", 0, &["body \"\"; allowed is a name without"]),
        ("name = \"block\"", "name = \"a/b\"", 0, &["body \"a/b\"; allowed is a name without"]),
        ("name = \"block\"", "mesh = \"a.obj\"", 0, &["`mesh` and `shape`; allowed is one of them"]),
        ("shape = {", "mesh = \"nowhere.obj\" #", 0, &["no file ./nowhere.obj", "relative to the scene"]),
        ("shape = {", "#", -1, &["body `block` has no model; allowed is one of `mesh` and `shape`"]),
        ("name = \"block\"", "name = \"block\"\nsize = 0", 1, &["size is 0 m; allowed is a number above 0"]),
        ("name = \"block\"", "name = \"block\"\nscale = nan", 1, &["scale is NaN; allowed is a number above 0"]),
        ("name = \"block\"", "name = \"block\"\nsize = 1\nscale = 1", 1, &["`size` and `scale`; allowed is one"]),
        ("name = \"block\"", "name = \"block\"\nposition = [0, inf, 0]", 1, &["inf is not finite", "a length"]),
        (
            "name = \"block\"",
            "name = \"block\"\nrotation = { axis = [0, 0, 0], angle = 1 }",
            1,
            &["rotation about [0.0, 0.0, 0.0]; allowed is an axis with a length"],
        ),
        ("cells = 8", "cells = 0", 0, &["cells is 0; allowed: 1 to 4096"]),
        ("cells = 8", "cells = 4000000000", 0, &["cells is 4000000000; allowed: 1 to 4096"]),
        ("[0.04, 0.04, 0.04]", "[0.04, 0, 0.04]", 0, &["size y is 0; allowed: a finite length above 0"]),
        ("[0.04, 0.04, 0.04]", "[0.04, nan, 0.04]", 0, &["NaN is not finite; allowed is a length"]),
        ("kind = \"box\"", "kind = \"torus\"", 0, &["`torus`", "`box`, `sphere`, `cylinder`"]),
        ("young = 1e4", "young = 0", 0, &["`young`: 0 Pa is out of range; allowed is 0.000001 to"]),
        ("young = 1e4", "young = nan", 0, &["`young`: NaN Pa is out of range"]),
        ("young = 1e4", "young = -1e300", 0, &["`young`: -1e300 Pa is out of range"]),
        ("young = 1e4", "density = 0", 0, &["`density`: 0 kg/m^3 is out of range; allowed is 0.000001 to 1000000"]),
        ("young = 1e4", "density = -1", 0, &["`density`: -1 kg/m^3 is out of range; allowed is 0.000001"]),
        ("young = 1e4", "density = nan", 0, &["`density`: NaN kg/m^3 is out of range"]),
        ("young = 1e4", "mode = \"other\"", 0, &["`mode`: `other` is not a choice; allowed is physical, paper"]),
        ("level = 4", "level = 0", 0, &["level 0", "a whole number from 1, or \"auto\""]),
        (
            "level = 4",
            "level = 99",
            0,
            &["octree-grid", "level 99", "GiB", "allowed are 1 to 10", "level 5, with cells of 2.500 mm"],
        ),
        ("level = 4", "level = 4294967295", 0, &["octree-grid", "level 4294967295", "allowed are 1 to 10"]),
        ("level = 4", "region = \"some\"", 0, &["`some`", "`local` or `whole`"]),
        ("level = 4", "radius = -1", 0, &["radius of the region is -1 m; allowed is a number above 0"]),
        ("level = 4", "relaxation = 0", 0, &["relaxation is 0 s; allowed is a number above 0"]),
    ]);
}

#[test]
fn fixed_nodes_that_make_no_sense_are_refused() {
    const BOX: &str = "box = [[-1, -1, -1], [1, 1, -0.019]]";
    const HELD: &str = "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.019]]";
    const WHOLE: &str = "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.019]]\npath = [[0, 0, 0, 0], [1, 0, 0, 0]]";
    const LED: &str = "path = [[0, 0, 0, 0], [1, 0, 0, 0]]";
    refuses(&[
        (
            "[[body.fixed]]\nbox = [[-1, -1, -1]",
            "[[body.fixed]]\nbox = [[2, 2, 2]",
            0,
            &["`box` goes from 2 m to 1 m", "the least corner first"],
        ),
        (
            HELD,
            "[[body.fixed]]",
            0,
            &[
                "`fixed` has no place; allowed is `box`, `ball` and `radius`, `group`, `nodes`, or `colour` or `texture`",
            ],
        ),
        (HELD, "[[body.fixed]]\nball = [0, 0, 0]", 0, &["`fixed` has `ball`; allowed is `box`"]),
        (HELD, "[[body.fixed]]\nball = [0, 0, 0]\nradius = -1", 0, &["radius is -1 m; allowed is a number above 0"]),
        (
            HELD,
            "[[body.fixed]]\nnodes = [1]",
            0,
            &["`nodes` of a local region", "allowed is `box`, `ball`, `group`, `colour` or `texture`"],
        ),
        (BOX, "box = [[0, 0, 0], [nan, 1, 1]]", 0, &["NaN is not finite; allowed is a length"]),
        (
            WHOLE,
            "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\npath = [[1, 0, 0, 0], [0, 0, 0, 0]]",
            0,
            &["row 2 of the path", "times rising"],
        ),
        (
            WHOLE,
            "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\npath = [[0, 0, inf, 0]]",
            0,
            &["row 1 of the path", "inf", "finite numbers"],
        ),
        (LED, "path = [[0, \"1 mm\", 0, 0]]", 0, &["string \"1 mm\"", "expected a number"]),
    ]);
}

#[test]
fn hands_that_make_no_sense_are_refused() {
    const FRAME: &str = "frame = { body = \"block\", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }";
    const PARAMS: &str = "params = { path = [[0.0, 0.0, 0.0, 0.006], [0.01, 0.0, 0.0, 0.001]] }";
    refuses(&[
        (
            PARAMS,
            "params = { path = [[1, 0, 0, 0], [0, 0, 0, 0]] }",
            0,
            &["`path`: row 2 is at 0 s, not after 1 s", "allowed are ascending times"],
        ),
        (PARAMS, "params = { path = [[0, 0, 0, 0], [0, 0, 0, 1]] }", 0, &["`path`: row 2 is at 0 s, not after 0 s"]),
        (PARAMS, "params = { path = [[0, 0, 0, nan]] }", 0, &["`path`: row 1 holds NaN; allowed is a finite number"]),
        (PARAMS, "params = { path = [] }", 0, &["neither `path` nor `recording`; allowed is one of them"]),
        (PARAMS, "params = {}", -2, &["neither `path` nor `recording`; allowed is one of them"]),
        (PARAMS, "params = { recording = \"no.csv\" }", 0, &["`recording`: ./no.csv: "]),
        (PARAMS, "params = { recording = \"\" }", 0, &["`recording`", "allowed is a file"]),
        (PARAMS, "params = { recording = \"scene.toml\" }", -2, &["scene.toml:3: not a number; allowed is time,x,y,z"]),
        (
            PARAMS,
            "params = { path = [[0, 0, 0, 0]], recording = \"scene.toml\" }",
            0,
            &["`path` and `recording`; allowed is one"],
        ),
        (
            PARAMS,
            "params = { path = [[0, 0, 0, 0]],\n buttons = [[1, 1], [0, 1]] }",
            1,
            &["`buttons`: row 2 is at 0 s"],
        ),
        (
            PARAMS,
            "params = { path = [[0, 0, 0, 0]], interpolation = \"cubic\" }",
            0,
            &["`cubic` is not a choice; allowed is linear, smooth"],
        ),
        (
            PARAMS,
            "params = { path = [[0, 0, 0, 0]], peak-force = 0 }",
            0,
            &["`peak-force`: 0 N is out of range; allowed is 1e-12 to 1e15 N"],
        ),
        (
            FRAME,
            "frame = { body = \"stone\", from = [0, 0, 2], toward = [0, 0, 0] }",
            0,
            &["no body `stone`; allowed is `block`"],
        ),
        (FRAME, "frame = { body = \"block\" }", 0, &["`body` alone; allowed is `body` with `from` and `toward`"]),
        (FRAME, "frame = { from = [0, 0, 2], toward = [0, 0, 0] }", -1, &["without `body`; allowed is all three"]),
        (
            FRAME,
            "frame = { body = \"block\", origin = [0, 0, 0], from = [0, 0, 2], toward = [0, 0, 0] }",
            0,
            &["`origin` and `body`; allowed is one"],
        ),
        (
            FRAME,
            "frame = { body = \"block\", from = [5, 5, 5], toward = [6, 6, 6] }",
            0,
            &[
                "the ray from [5.0, 5.0, 5.0]",
                "does not meet body `block`",
                "nearest miss",
                "at [1.000, 1.000, 1.000] of the box",
            ],
        ),
        (
            FRAME,
            "frame = { body = \"block\", from = [0, nan, 2], toward = [0, 0, 0] }",
            0,
            &["the ray from [0.0, NaN, 2.0]", "does not meet", "it is not finite"],
        ),
        (
            FRAME,
            "frame = { body = \"block\", from = [0.5, 0.5, 2], toward = [0.5, 0.5, 2] }",
            0,
            &["does not meet body `block`", "it has no length"],
        ),
        (FRAME, "frame = { scale = 0 }", 0, &["scale 0; allowed is a number above 0"]),
        (FRAME, "frame = { origin = [0, 0, nan] }", 0, &["NaN is not finite; allowed is a length"]),
        ("device = \"hand\"", "device = \"foot\"", 0, &["no device `foot`; allowed is `hand`"]),
        ("device = \"hand\"", "device = \"hand\"\neffector = 1", 1, &["effector 1, from 0; allowed is below 1"]),
        (
            "device = \"hand\"",
            "device = \"hand\"\nstiffness = 0",
            1,
            &["stiffness is 0 N/m; allowed is a number above 0"],
        ),
        ("device = \"hand\"", "device = \"hand\"\ndamping = -1", 1, &["damping is -1 N s/m; allowed is 0 or more"]),
        (
            "device = \"hand\"",
            "device = \"hand\"\nfriction = [0.1, 0.2]",
            1,
            &["friction [0.1, 0.2]; allowed is", "the first not lower"],
        ),
        ("device = \"hand\"", "device = \"hand\"\nfriction = [nan, nan]", 1, &["friction [NaN, NaN]; allowed is"]),
        ("device = \"hand\"", "device = \"hand\"\nspeed = 0", 1, &["speed is 0 m/s; allowed is a number above 0"]),
        ("device = \"hand\"", "device = \"hand\"\nslew = -5", 1, &["slew is -5 N/s; allowed is a number above 0"]),
        ("radius = \"4 mm\"", "radius = 0", 0, &["radius is 0 m; allowed is a number above 0"]),
        ("radius = \"4 mm\"", "", -2, &["tool `finger` has no shape", "allowed is `radius`"]),
    ]);
}

#[test]
fn edits_probes_and_outputs_that_make_no_sense_are_refused() {
    refuses(&[
        (
            "kind = \"touch\"",
            "kind = \"poke\"",
            0,
            &[
                "`poke`",
                "allowed is `touch`, `pull`, `cut`, `grab`,",
                "`shrink`, `pin`, `unpin`, `paint`, `stitch`, `undo`, `redo`",
            ],
        ),
        ("tool = \"finger\"", "tool = \"thumb\"", 0, &["no tool `thumb`; allowed is `finger`"]),
        ("tool = \"finger\"", "tool = \"finger\"\nstart = -1", 1, &["start is -1 s; allowed is 0 or more"]),
        (
            "tool = \"finger\"",
            "tool = \"finger\"\nstart = 0.5\nend = 0.1",
            2,
            &["end is 0.1 s; allowed is after the start"],
        ),
        ("tool = \"finger\"", "tool = \"finger\"\nlimit = 0", 1, &["limit is 0 N; allowed is a number above 0"]),
        ("tool = \"finger\"", "tool = \"finger\"\nbutton = 32", 1, &["button 32; allowed is 0 to 31"]),
        ("tool = \"finger\"", "tool = \"finger\"\nrelease = \"drop\"", 1, &["`drop`", "`spring-back` or `keep`"]),
        ("quantity = \"force\"", "quantity = \"colour\"", 0, &["`colour`", "`force`, `depth`, `displacement`"]),
        ("quantity = \"force\"", "quantity = \"displacement\"", -1, &["a probe of `displacement` needs `at`"]),
        (
            "quantity = \"force\"",
            "quantity = \"force\"\nof = \"thumb\"",
            1,
            &["no tool in use `thumb`; allowed is `finger`"],
        ),
        (
            "quantity = \"force\"",
            "quantity = \"force\"\ndirection = [0, 0, 0]",
            1,
            &["direction of a probe is [0.0, 0.0, 0.0]; allowed is finite numbers, not all 0"],
        ),
        (
            "quantity = \"force\"",
            "quantity = \"depth\"\ndirection = [0, 0, 1]",
            1,
            &["direction of `depth`, which is a number", "`force`, `displacement`, `torque`, `obstacle-force`"],
        ),
        ("quantity = \"force\"", "quantity = \"force\"\ntime = 3", 1, &["time is 3 s; allowed is 0 to 0.01 s"]),
        (
            "quantity = \"force\"",
            "quantity = \"force\"\ntolerance = 0",
            1,
            &["tolerance is 0; allowed is a number above 0"],
        ),
        (
            "quantity = \"force\"",
            "quantity = \"force\"\nexpected = nan",
            1,
            &["expected is NaN; allowed is a finite number"],
        ),
        ("trace = true", "frames = 0", 0, &["frames is 0 Hz; allowed is a number above 0"]),
        ("trace = true", "frames = nan", 0, &["NaN is not finite; allowed is a frequency"]),
    ]);
}

#[test]
fn blades_and_cuts() {
    refuses(&[
        ("kind = \"touch\"", "kind = \"cut\"", 1, &["tool `finger` cuts and has no `blade`"]),
        (
            "radius = \"4 mm\"",
            "radius = \"4 mm\"\nblade = { length = \"4 mm\", toughness = -1 }",
            1,
            &["toughness is -1 J/m^2; allowed is 0 or more"],
        ),
        (
            "radius = \"4 mm\"",
            "radius = \"4 mm\"\nblade = { length = 1, tear = -2 }",
            1,
            &["tear is -2 N; allowed is 0"],
        ),
        ("radius = \"4 mm\"", "radius = \"4 mm\"\nblade = { length = 0 }", 1, &["length of the blade is 0 m"]),
        (
            "radius = \"4 mm\"",
            "radius = \"4 mm\"\nblade = { length = 1, direction = [0, 0, 0] }",
            1,
            &["direction of the blade is [0.0, 0.0, 0.0]; allowed is finite numbers, not all 0"],
        ),
        (
            "radius = \"4 mm\"",
            "radius = \"4 mm\"\nblade = { length = 1, material = \"a b\" }",
            1,
            &["material \"a b\"; allowed is a name without spaces"],
        ),
        ("kind = \"touch\"", "kind = \"undo\"", 1, &["`undo` and `redo` have no tool"]),
    ]);
    let bench = Bench::new();
    bench.write("scene.toml", SCENE.replace("kind = \"touch\"\ntool = \"finger\"", "kind = \"cut\""));
    bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2).says(&["[[edit]] without `tool`"]);
}

#[test]
fn names_that_are_there_twice_are_refused() {
    for (table, rest) in [
        ("body", "shape = { kind = \"box\", size = [1, 1, 1] }\nmaterial = { plugin = \"mass-spring\" }"),
        ("device", ""),
        ("tool", "device = \"hand\"\nradius = 1"),
    ] {
        let name = match table {
            "body" => "block",
            "device" => "hand",
            _ => "finger",
        };
        let bench = Bench::new();
        bench.write("scene.toml", format!("{SCENE}[[{table}]]\nname = \"{name}\"\n{rest}\n"));
        let line = SCENE.lines().count() + 2;
        let place = format!("scene.toml:{line}:8: {table} `{name}` is there twice; allowed is one of each name");
        bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2).says(&[&place]);
        assert_eq!(bench.names("."), ["scene.toml"]);
    }
}

#[test]
fn an_explicit_step_over_its_limit_is_refused_with_the_number() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    for (integrator, sets) in [
        ("explicit-euler", &["time.substeps=1"][..]),
        ("symplectic-euler", &["time.substeps=1", "time.dt=0.02"]),
        ("symplectic-euler", &["time.dt=0.05", "time.most-substeps=4"]),
    ] {
        let set = format!("time.integrator={integrator}");
        let mut args = vec!["run", "scene.toml", "--out", "out", "--set", &set];
        sets.iter().for_each(|set| args.extend(["--set", set]));
        let said = ["stable up to a step of", "e-", "Allowed: a smaller dt", "backward-euler"];
        bench.pliant(&args).expect(2).says(&[integrator]).says(&said);
        assert_eq!(bench.names("."), ["scene.toml"]);
    }
}

#[test]
fn a_tool_and_its_mirror_image_are_named_once() {
    let bench = Bench::new();
    let mirrored = SCENE.replace("kind = \"touch\"", "kind = \"touch\"\nsymmetry = \"xz\"");
    bench.write("scene.toml", mirrored.replace("quantity = \"force\"", "quantity = \"force\"\nof = \"thumb\""));
    let ran = bench.pliant(&["plan", "scene.toml"]).expect(2).says(&["no tool in use `thumb`; allowed is `finger`\n"]);
    assert_eq!(ran.err.matches("`finger`").count(), 1, "{}", ran.err);
}
