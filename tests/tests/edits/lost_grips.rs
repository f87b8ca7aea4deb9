//! A hand that pulls with more than the limit lets go once, holds nothing for the rest of the stroke, and takes hold again in the next.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, open_file};

#[test]
fn a_grip_over_its_limit_is_lost_until_the_next_stroke() {
    let mut random = Random(5);
    for case in 0..8 {
        let kind = ["pull", "grab"][case % 2];
        let plugin = ["mass-spring", "neo-hookean"][case / 2 % 2];
        // Tools below and above the edge of a cell pull a point and a region.
        let (tool, level) = (0.002 + 0.006 * random.unit(), 4 + (random.unit() * 3.0) as usize);
        let what = format!("case {case}: {kind} of {plugin}, tool of {tool:.4} m, level {level}");
        let edit = |keys: &str| format!("[[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\n{keys}\n");
        let text = format!(
            "format = 1\n[time]\nduration = 0.3\ndt = \"2 ms\"\n[[body]]\nshape = {{ kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }}\n\
             grid = {{ level = {level} }}\nmaterial = {{ plugin = \"{plugin}\", params = {{ young = 2e4, damping-time = \"2 ms\" }} }}\n\
             [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.01]]\n[[device]]\nname = \"hand\"\n\
             params = {{ peak-force = \"50 N\", path = [[0, 0, 0, 0.02], [0.1, 0.001, 0, 0.03], [0.14, 0, 0, 0.02], [0.2, 0, 0, 0.02], [0.3, 0, 0, 0.022]] }}\n\
             [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = {tool}\n{}{}",
            edit("end = 0.18\nlimit = 0.1"),
            edit("start = 0.2\nlimit = 50"),
        );
        let bench = Bench::new();
        let mut session: Session = open_file(&bench.write("scene.toml", text), 1, None);
        let held: Vec<bool> = (0..150)
            .map(|_| {
                session.step();
                session.tools[0].tool.contact().is_some()
            })
            .collect();
        let lost = held.iter().position(|held| !held).unwrap_or_else(|| panic!("{what}: it never lets go"));
        assert!((1..60).contains(&lost), "{what}: it lets go in step {lost}");
        assert!(held[lost..90].iter().all(|held| !held), "{what}: it takes hold again in the same stroke");
        assert!(held[101..].iter().all(|held| *held), "{what}: it takes hold in the next");
        assert_eq!(session.events.count(EventKind::GripLost), 1, "{what}");
    }
}
