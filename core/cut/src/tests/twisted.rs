//! Blades that turn a little from advance to advance, as those do that are mapped from a moving body to its rest shape.

use super::*;
use crate::snap::SNAPS;
use nalgebra::Rotation3;
use pliant_mesh::Surface;

/// Number of places along a blade.
const PLACES: usize = 64;

/// A blade drawn right through a body, in turns about its end, and again across that.
struct Drawn {
    document: ObjDocument,
    blades: Vec<Blade>,
    across: Vec<Blade>,
}

impl Drawn {
    fn new(number: u64) -> Self {
        let random = &mut Random(number);
        let document = body(random);
        let bounds = Surface::from_document(&document).bounds();
        let size = bounds.longest_edge();
        let along = random.direction();
        let way = along.cross(&random.direction()).normalize();
        let steps = 40 + random.below(60) as u32;
        let turn = size / f64::from(steps) * random.pick(&[0.01, 0.05, 0.3]);
        let middle = bounds.centre() + 0.25 * size * random.signed() * along.cross(&way);
        let draw = |way: Vec3, random: &mut Random| {
            let aside = along.cross(&way);
            let mut off = [0.0; 2];
            let blades = (0..=steps).map(|step| {
                let at = middle + (1.8 * f64::from(step) / f64::from(steps) - 0.9) * size * way;
                off = off.map(|off| 0.8 * off + turn * random.signed());
                blade(at - 2.0 * size * along + off[0] * aside, at + 2.0 * size * along + off[1] * aside)
            });
            blades.collect()
        };
        let blades = draw(way, random);
        let angle = 0.2 + 1.3 * random.unit();
        let across = draw(Rotation3::new(angle * along) * way, random);
        Self { document, blades, across }
    }
}

/// Number of places along a blade, moved back by a tenth of its way, that are inside of a body and not cut within `aside`, m.
fn count_uncut(mesh: &CutMesh, [from, to]: [&Blade; 2], aside: f64) -> usize {
    let back = blade(to.tip.lerp(&from.tip, 0.1), to.heel.lerp(&from.heel, 0.1));
    let normal = (to.heel - to.tip).cross(&(to.tip - from.tip + to.heel - from.heel)).normalize();
    let places = (0..PLACES).map(|i| back.tip.lerp(&back.heel, (i as f64 + 0.5) / PLACES as f64));
    let is_uncut = |at: &Vec3| {
        let ends = [-aside, aside].map(|by| at + by * normal);
        ends.iter().all(|end| mesh.encloses(*end)) && !mesh.is_crossed(ends[0], ends[1])
    };
    places.filter(is_uncut).count()
}

/// Where every strip is cut without a bridge, the body is in parts: nothing is left across the seams of two strips. Few strips cannot be cut so.
#[test]
fn what_is_cut_cleanly_is_in_parts() {
    let (mut clean, mut advances, mut refused, mut joined) = (0, 0, 0, Vec::new());
    for number in 0..100 {
        let Drawn { document, blades, .. } = Drawn::new(number);
        let mut whole = cut_mesh(&document);
        let mut stroke = Stroke::begin(blades[0]).unwrap();
        let once = whole.advance(&mut stroke, blades[blades.len() - 1]);
        if once.is_err() || whole.parts().all.len() < 2 {
            continue;
        }
        let mut mesh = cut_mesh(&document);
        let sums = Sums::new(&mesh);
        let mut stroke = Stroke::begin(blades[0]).unwrap();
        let mut bridges = 0;
        for blade in &blades[1..] {
            advances += 1;
            if mesh.advance_cleanly(&mut stroke, *blade, 0.0).is_err() {
                bridges += 1;
                // What is refused all the same is cut with the next strip.
                _ = mesh.advance(&mut stroke, *blade);
            }
        }
        sums.check(&mesh);
        refused += bridges;
        if bridges == 0 {
            clean += 1;
            if mesh.parts().all.len() < 2 {
                joined.push(number);
            }
        }
    }
    println!(
        "{refused} of {advances} strips refused; {clean} strokes without a bridge, of which {joined:?} hold together"
    );
    assert!(joined.is_empty(), "{joined:?} of {clean} hold together");
    // Where an edge of the surface runs nearly along the plane, a line may miss the end of the last strip however it is snapped.
    assert!(clean >= 75 && 100 * refused < advances, "{refused} of {advances} refused, {clean} without");
}

/// Triangles of the walls of the first cut are as long as the body is thick, far longer than a strip of the second is wide. Lines on them end with the strip all the same.
#[test]
fn a_strip_that_crosses_an_earlier_cut_is_cut_up_to_its_blade() {
    let (mut strips, mut uncut) = (0, Vec::new());
    for number in 0..50 {
        let Drawn { document, blades, across } = Drawn::new(number);
        let mut mesh = cut_mesh(&document);
        // The widest tolerances, with which a strip is cut where narrower ones refuse it, are taken first.
        mesh.snaps = [SNAPS[1], SNAPS[1], SNAPS[2]];
        let size = mesh.surface().bounds().longest_edge();
        let mut stroke = Stroke::begin(blades[0]).unwrap();
        blades[1..].iter().for_each(|blade| _ = mesh.advance(&mut stroke, *blade));
        let mut stroke = Stroke::begin(across[0]).unwrap();
        for to in &across[1..] {
            let from = stroke.blade();
            if mesh.advance_cleanly(&mut stroke, *to, 0.0).is_ok() {
                strips += 1;
                let count = count_uncut(&mesh, [&from, to], 0.01 * size);
                if count > 0 {
                    uncut.push((number, count));
                }
            }
        }
    }
    println!("{strips} strips, of which {uncut:?} (case, places) are not cut up to the blade");
    assert!(uncut.is_empty(), "{uncut:?}");
}
