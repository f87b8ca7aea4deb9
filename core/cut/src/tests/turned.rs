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
            match mesh.advance_cleanly(&mut stroke, blade, 0.0) {
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

/// A fan that leaves its plane by up to 4 degrees, as one of a hand that turns freely. Where no strip is refused the body is in parts; so it is in most of the fans.
#[test]
fn a_fan_that_bends_is_cut_cleanly() {
    let (mut strips, mut refused, mut clean, mut joined) = (0, 0, 0, Vec::new());
    for number in 0..60 {
        let random = &mut Random(number);
        let document = body(random);
        let bounds = Surface::from_document(&document).bounds();
        let (size, middle) = (bounds.longest_edge(), bounds.centre());
        let back = random.direction();
        let way = back.cross(&random.direction()).normalize();
        let aside = back.cross(&way);
        let distance = (1.5 + 1.5 * random.unit()) * size;
        // Tangent of the angle by which the middle of the fan is bent: up to 4 degrees.
        let bend = 0.07 * random.signed();
        let pointing = |share: f64| {
            let along = 2.0 * share - 1.0;
            let tip = middle - size * back + 2.0 * along * size * way;
            let to_eye = (middle + distance * back - tip).normalize();
            blade(tip, tip + (distance + 3.0 * size) * (to_eye + bend * (1.0 - along * along) * aside).normalize())
        };
        let mut mesh = cut_mesh(&document);
        let mut stroke = Stroke::begin(pointing(0.0)).unwrap();
        let (steps, before) = (80 + random.below(80), refused);
        for step in 1..=steps {
            strips += 1;
            if mesh.advance_cleanly(&mut stroke, pointing(step as f64 / steps as f64), 0.0).is_err() {
                refused += 1;
            }
        }
        if refused == before {
            clean += 1;
            if mesh.parts().all.len() < 2 {
                joined.push(number);
            }
        }
    }
    println!("{refused} of {strips} strips refused; {clean} fans with none, of which {joined:?} hold together");
    assert!(joined.is_empty(), "{joined:?}");
    // Near the place about which the blade turns the two triangles of a strip are turned against each other.
    assert!(clean >= 30, "{refused} of {strips}, {clean}");
}
