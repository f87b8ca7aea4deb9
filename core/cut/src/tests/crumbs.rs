//! Parts that are too small to be of any use are not separated where the caller says so.

use super::*;

/// A blade right through a body of about the size 1, from beside it to beside it, in a plane that lies near the end of the body in a direction.
fn slice(random: &mut Random, mesh: &CutMesh) -> [Blade; 2] {
    let out = random.direction();
    let along = out.cross(&random.direction()).normalize();
    let across = out.cross(&along);
    let reach = mesh.surface().points.iter().map(|x| x.dot(&out)).fold(f64::NEG_INFINITY, f64::max);
    let at = (reach - 0.2 * random.unit().powi(2)) * out;
    [-3.0, 3.0].map(|side| blade(at + side * along - 3.0 * across, at + side * along + 3.0 * across))
}

#[test]
fn slices_are_refused_if_they_are_smaller_than_a_crumb() {
    let random = &mut Random(53);
    let mut counts = [0; 2];
    for number in 0..200 {
        let document = body(random);
        let mut mesh = cut_mesh(&document);
        let whole = mesh.surface().volume();
        let [from, to] = slice(random, &mesh);
        let crumb = 10_f64.powf(-6.0 + 4.0 * random.unit()) * whole;
        let mut stroke = Stroke::begin(from).unwrap();
        let before = (mesh.surface().clone(), mesh.depth());
        let cleanly = mesh.advance_cleanly(&mut stroke, to, crumb);
        if let Err(refused) = &cleanly {
            assert_eq!(refused.reason, Refusal::Crumb, "{number}");
            assert_eq!((mesh.surface(), mesh.depth(), stroke.blade()), (&before.0, before.1, from), "{number}");
            mesh.advance(&mut stroke, to).unwrap();
        }
        let parts = mesh.parts().all;
        let smallest = parts.iter().map(|part| part.volume).fold(f64::INFINITY, f64::min);
        counts[usize::from(cleanly.is_err())] += 1;
        // A refused strip was tried with other snapping, which moves the cut by up to a fiftieth of an edge.
        let is_crumb = if cleanly.is_err() { smallest < 1.5 * crumb } else { parts.len() == 1 || smallest >= crumb };
        assert!(is_crumb, "{number}: the smallest part is {:.3} of a crumb: {cleanly:?}", smallest / crumb);
    }
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
}

#[test]
fn parts_of_a_body_that_is_hardly_larger_than_a_crumb_are_none() {
    let random = &mut Random(54);
    for number in 0..50 {
        let mut mesh = cut_mesh(&body(random));
        let whole = mesh.surface().volume();
        let middle = mesh.surface().bounds().centre();
        let (along, across) = (random.direction(), random.direction());
        let across = across.cross(&along).normalize();
        let [from, to] =
            [-3.0, 3.0].map(|side| blade(middle + side * along - 3.0 * across, middle + side * along + 3.0 * across));
        let cut = mesh.advance_cleanly(&mut Stroke::begin(from).unwrap(), to, 2.0 * whole);
        assert!(cut.is_ok(), "{number}: {cut:?}");
    }
}
