//! Blades whose tip lags behind a hand that turns them: they turn about a place inside of the body, where a part of them goes back.

use super::*;
use crate::testing::line_ends;
use pliant_mesh::Surface;

/// A body and the blades that are drawn right through it.
struct Lagging {
    document: ObjDocument,
    blades: Vec<Blade>,
}

impl Lagging {
    /// A hand draws a line behind a body, seen from an eye. The blade points from the hand to the eye; its tip is behind the hand, by a distance that changes, and out of the plane by up to
    /// a hundredth of the size.
    fn new(number: u64) -> Self {
        let random = &mut Random(number);
        let document = body(random);
        let bounds = Surface::from_document(&document).bounds();
        let (size, middle) = (bounds.longest_edge(), bounds.centre());
        let back = random.direction();
        let way = back.cross(&random.direction()).normalize();
        let aside = back.cross(&way);
        let eye = middle + (1.5 + random.unit()) * size * back;
        let start = middle - size * back + 0.1 * size * random.signed() * aside;
        let steps = 60 + random.below(60);
        let length = (eye - middle).norm() + 2.0 * size;
        let (waves, most) = (1.0 + 3.0 * random.unit(), 0.3 + 0.6 * random.unit());
        let (mut off, mut twist) = (0.0, 0.0);
        let blades = (0..=steps).map(|step| {
            let share = step as f64 / steps as f64;
            let hand = start + 6.0 * (share - 0.5) * size * way;
            let lag = most * size * (std::f64::consts::PI * waves * share).sin().powi(2);
            off = 0.8 * off + 0.002 * size * random.signed();
            twist = 0.8 * twist + 0.002 * random.signed();
            let tip = hand - lag * way + off * aside;
            blade(tip, tip + length * ((eye - hand).normalize() + twist * aside).normalize())
        });
        let blades = blades.collect();
        Self { document, blades }
    }

    /// Draws the blades as a knife does: what has not come ahead in the middle of the body waits. Returns the number of strips refused.
    fn draw(&self, mesh: &mut CutMesh, goes_back: bool) -> usize {
        let middle = mesh.surface().bounds().centre();
        let place = |blade: &Blade| {
            let along = (blade.heel - blade.tip).normalize();
            blade.tip + (middle - blade.tip).dot(&along) * along
        };
        let ahead = place(&self.blades[self.blades.len() - 1]) - place(&self.blades[0]);
        let mut stroke = Stroke::begin(self.blades[0]).unwrap();
        let mut refused = 0;
        for to in &self.blades[1..] {
            let from = stroke.blade();
            if (place(to) - place(&from)).dot(&ahead) <= 0.0 {
                continue;
            }
            let to = if goes_back { *to } else { mesh.front(&from, to, middle, ahead) };
            refused += usize::from(mesh.advance_cleanly(&mut stroke, to, 0.0).is_err());
        }
        refused
    }
}

/// Numbers of the cases with a branch, and of those in parts that hold together though no strip was refused.
fn draw_all(goes_back: bool) -> [Vec<u64>; 2] {
    let (mut refused, mut branched, mut joined) = (0, Vec::new(), Vec::new());
    for number in 0..60 {
        let case = Lagging::new(number);
        let mut mesh = cut_mesh(&case.document);
        let sums = Sums::new(&mesh);
        let bridges = case.draw(&mut mesh, goes_back);
        sums.check(&mesh);
        refused += bridges;
        if !line_ends(&mesh).is_empty() {
            branched.push(number);
        }
        if bridges == 0 && mesh.parts().all.len() < 2 {
            joined.push(number);
        }
    }
    println!("Goes back: {goes_back}. {refused} strips refused, branches in {branched:?}, {joined:?} hold together");
    [branched, joined]
}

#[test]
fn a_blade_that_lags_behind_its_hand_leaves_no_branch() {
    let [branched, joined] = draw_all(false);
    assert!(branched.is_empty() && joined.is_empty(), "{branched:?}, {joined:?}");
    let [folded, _] = draw_all(true);
    assert!(folded.len() > 20, "strips up to the blades themselves fold back: {folded:?}");
}
