//! Blades that turn about a place on them outside of the body, as those do that point to the eye of a viewer.

use super::*;
use pliant_mesh::Surface;

/// Strips of a fan cut the same area as its plane at once: none of them reaches back behind the last one.
#[test]
fn a_fan_of_blades_cuts_its_plane_and_no_more() {
    let (mut fans, mut parted, mut refused) = (0, 0, 0);
    for number in 0..60 {
        let random = &mut Random(number);
        let document = body(random);
        let bounds = Surface::from_document(&document).bounds();
        let (size, middle) = (bounds.longest_edge(), bounds.centre());
        let back = random.direction();
        let way = back.cross(&random.direction()).normalize();
        let eye = middle + (1.0 + 2.0 * random.unit()) * size * back + 0.2 * size * random.signed() * back.cross(&way);
        // The blade goes on beyond the eye.
        let length = (eye - middle).norm() + (1.5 + 3.0 * random.unit()) * size;
        let pointing = |share: f64| {
            let tip = middle - size * back + (2.0 * share - 1.0) * 3.0 * size * way;
            blade(tip, tip + length * (eye - tip).normalize())
        };
        let mut whole = cut_mesh(&document);
        let mut stroke = Stroke::begin(pointing(0.0)).unwrap();
        let Ok(once) = whole.advance(&mut stroke, pointing(1.0)) else { continue };
        let mut mesh = cut_mesh(&document);
        let sums = Sums::new(&mesh);
        let mut stroke = Stroke::begin(pointing(0.0)).unwrap();
        let (steps, mut area, before) = (60 + random.below(60), 0.0, refused);
        for step in 1..=steps {
            let blade = pointing(step as f64 / steps as f64);
            match mesh.advance_without_bridges(&mut stroke, blade) {
                Ok(advance) => area += advance.area,
                // It is cut with the next strip.
                Err(_) => refused += 1,
            }
        }
        sums.check(&mesh);
        fans += 1;
        // Vertices are snapped by up to a hundredth of an edge.
        assert!((area / once.area - 1.0).abs() < 0.01, "{number}: {area} of {} m^2", once.area);
        if refused == before {
            assert_eq!(mesh.parts().all.len(), whole.parts().all.len(), "{number}");
            parted += 1;
        }
    }
    println!("{fans} fans, {parted} of them with no strip refused; {refused} strips refused");
    assert!(fans >= 50 && 2 * parted > fans, "{fans}, {parted}");
}
