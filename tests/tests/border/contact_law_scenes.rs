//! Contact laws in scenes: what is refused and where, what is said of a law, and runs that are recorded, replayed and undone.

use pliant_tests::{Bench, box_scene, warning_codes};

/// A block pressed by a finger with these keys.
fn scene(tool: &str) -> String {
    box_scene("integrator = \"backward-euler\"", "", "").replace("radius = \"4 mm\"", tool)
}

const LAW: &str = r#"contact-law = { plugin = "contact-laws#rate-and-state", params = { stiffness = 1e7 } }"#;

#[test]
fn a_law_that_cannot_be_used_is_refused_at_its_line_with_what_can() {
    let cases: [(&str, &str, &[&str]); 7] = [
        (
            "radius = \"4 mm\"\ncontact-law = { plugin = \"mass-spring\" }",
            "mass-spring",
            &["no contact-law `mass-spring`", "it has material `mass-spring`"],
        ),
        (
            "radius = \"4 mm\"\ncontact-law = { plugin = \"contact-laws#hunt-crossley\", params = { dissipation = -1 } }",
            "dissipation = ",
            &["parameter `dissipation`", "-1 s/m is out of range", "0 to 1000"],
        ),
        (
            "radius = \"4 mm\"\ncontact-law = { plugin = \"contact-laws#hunt-crossley\", params = { stifness = 1 } }",
            "stifness = ",
            &["no parameter `stifness`", "allowed is stiffness"],
        ),
        (
            "radius = \"4 mm\"\ncontact-law = { plugin = \"contact-laws\" }",
            "contact-laws",
            &["no contact-law `contact-laws`", "contact-law `hunt-crossley`, contact-law `rate-and-state`"],
        ),
        (
            "radius = \"0.2 mm\"\ncontact-law = { plugin = \"contact-laws#hunt-crossley\" }",
            "contact-laws#hunt",
            &[
                "solid `block`",
                "cells of 2.500 mm are wider",
                "0.200 mm",
                "allowed is a law on a solid with finer cells",
            ],
        ),
        (
            "radius = \"4 mm\"\nfriction = [0.3, 0.3]\ncontact-law = { plugin = \"contact-laws#hunt-crossley\" }",
            "[0.3, 0.3]",
            &["`friction` of a tool with the contact law", "allowed is one of them"],
        ),
        (
            "radius = \"4 mm\"\nsheets = \"vertices\"\ncontact-law = { plugin = \"contact-laws#hunt-crossley\" }",
            "\"vertices\"",
            &["`sheets` of a tool with the contact law", "allowed is \"penalty\""],
        ),
    ];
    for (tool, at, said) in cases {
        let text = scene(tool);
        let tool = text.find(tool).expect("it is there");
        let offset = tool + text[tool..].find(at).expect("it is there");
        let line = text[..offset].matches('\n').count() + 1;
        let bench = Bench::new();
        bench.write("scene.toml", &text);
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2);
        assert!(ran.err.starts_with(&format!("error: scene.toml:{line}:")), "line {line}: {}", ran.err);
        ran.says(said);
    }
}

#[test]
fn a_plan_says_where_a_law_acts_and_that_one_of_a_tool_that_touches_nothing_is_left_out() {
    let bench = Bench::new();
    bench.write("scene.toml", scene(&format!("radius = \"4 mm\"\n{LAW}")));
    let plan = bench.pliant(&["plan", "scene.toml"]).expect(0).out;
    for part in [
        "contact of tool `finger` with body `block`: law `rate-and-state`: a contact law acts at samples of the surface",
        "contact-law `rate-and-state` 0.1.0 from ",
        "friction and restitution of tool `finger`: its contact law has its own",
    ] {
        assert!(plan.contains(part), "`{part}` is not in\n{plan}");
    }
    let pulls = scene(&format!("radius = \"4 mm\"\n{LAW}")).replace("kind = \"touch\"", "kind = \"pull\"");
    bench.write("scene.toml", pulls);
    let plan = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
    let mut left_out = plan["left_out"].as_array().expect("a list").iter();
    assert!(left_out.any(|part| part["what"] == "contact law `rate-and-state` of tool `finger`"), "{plan}");
    let tip = "radius = \"1 mm\"\ncontact-law = { plugin = \"contact-laws#hunt-crossley\" }";
    let sheet = scene(tip).replace(
        "material = { plugin = \"mass-spring\" }\ngrid = { level = 5 }",
        "sheet = { warp = [1, 0, 0] }\nmaterial = { plugin = \"cloth\" }",
    );
    bench.write("scene.toml", sheet);
    bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(0);
    let codes = warning_codes(&bench.summary("out"));
    assert!(codes.iter().any(|code| code == "coarse-sheet"), "{codes:?}");
}

#[test]
fn a_recorded_session_with_a_history_comes_back_to_the_bit() {
    for tool in [format!("radius = \"4 mm\"\n{LAW}"), format!("shape = {{ kind = \"plane\" }}\n{LAW}")] {
        let is_sheet = tool.contains("plane");
        let mut text = scene(&tool);
        if is_sheet {
            text = text.replace(
                "kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04]",
                "kind = \"sheet\", cells = 12, size = [0.04, 0.04, 0]",
            );
            text = text.replace(
                "material = { plugin = \"mass-spring\" }\ngrid = { level = 5 }",
                "sheet = { warp = [1, 0, 0] }\nmaterial = { plugin = \"cloth\" }\nposition = [0, 0, 0.02]",
            );
            text =
                text.replace("frame = { body = \"block\", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }", "");
            text = text.replace(
                "[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]",
                "[0.0, 0.0, 0.0, 0.019], [0.03, 0.0, 0.0, 0.022], [0.05, 0.002, 0.0, 0.021]",
            );
        }
        let bench = Bench::new();
        bench.write("scene.toml", text);
        bench
            .pliant(&["run", "scene.toml", "-q", "--out", "first", "--record", "hand.rec", "--threads", "1"])
            .expect(0);
        assert!(bench.summary("first")["largest_force"].as_f64().expect("a force") > 1e-4, "it touches");
        bench
            .pliant(&["replay", "hand.rec", "--verify", "--out", "again", "--threads", "2", "--oversubscribe"])
            .expect(0);
        assert_eq!(bench.read("first/final.obj"), bench.read("again/final.obj"), "{tool}");
    }
}

#[test]
fn what_follows_an_undo_is_what_follows_a_new_contact() {
    // A grown bump is taken back while the hand is away; the press after it is that of a scene without the bump.
    let with = |bump: &str| {
        let text = scene(&format!("radius = \"4 mm\"\n{LAW}")).replace("duration = 0.05", "duration = 0.12");
        let path = "[[0.0, 0.0, 0.0, 0.006], [0.01, 0.0, 0.0, 0.003], [0.04, 0.001, 0.0, 0.003], [0.05, 0.0, 0.0, 0.01], \
                    [0.08, 0.0, 0.0, 0.01], [0.09, 0.0, 0.0, 0.003], [0.12, 0.001, 0.0, 0.003]]";
        let start = text.find("path = [[").expect("a path");
        let end = start + text[start..].find("]] }").expect("its end");
        let text = format!("{}path = {path}{}", &text[..start], &text[end + 2..]);
        let touch = "[[edit]]\nkind = \"touch\"\ntool = \"finger\"";
        let text = text.replace(touch, &format!("{bump}{touch}\nstart = 0.075"));
        let bench = Bench::new();
        bench.write("scene.toml", text);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--threads", "1"]).expect(0);
        (bench.read("out/final.obj"), bench.summary("out"))
    };
    let bump = "[[edit]]\nkind = \"grow\"\ntool = \"finger\"\nstrength = 0.5\nend = 0.045\n[[edit]]\nkind = \"undo\"\nstart = 0.07\n";
    let (undone, summary) = with(bump);
    let (alone, _) = with("");
    let history = summary["event_counts"]["history"].as_u64().unwrap_or(0);
    assert_eq!(history, 1, "{}", summary["events"]);
    assert_eq!(undone, alone, "a contact after an undo has no memory of those before it");
}

/// Obstacles have no contact law: a key for one is an error that says what they have.
#[test]
fn a_law_of_an_obstacle_is_refused_by_name() {
    let bench = Bench::new();
    for key in ["contact-law", "law"] {
        let obstacle = format!(
            "[[obstacle]]\nname = \"floor\"\nshape = {{ kind = \"plane\" }}\n{key} = {{ plugin = \"contact-laws#hunt-crossley\" }}\n"
        );
        bench.write("scene.toml", format!("{}\n{obstacle}", scene("radius = \"4 mm\"")));
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2);
        ran.says(&["scene.toml:", &format!("unknown field `{key}`"), "`friction`, `restitution`"]);
    }
}
