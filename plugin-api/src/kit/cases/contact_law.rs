//! Cases for every contact law: derivatives, surfaces that are apart, attraction, friction and energy.

use super::super::candidate::Candidate;
use super::super::contact_law::TestContactLaw;
use super::super::random::Random;
use super::common::needs_more_than_numbers;
use super::contact_repeatability as repeatability;
use super::{Case, CaseResult, NO_EXTREMES, describe_fault, ensure, skipped, tested};
use crate::abi;
use crate::contact_law::{ContactPoint, PointTraction};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "derivatives-are-those-of-the-tractions",
        promise: "the derivatives by gap, gap rate, slip and slip rate are those of the tractions, by differences",
        run: derivatives_match,
    },
    Case {
        name: "apart-there-is-no-traction",
        promise: "at a gap above the law's reach all tractions and derivatives are zero",
        run: apart_there_is_no_traction,
    },
    Case {
        name: "contact-does-not-attract",
        promise: "the normal traction of a law that is not adhesive is never negative, however fast the surfaces part",
        run: does_not_attract,
    },
    Case {
        name: "friction-opposes-slip",
        promise: "the tangential traction of a point that slides straight on does not drive it",
        run: friction_opposes_slip,
    },
    Case {
        name: "cycles-dissipate",
        promise: "surfaces that come together and part, or slide to and fro, get no energy from the law",
        run: cycles_dissipate,
    },
    Case {
        name: "tangent-axes-are-arbitrary",
        promise: "where the two axes of the tangent plane are turned, the tangential traction turns with them",
        run: tangent_axes_are_arbitrary,
    },
    Case {
        name: "ranges-are-bit-identical",
        promise: "calls over parts of the points give the same bytes as one call, and write to no other point",
        run: repeatability::calls_are_bit_identical,
    },
    Case {
        name: "results-are-deterministic",
        promise: "neither earlier calls nor other instances change a result",
        run: repeatability::state_is_bit_identical,
    },
    Case {
        name: "threads-do-not-interfere",
        promise: "calls from two threads at the same time give the same bytes as one after the other",
        run: repeatability::threads_are_bit_identical,
    },
    Case {
        name: "no-allocation-in-a-step",
        promise: "`tractions` and `advance` do not allocate",
        run: repeatability::no_allocation,
    },
    Case {
        name: "finite-at-extremes",
        promise: "results are finite with every parameter at its bounds and every choice, for slow and fast, shallow and deep contacts",
        run: finite_at_extremes,
    },
    Case {
        name: "nan-is-reported",
        promise: "a gap, gap rate or slip rate that is not a number gives a traction that is none, or a fault",
        run: nan_is_reported,
    },
    Case {
        name: "arrays-are-kept-to",
        promise: "calls read nothing around their arrays, and write nothing into inputs or around outputs",
        run: repeatability::arrays_are_kept_to,
    },
];

/// Deepest overlap of random states, m.
const DEEPEST: f64 = 2e-3;
/// Area of the test points, m^2.
const AREA: f64 = 1e-6;
/// Length of a step, s.
const DT: f64 = 1e-3;
/// Error of a derivative, relative to it.
const TOLERANCE: f64 = 1e-4;
/// Energy of a cycle, relative to the sum of the magnitudes of its work, that is left to the rule by which the work is summed up.
const CYCLE_TOLERANCE: f64 = 1e-3;
/// Steps of a cycle.
const CYCLE_STEPS: usize = 2000;

/// Runs a test on a law opened with its defaults; skips it where the defaults are not enough.
pub(super) fn with_law(c: &Candidate, test: impl FnOnce(TestContactLaw) -> CaseResult) -> CaseResult {
    match c.open(&[]) {
        Ok(instance) => test(TestContactLaw::new(instance).map_err(describe_fault)?),
        Err(fault) if needs_more_than_numbers(c) => Err(skipped(describe_fault(fault))),
        Err(fault) => Err(describe_fault(fault).into()),
    }
}

/// A state of surfaces that overlap: speeds from a micrometre to ten metres per second, in any direction; it has slid along its slip rate.
pub(super) fn random_point(random: &mut Random) -> ContactPoint {
    let mut speed = || {
        // Decades are equally likely: 10^n by repeated products, whose bits are the same everywhere.
        let decades = (random.next_u64() % 7) as i32;
        random.signed() * 1e-5 * 10_f64.powi(decades)
    };
    let (gap_rate, slip_rate) = (speed(), [speed(), speed()]);
    let seconds = 0.1 * random.unit();
    let gap = -DEEPEST * random.unit();
    ContactPoint { gap, gap_rate, slip: slip_rate.map(|v| v * seconds), slip_rate, area: AREA, time: 0.0, dt: DT }
}

/// The history of a point that has slid straight on for some steps at the slip rate of `point`.
pub(super) fn history_of(law: &TestContactLaw, point: ContactPoint, steps: u64) -> Result<Vec<f64>, String> {
    let mut history = vec![0.0; law.history_stride()];
    for _ in 0..steps {
        law.advance(&[point], &mut history, 1).map_err(describe_fault)?;
    }
    Ok(history)
}

/// Random states with histories.
fn states(law: &TestContactLaw, count: usize) -> Result<Vec<(ContactPoint, Vec<f64>)>, String> {
    let mut random = Random(19);
    (0..count)
        .map(|_| {
            let point = random_point(&mut random);
            let steps = random.next_u64() % 4;
            Ok((point, history_of(law, point, steps)?))
        })
        .collect()
}

/// Shows a state in a message.
fn shown(point: &ContactPoint) -> String {
    let ContactPoint { gap, gap_rate, slip_rate: [u, v], .. } = point;
    format!("at a gap of {gap:e} m, a gap rate of {gap_rate:e} m/s and a slip rate of [{u:e}, {v:e}] m/s")
}

/// The numbers of a traction that are compared with differences: normal, then both tangential ones.
fn numbers(t: &PointTraction) -> [f64; 3] {
    [t.normal, t.tangential[0], t.tangential[1]]
}

/// The derivative of each of [`numbers`] by a component of the state; `None` where none is asked for.
type Derivatives = [Option<f64>; 3];
/// A component of the state.
type Component = (&'static str, fn(&mut ContactPoint) -> &mut f64, fn(&PointTraction) -> Derivatives);

const COMPONENTS: [Component; 6] = [
    ("the gap", |p| &mut p.gap, |t| [Some(t.normal_by_gap), None, None]),
    ("the gap rate", |p| &mut p.gap_rate, |t| [Some(t.normal_by_gap_rate), None, None]),
    ("slip 0", |p| &mut p.slip[0], |t| slip_column(&t.tangential_by_slip, 0)),
    ("slip 1", |p| &mut p.slip[1], |t| slip_column(&t.tangential_by_slip, 1)),
    ("slip rate 0", |p| &mut p.slip_rate[0], |t| slip_column(&t.tangential_by_slip_rate, 0)),
    ("slip rate 1", |p| &mut p.slip_rate[1], |t| slip_column(&t.tangential_by_slip_rate, 1)),
];

/// Derivatives by one component of the slip or its rate, on which the normal traction may not depend.
fn slip_column(by: &[[f64; 2]; 2], column: usize) -> Derivatives {
    [Some(0.0), Some(by[0][column]), Some(by[1][column])]
}

fn derivatives_match(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        for (point, history) in states(&law, 200)? {
            let at = |p| law.traction(p, &history).map_err(describe_fault);
            let here = at(point)?;
            for (name, component, derivatives) in COMPONENTS {
                let value = *component(&mut point.clone());
                let h = 1e-6 * if value == 0.0 { 1e-3 } else { value.abs() };
                let moved = |by: f64| {
                    let mut moved = point;
                    *component(&mut moved) += by;
                    at(moved).map(|t| numbers(&t))
                };
                let moved = [moved(-2.0 * h)?, moved(-h)?, moved(h)?, moved(2.0 * h)?];
                for (i, given) in derivatives(&here).into_iter().enumerate() {
                    let Some(given) = given else { continue };
                    let now = numbers(&here)[i];
                    let [far_before, before, after, far_after] = moved.map(|found| found[i]);
                    // Where the traction has a kink a derivative of either side is one.
                    let sides = [
                        (3.0 * now - 4.0 * before + far_before) / (2.0 * h),
                        (4.0 * after - 3.0 * now - far_after) / (2.0 * h),
                    ];
                    let [low, high] = [sides[0].min(sides[1]), sides[0].max(sides[1])];
                    let rounding = 64.0 * f64::EPSILON * (now.abs() + far_after.abs() + far_before.abs()) / h;
                    let allowed = TOLERANCE * low.abs().max(high.abs()) + rounding;
                    ensure(low - allowed <= given && given <= high + allowed, || {
                        let what = ["normal traction", "tangential traction 0", "tangential traction 1"][i];
                        format!(
                            "{}: the derivative of the {what} by {name} is {given:e}; by differences it is {:e}",
                            shown(&point),
                            sides[1]
                        )
                    })?;
                }
            }
        }
        Ok(())
    })
}

fn apart_there_is_no_traction(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        for (overlapping, history) in states(&law, 50)? {
            for gap in [1e-9, 1e-6, 1e-3, 1.0].map(|more| law.reach() * (1.0 + 1e-12) + more) {
                let point = ContactPoint { gap, ..overlapping };
                let found = law.traction(point, &history).map_err(describe_fault)?;
                ensure(found == PointTraction::default(), || format!("{}: it gives {found:?}", shown(&point)))?;
            }
        }
        Ok(())
    })
}

fn does_not_attract(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        if law.is_adhesive() {
            return Err(skipped("it declares itself adhesive"));
        }
        for (point, history) in states(&law, 500)? {
            for factor in [1.0, 100.0, 1e4] {
                let point = ContactPoint { gap_rate: factor * point.gap_rate.abs(), ..point };
                let normal = law.traction(point, &history).map_err(describe_fault)?.normal;
                ensure(normal >= 0.0, || format!("{}: the normal traction is {normal:e} Pa", shown(&point)))?;
            }
        }
        Ok(())
    })
}

fn friction_opposes_slip(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        for (point, history) in states(&law, 500)? {
            let t = law.traction(point, &history).map_err(describe_fault)?.tangential;
            let [u, v] = point.slip_rate;
            let power = t[0] * u + t[1] * v;
            // Rounding of a friction that is across the slip.
            let size = (t[0].abs() + t[1].abs()) * (u.abs() + v.abs());
            ensure(power <= 1e-12 * size, || {
                format!("{}: the tangential traction {t:?} Pa has a power of {power:e} W/m^2", shown(&point))
            })?;
        }
        Ok(())
    })
}

/// Work of the law in a cycle of `motion`, whose argument goes from 0 to 1, per area, J/m^2; and the sum of the magnitudes. The cycle is run through
/// once before it counts, so that histories come back to what they were.
fn cycle(law: &TestContactLaw, motion: impl Fn(f64) -> ContactPoint) -> Result<[f64; 2], String> {
    let (mut history, mut work, mut size) = (vec![0.0; law.history_stride()], 0.0, 0.0);
    for step in 0..2 * CYCLE_STEPS {
        let along = |by: f64| motion((step % CYCLE_STEPS) as f64 / CYCLE_STEPS as f64 + by / CYCLE_STEPS as f64);
        let (start, middle, end) = (along(0.0), along(0.5), along(1.0));
        let t = law.traction(middle, &history).map_err(describe_fault)?;
        law.advance(&[middle], &mut history, 1).map_err(describe_fault)?;
        if step >= CYCLE_STEPS {
            let slid = [0, 1].map(|a| t.tangential[a] * (end.slip[a] - start.slip[a]));
            let done = t.normal * (end.gap - start.gap) + slid[0] + slid[1];
            (work, size) = (work + done, size + done.abs());
        }
    }
    Ok([work, size])
}

fn cycles_dissipate(c: &Candidate) -> CaseResult {
    const TURN: f64 = 2.0 * std::f64::consts::PI;
    with_law(c, |law| {
        for (seconds, depth) in [(0.01, 1e-4), (0.1, 1e-3), (1.0, 5e-4)] {
            let dt = seconds / CYCLE_STEPS as f64;
            let rest = ContactPoint { gap: -depth, area: AREA, dt, ..ContactPoint::default() };
            let press = |at: f64| {
                let gap = -0.5 * depth * (1.0 - (TURN * at).cos()) + 0.1 * depth;
                ContactPoint { gap, gap_rate: -0.5 * depth * TURN / seconds * (TURN * at).sin(), ..rest }
            };
            let slide = |at: f64| {
                let slip = [depth * (TURN * at).sin(), 0.0];
                ContactPoint { slip, slip_rate: [depth * TURN / seconds * (TURN * at).cos(), 0.0], ..rest }
            };
            for (what, [work, size]) in
                [("come together and part", cycle(&law, press)?), ("slide to and fro", cycle(&law, slide)?)]
            {
                ensure(work <= CYCLE_TOLERANCE * size, || {
                    format!("surfaces that {what} in {seconds} s, by {depth} m, get {work:e} J/m^2 of {size:e} J/m^2")
                })?;
            }
        }
        Ok(())
    })
}

fn tangent_axes_are_arbitrary(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        let none = vec![0.0; law.history_stride()];
        for (point, _) in states(&law, 100)? {
            let turn = |[u, v]: [f64; 2]| [0.6 * u - 0.8 * v, 0.8 * u + 0.6 * v];
            let turned = ContactPoint { slip: turn(point.slip), slip_rate: turn(point.slip_rate), ..point };
            let at = |p| law.traction(p, &none).map_err(describe_fault);
            let (here, there) = (at(point)?, at(turned)?);
            let expected = turn(here.tangential);
            let size = expected[0].abs() + expected[1].abs();
            let error = (0..2).map(|a| (there.tangential[a] - expected[a]).abs()).fold(0.0, f64::max);
            ensure(error <= 1e-9 * size && (here.normal - there.normal).abs() <= 1e-9 * here.normal.abs(), || {
                format!(
                    "{}: with turned axes the tangential traction is {:?} Pa instead of {expected:?} Pa",
                    shown(&point),
                    there.tangential
                )
            })?;
        }
        Ok(())
    })
}

/// Whether every number of a traction is finite.
fn is_finite(t: &PointTraction) -> bool {
    let matrices = t.tangential_by_slip.iter().chain(&t.tangential_by_slip_rate).flatten();
    let scalars = [t.normal, t.normal_by_gap, t.normal_by_gap_rate];
    scalars.iter().chain(&t.tangential).chain(matrices).all(|x| x.is_finite())
}

fn finite_at_extremes(c: &Candidate) -> CaseResult {
    let still = ContactPoint { gap: -1e-4, area: AREA, dt: DT, ..ContactPoint::default() };
    let mut states = vec![still, ContactPoint { gap: 0.0, ..still }, ContactPoint { gap: -0.1, ..still }];
    for speed in [1e-300, 1e-12, 1e-3, 100.0] {
        states.push(ContactPoint { gap_rate: speed, slip_rate: [speed, -speed], ..still });
        states.push(ContactPoint { gap_rate: -speed, slip_rate: [0.0, speed], slip: [0.0, 1.0], ..still });
    }
    let mut tried = 0;
    for (index, p) in c.params().iter().enumerate() {
        let values = match p.kind {
            abi::PARAM_NUMBER => vec![p.min, p.max],
            abi::PARAM_CHOICE => (0..Candidate::choices(p).len()).map(|i| i as f64).collect(),
            _ => continue,
        };
        for value in values {
            let setting = || format!("`{}` = {value}", Candidate::key(p));
            let failed = |fault| format!("{}: {}", setting(), describe_fault(fault));
            let law = match c.open(&[(index, value)]) {
                Ok(instance) => TestContactLaw::new(instance).map_err(failed)?,
                // A plugin may refuse a combination with the other defaults.
                Err(fault) if fault.status == abi::Status::BAD_ARGUMENT => continue,
                Err(fault) => return Err(failed(fault).into()),
            };
            tried += 1;
            for point in &states {
                let mut history = vec![0.0; law.history_stride()];
                for _ in 0..3 {
                    let found = law.traction(*point, &history).map_err(failed)?;
                    ensure(is_finite(&found), || format!("{}: {}: it gives {found:?}", setting(), shown(point)))?;
                    law.advance(&[*point], &mut history, 1).map_err(failed)?;
                    ensure(history.iter().all(|h| h.is_finite()), || {
                        format!("{}: {}: its history is {history:?}", setting(), shown(point))
                    })?;
                }
            }
        }
    }
    tested(tried, NO_EXTREMES)
}

fn nan_is_reported(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        let none = vec![0.0; law.history_stride()];
        let (sound, _) = states(&law, 1)?.remove(0);
        let rest = ContactPoint { slip_rate: [0.0; 2], ..sound };
        let depends = |point| -> Result<bool, String> {
            let [here, there] = [sound, point].map(|p| law.traction(p, &none).map_err(describe_fault));
            Ok(numbers(&here?) != numbers(&there?))
        };
        let mut tried = 0;
        for (what, broken, other) in [
            ("gap", ContactPoint { gap: f64::NAN, ..sound }, ContactPoint { gap: 2.0 * sound.gap, ..sound }),
            ("gap rate", ContactPoint { gap_rate: f64::NAN, ..sound }, ContactPoint { gap_rate: -0.1, ..sound }),
            ("slip rate", ContactPoint { slip_rate: [f64::NAN; 2], ..sound }, rest),
        ] {
            // A law may leave a component out, and then has nothing to report.
            if !depends(other)? {
                continue;
            }
            tried += 1;
            if let Ok(found) = law.traction(broken, &none) {
                let hidden = numbers(&found).iter().all(|x| x.is_finite());
                ensure(!hidden, || format!("a {what} of NaN gave finite tractions and no fault"))?;
            }
        }
        tested(tried, "its tractions depend on no rate and no gap")
    })
}
