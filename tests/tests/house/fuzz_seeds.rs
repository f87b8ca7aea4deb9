//! The fuzz targets over their seeds, whole, cut short and with bytes changed, on the stable compiler.

use pliant_mesh::testing::Random;
use pliant_tests::root;

#[path = "../../../fuzz/src/lib.rs"]
mod targets;

type Target = fn(&[u8]);

/// Runs a target over its seeds; gives how many seeds there are.
fn run(name: &str, target: Target) -> usize {
    let folder = root().join("fuzz/seeds").join(name);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())).flatten();
    let mut seeds: Vec<_> = entries.map(|entry| entry.path()).collect();
    seeds.sort();
    let mut random = Random(1);
    for seed in &seeds {
        let bytes = std::fs::read(seed).unwrap_or_else(|e| panic!("{}: {e}", seed.display()));
        target(&bytes);
        for _ in 0..200 {
            let mut damaged = bytes[..random.below(bytes.len() as u64 + 1) as usize].to_vec();
            target(&damaged);
            damaged.clone_from(&bytes);
            for _ in 0..=random.below(4).min(damaged.len() as u64) {
                if !damaged.is_empty() {
                    let at = random.below(damaged.len() as u64) as usize;
                    damaged[at] = random.next_u64() as u8;
                }
            }
            target(&damaged);
        }
    }
    seeds.len()
}

#[test]
fn no_target_fails_on_its_seeds() {
    let all: [(&str, Target); 9] = [
        ("obj", targets::obj),
        ("tetrahedra", targets::tetrahedra),
        ("image", targets::image),
        ("scene", targets::scene),
        ("sweep", targets::sweep),
        ("journal", targets::journal),
        ("recording", targets::recording),
        ("datagram", targets::datagram),
        ("quantity", targets::quantity),
    ];
    for (name, target) in all {
        assert!(run(name, target) > 0, "{name} has no seeds");
    }
}
