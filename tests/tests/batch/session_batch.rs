//! Sessions that are stepped together do what each would alone.

use pliant_batch::{FailureClass, SceneInstance, SessionBatch};
use pliant_engine::scene::load_text;
use pliant_host::SearchPath;
use pliant_tests::batch::small_scene;
use pliant_tests::{deps, open};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Young's moduli of the instances, kPa.
const YOUNG: [u32; 5] = [5, 8, 12, 20, 40];

fn scene(young: u32) -> SceneInstance {
    let setting = ("body.0.material.params.young".to_owned(), format!("\"{young} kPa\""));
    let (scene, source) = load_text(Path::new("scene.toml"), small_scene(), &[setting]).unwrap();
    SceneInstance { scene, source }
}

fn batch(jobs: usize) -> SessionBatch {
    let scenes = YOUNG.into_iter().map(scene).collect();
    SessionBatch::open(scenes, &SearchPath::new(&[deps()]), jobs, &[]).unwrap_or_else(|(n, why)| panic!("{n}: {why:?}"))
}

#[test]
fn instances_have_the_bytes_of_sessions_of_their_own_for_any_number_of_threads() {
    for jobs in [1, 2, 3, 8] {
        let mut batch = batch(jobs);
        let runs = batch.run(&AtomicBool::new(false));
        assert!(batch.failures().is_empty());
        for (number, young) in YOUNG.into_iter().enumerate() {
            let SceneInstance { scene, source } = scene(young);
            let mut alone = open(&source.text, 1);
            let mut force = Vec::new();
            for _ in 0..scene.time.steps() {
                alone.step();
                force.push(alone.frame().tools[0].force);
            }
            assert_eq!(runs[number].tools[0].force, force, "{young} kPa, {jobs} at a time");
            assert_eq!(batch.session(number).unwrap().bodies[0].system.nodes.x, alone.bodies[0].system.nodes.x);
        }
    }
}

#[test]
fn a_scene_that_cannot_be_opened_is_told_by_its_number() {
    let mut scenes: Vec<SceneInstance> = YOUNG.into_iter().map(scene).collect();
    let setting = ("body.0.material.plugin".to_owned(), "\"no-such-material\"".to_owned());
    let (scene, source) = load_text(Path::new("scene.toml"), small_scene(), &[setting]).unwrap();
    scenes[3] = SceneInstance { scene, source };
    let (number, failure) = SessionBatch::open(scenes, &SearchPath::new(&[deps()]), 2, &[]).err().unwrap();
    assert_eq!((number, failure.class), (3, FailureClass::Plugin));
    assert!(failure.message.contains("no-such-material"), "{failure:?}");
}

#[test]
fn a_batch_that_is_stopped_goes_on_where_it_was() {
    let (mut whole, mut parts) = (batch(2), batch(2));
    whole.step(10, &AtomicBool::new(false));
    parts.step(4, &AtomicBool::new(false));
    parts.step(5, &AtomicBool::new(true));
    parts.step(6, &AtomicBool::new(false));
    for number in 0..YOUNG.len() {
        let [a, b] = [&whole, &parts].map(|batch| batch.session(number).unwrap());
        assert_eq!((a.steps(), b.steps()), (10, 10));
        assert_eq!(a.bodies[0].system.nodes.x, b.bodies[0].system.nodes.x);
    }
}
