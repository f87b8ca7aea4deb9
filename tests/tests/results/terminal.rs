//! What a file, a scene or a name holds cannot act on the terminal: control characters reach standard output and standard error as codes.

use pliant_tests::models::CUBE;
use pliant_tests::{Bench, Ran, box_scene};

/// Characters that act on a terminal and that a TOML string or an OBJ token can hold: ESC, BEL, backspace, DEL, and CSI in one character.
const ACTING: [char; 5] = ['\u{1b}', '\u{7}', '\u{8}', '\u{7f}', '\u{9b}'];

/// The run, if nothing it printed acts on a terminal.
fn shown(ran: Ran) -> Ran {
    for text in [&ran.out, &ran.err] {
        let acts = |c: &char| c.is_control() && !"\n\t".contains(*c);
        assert_eq!(text.chars().find(acts), None, "{text:?}");
    }
    ran
}

/// How a character is printed.
fn code(character: char) -> String {
    format!("\\u{:04x}", u32::from(character))
}

/// The box scene with a file `model.obj` in the place of the box.
fn with_model() -> String {
    box_scene("", "", "").replace(
        "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }",
        "mesh = \"model.obj\"\nsize = \"40 mm\"",
    )
}

#[test]
fn a_token_of_a_model_is_shown_as_codes() {
    for acting in ACTING {
        let bench = Bench::new();
        bench.write("scene.toml", with_model());
        let model = CUBE.replace("v 1 1 1", &format!("v 1 1{acting}]2;title 1"));
        bench.write("model.obj", model);
        let token = format!("`1{}]2;title`", code(acting));
        for verb in ["run", "plan"] {
            shown(bench.pliant(&[verb, "scene.toml"]).expect(2)).says(&["model.obj:7:", &token]);
        }
        let told = shown(bench.pliant(&["plan", "scene.toml", "--json"]).expect(2)).json();
        assert!(told["error"].as_str().unwrap().contains(&format!("`1{acting}]2;title`")), "JSON says what it is");
    }
}

#[test]
fn a_name_of_a_group_stays_in_the_file_and_does_not_act_on_the_terminal() {
    for acting in ACTING {
        let bench = Bench::new();
        bench.write("model.obj", CUBE.replace("f 4 3", &format!("g left{acting}[31m\nf 4 3")));
        bench.write("scene.toml", with_model());
        shown(bench.pliant(&["plan", "scene.toml"]).expect(0));
        shown(bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(0));
        let (model, group) = (bench.read("out/final.obj"), format!("g left{acting}[31m\n"));
        assert!(model.windows(group.len()).any(|bytes| bytes == group.as_bytes()), "{acting:?}");
    }
}

#[test]
fn a_name_of_a_probe_is_shown_as_codes_and_lines_stay_lines() {
    for acting in ACTING {
        let bench = Bench::new();
        let name = format!("most\\u{:04x}[1A", u32::from(acting));
        let probe = format!("[[probe]]\nname = \"{name}\"\nquantity = \"force\"\ngreatest = true");
        bench.write("scene.toml", box_scene("", "", &probe));
        let ran = shown(bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(0));
        let shown_name = format!("most{}[1A", code(acting));
        assert!(ran.err.lines().any(|line| line.starts_with(&format!("probe {shown_name}:"))), "{}", ran.err);
        let json = shown(bench.pliant(&["run", "scene.toml", "--json", "--out", "out"]).expect(0)).json();
        assert_eq!(json["probes"][0]["name"], format!("most{acting}[1A"), "JSON says what it is");
        let wrong = box_scene("", "", &probe).replace("\"force\"", "\"farce\"");
        bench.write("scene.toml", wrong);
        let ran = shown(bench.pliant(&["run", "scene.toml"]).expect(2));
        let caret = ran.err.lines().last().unwrap_or_default();
        assert!(caret.trim_start().starts_with('|') && caret.ends_with('^'), "{}", ran.err);
    }
}
