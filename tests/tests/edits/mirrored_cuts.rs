//! Cuts with symmetry: blades that would cut the same cut once, blades that cross each other cut both lines.

use crate::ball_cuts::{LEVEL, RADIUS, cut_ball, result};
use pliant_mesh::testing::Random;
use pliant_solver::Vec3;

#[test]
fn a_line_along_the_plane_of_symmetry_cuts_once_and_one_across_twice() {
    let mut random = Random(49);
    let edge = 2.0 * RADIUS / f64::from(1 << LEVEL);
    for case in 0..8 {
        // As far from the plane as makes the blades go along with each other, and farther.
        let (near, far) = (0.12 * edge * random.signed(), (0.2 + random.unit()) * edge);
        let x = if case % 2 == 0 { near } else { far };
        let line = [1.5, -1.5].map(|share| Vec3::new(x, share * RADIUS, 0.0));
        let (alone, mirrored) = (result(&cut_ball(&[line], false)), result(&cut_ball(&[line], true)));
        let [parts, times] = if case % 2 == 0 { [2, 1] } else { [3, 2] };
        assert_eq!((alone.0, mirrored.0), (2, parts), "case {case}, at {x} m");
        let off = mirrored.1 / (f64::from(times) * alone.1) - 1.0;
        assert!(off.abs() < 0.03, "case {case}, at {x} m: the area is off by {off}");
    }
    for case in 0..4 {
        // Straight across, so that both blades cut one plane from its two ends.
        let (y, rise) = (0.5 * RADIUS * random.signed(), [0.0, 1e-4][case % 2] * random.signed());
        let line = [-1.5, 1.5].map(|share| Vec3::new(share * RADIUS, y + share * rise, 0.0));
        let (alone, mirrored) = (result(&cut_ball(&[line], false)), result(&cut_ball(&[line], true)));
        // Where both blades have cut the same stride, up to two crumbs of it are left.
        assert!(alone.0 == 2 && (2..=4).contains(&mirrored.0), "case {case}, at {y} m, {rise}: {} parts", mirrored.0);
        // Either blade joins its cut to the other one by a strip through the wall, which may wait for three strides.
        let most = alone.1 + 8.0 * 0.25 * edge * 2.0 * RADIUS;
        assert!((0.99 * alone.1..most).contains(&mirrored.1), "case {case}, at {y} m, {rise}: {alone:?}, {mirrored:?}");
    }
    for case in 0..4 {
        let slope = (0.3 + 0.7 * random.unit()) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let line = [-1.5, 1.5].map(|share| Vec3::new(share * RADIUS, slope * share * RADIUS, 0.0));
        let (alone, mirrored) = (result(&cut_ball(&[line], false)), result(&cut_ball(&[line], true)));
        // The blades lag behind their hands, so that a sliver may be left where they cross.
        assert!(alone.0 == 2 && mirrored.0 >= 4, "case {case}, slope {slope}: {alone:?}, {mirrored:?}");
        let off = mirrored.1 / (2.0 * alone.1) - 1.0;
        assert!(off.abs() < 0.03, "case {case}, slope {slope}: the area is off by {off}");
    }
}
