//! A material of linear springs.

use crate::{AFTER, fault, info};
use pliant_plugin_api::{
    Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params, Planes,
    SingleBlocks, TangentScale, abi,
};
use std::sync::atomic::{AtomicU64, Ordering};

/// Stiffness of every spring, N/m.
const STIFFNESS: f64 = 20.0;
/// Damping along every spring, N s/m.
const DAMPING: f64 = 2e-2;

/// Stiffness of every spring, where it is a parameter.
const SPRING: Param = Param::number(c"spring", c"N/m", 1e-3..=1e3, STIFFNESS, c"stiffness of every spring").field();

/// Whether the stiffness of springs with a fault may differ from spring to spring.
const fn has_field(fault: u8) -> bool {
    matches!(fault, fault::FIELDS | fault::FIELD_IGNORED | fault::FIELD_OF_NEIGHBOUR)
}

/// Strain beyond which springs that flow do so.
const YIELD: f64 = 0.02;

/// Whether springs with a fault flow beyond a strain.
const fn flows(fault: u8) -> bool {
    matches!(fault, fault::FLOWS | fault::FLOW_GAINS | fault::FLOW_NOT_OBJECTIVE | fault::PANICS_IN_ADVANCE)
        || fails(fault)
}

/// Part of its rest length by which a spring flows until it has failed.
const BREAKS: f64 = 0.3;

/// Whether springs with a fault break.
const fn fails(fault: u8) -> bool {
    matches!(fault, fault::FAILS | fault::FAILS_BY_POSITION | fault::LISTS_FAIL)
}

/// Bits of the parameter `after` of the instance that was made last, for [`fault::SHARES_STATE`].
static LAST_AFTER: AtomicU64 = AtomicU64::new(0);

/// Springs along the edges and face diagonals of cells, with the fault `F` (see [`fault`]).
pub struct SpringMaterial<const F: u8> {
    /// s
    after: f64,
    /// N/m
    stiffness: f64,
    /// Bits of the first coordinate of the last call, for [`fault::KEEPS_STATE`].
    last_state: AtomicU64,
    /// How often that coordinate changed.
    state_changes: AtomicU64,
}

/// A spring in its current state.
pub(crate) struct Spring {
    /// Unit vector along it.
    pub(crate) along: [f64; 3],
    /// Stiffness across it over the stiffness along it, `max(0, 1 - l0/l)`.
    pub(crate) across: f64,
    /// Length less rest length, m.
    pub(crate) stretch: f64,
    /// N/m
    pub(crate) stiffness: f64,
}

impl<const F: u8> SpringMaterial<F> {
    /// Whether the material has this fault and its time has come.
    fn is_due(&self, fault: u8, elements: &Elements<'_>) -> bool {
        F == fault && elements.time() >= self.after
    }

    /// Factor of the stiffness of all springs of a call.
    fn factor(&self, elements: &Elements<'_>) -> f64 {
        match F {
            fault::SHARES_STATE => 1.0 + f64::from_bits(LAST_AFTER.load(Ordering::Relaxed)),
            fault::DIVIDES_BY_ZERO => 1.0 / (1e3 - self.after),
            fault::TOO_SOFT => 0.95,
            fault::KEEPS_STATE => {
                let now = elements.x().first().map_or(0, |x| x[0].to_bits());
                if self.last_state.swap(now, Ordering::Relaxed) != now {
                    self.state_changes.fetch_add(1, Ordering::Relaxed);
                }
                1.0 + 1e-12 * self.state_changes.load(Ordering::Relaxed) as f64
            }
            _ => 1.0,
        }
    }

    /// Spring `e` of a call between the nodes `ends`.
    fn spring(&self, elements: &Elements<'_>, e: usize, ends: [u32; 2]) -> Spring {
        let (x, rest) = (ends.map(|n| elements.x()[n as usize]), ends.map(|n| elements.rest()[n as usize]));
        let ((along, length), l0) = (span(x), elements.rest_data(0)[e]);
        let first = if F == fault::DEPENDS_ON_RANGE && e == 0 { 1.0 + 1e-12 } else { 1.0 };
        let stiffness = self.stiffness * elements.rest_data(1)[e] * first * self.factor(elements);
        if F == fault::NOT_OBJECTIVE {
            let (along, _) = span(rest);
            let stretch = (0..3).map(|i| (x[1][i] - x[0][i]) * along[i]).sum::<f64>() - l0;
            return Spring { along, across: 0.0, stretch, stiffness };
        }
        let l0 = if flows(F) { l0 + elements.history(0)[e] } else { l0 };
        Spring { along, across: (1.0 - l0 / length).max(0.0), stretch: length - l0, stiffness }
    }

    /// A spring from the origin to the midpoint of a link, for [`fault::DEPENDS_ON_POSITION`].
    fn anchor(elements: &Elements<'_>, e: usize, ends: [u32; 2]) -> Spring {
        let middle = |p: [[f64; 3]; 2]| span([[0.0; 3], [0, 1, 2].map(|i| 0.5 * (p[0][i] + p[1][i]))]);
        let (along, length) = middle(ends.map(|n| elements.x()[n as usize]));
        let (_, l0) = middle(ends.map(|n| elements.rest()[n as usize]));
        let stiffness = STIFFNESS * elements.measure()[e];
        Spring { along, across: (1.0 - l0 / length).max(0.0), stretch: length - l0, stiffness }
    }
}

impl Spring {
    /// J
    pub(crate) fn energy(&self) -> f64 {
        0.5 * self.stiffness * self.stretch * self.stretch
    }

    /// Block of the matrix, N/m: `stiffness` times its stiffness, and `damping` (N s/m) along it.
    pub(crate) fn block(&self, stiffness: f64, damping: f64) -> [[f64; 3]; 3] {
        let k = stiffness * self.stiffness;
        let (across, n) = (k * self.across, self.along);
        let along = k + damping - across;
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| along * n[i] * n[j] + if i == j { across } else { 0.0 }))
    }
}

impl<const F: u8> Material for SpringMaterial<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC_IN_NEW => c"panics-in-new",
            fault::PANIC => c"panics-in-forces",
            fault::NAN => c"forces-not-a-number",
            fault::REFUSES => c"refuses-in-rest",
            fault::UNKNOWN_KIND => c"unknown-elements",
            fault::NO_MASS => c"no-mass",
            fault::BLOWS_UP => c"blows-up",
            fault::MAKES_ENERGY => c"makes-energy",
            fault::MASS_BELOW_ZERO => c"mass-below-zero",
            fault::PULLS_AT_REST => c"pulls-at-rest",
            fault::ENERGY_OFF => c"energy-off",
            fault::STIFFNESS_OFF => c"stiffness-off",
            fault::SINGLE_OFF => c"single-off",
            fault::DAMPING_GAINS => c"damping-gains",
            fault::DEPENDS_ON_POSITION => c"depends-on-position",
            fault::NOT_OBJECTIVE => c"not-objective",
            fault::DEPENDS_ON_ORDER => c"depends-on-order",
            fault::DEPENDS_ON_RANGE => c"depends-on-range",
            fault::KEEPS_STATE => c"keeps-state",
            fault::SHARES_STATE => c"shares-state",
            fault::DIVIDES_BY_ZERO => c"divides-by-zero",
            fault::HIDES_NAN => c"swallows-nan",
            fault::ALLOCATES => c"allocates",
            fault::SLOW_AFTER => c"takes-long",
            fault::TOO_SOFT => c"too-soft",
            fault::SLOW => c"slow",
            fault::HANGS => c"hangs",
            fault::ABORTS => c"aborts",
            fault::EXITS => c"exits",
            fault::FLOWS => c"sound-clay",
            fault::FAILS => c"sound-thread",
            fault::FAILS_BY_POSITION => c"fails-by-position",
            fault::FLOW_GAINS => c"flow-gains",
            fault::FLOW_NOT_OBJECTIVE => c"flow-not-objective",
            fault::FIELDS => c"sound-fields",
            fault::FIELD_IGNORED => c"field-ignored",
            fault::FIELD_OF_NEIGHBOUR => c"field-of-neighbour",
            fault::WEAK_WHEN_STRETCHED => c"weak-when-stretched",
            fault::ENERGY_OFF_WITH_PARAMETER => c"energy-off-with-parameter",
            fault::TANGENT_NOT_LINEAR => c"tangent-not-linear",
            fault::STATIC_SCRATCH => c"static-scratch",
            fault::LEAKS => c"leaks",
            fault::READS_PAST_NODES => c"reads-past-nodes",
            fault::WRITES_PAST_NODES => c"writes-past-nodes",
            fault::WRITES_PAST_PLANES => c"writes-past-planes",
            fault::TOUCHES_OTHER_NODES => c"touches-other-nodes",
            fault::MEASURE_IGNORED => c"measure-ignored",
            fault::KEEPS_REST_AXES => c"keeps-rest-axes",
            fault::DAMPING_GAINS_WHEN_FAST => c"damping-gains-when-fast",
            fault::DAMPS_TURNING => c"damps-turning",
            fault::PANICS_IN_ADVANCE => c"panics-in-advance",
            fault::WHOLE_LISTS => c"sound-lists",
            fault::CUTS_LONG_LISTS => c"cuts-long-lists",
            fault::LISTS_FAIL => c"lists-fail",
            _ => c"sound-springs",
        },
        if has_field(F) { const { &[AFTER, SPRING] as &[Param] } } else { const { &[AFTER] as &[Param] } },
    );

    const WANTS_WHOLE_LISTS: bool = matches!(F, fault::WHOLE_LISTS | fault::CUTS_LONG_LISTS | fault::LISTS_FAIL);

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        assert!(F != fault::PANIC_IN_NEW, "panicked on purpose, in new");
        let after = params.number("after");
        if F == fault::LEAKS {
            std::mem::forget(std::hint::black_box(vec![0_u8; 64]));
        }
        // Tests that run side by side share the library: another material must not disturb this one.
        if F == fault::SHARES_STATE {
            LAST_AFTER.store(after.to_bits(), Ordering::Relaxed);
        }
        let stiffness = if has_field(F) { params.number("spring") } else { STIFFNESS };
        Ok(Self { after, stiffness, last_state: AtomicU64::new(0), state_changes: AtomicU64::new(0) })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let plain =
            ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
        let single = if F == fault::SINGLE_OFF { abi::HAS_SINGLE } else { 0 };
        let (families, flags) = (abi::STRUCTURAL | abi::SHEAR, abi::HAS_FORCES | abi::HAS_DAMPING | single);
        let kind = if F == fault::UNKNOWN_KIND { 99 } else { abi::LINK };
        let can_fail = if fails(F) { abi::CAN_FAIL } else { 0 };
        let (history, history_stride) = if flows(F) { (abi::HAS_HISTORY | can_fail, 1) } else { (0, 0) };
        vec![plain, ElementRequest { kind, families, flags: flags | history, rest_stride: 2, history_stride }]
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        if F == fault::REFUSES {
            return Err(Fault::diverged("refused on purpose"));
        }
        let [length, factor] = out.first_planes();
        let shorter = if F == fault::PULLS_AT_REST { 0.99 } else { 1.0 };
        for (e, ends) in elements.corners::<2>().iter().enumerate() {
            let (along, l0) = span(ends.map(|node| elements.rest()[node as usize]));
            length[e] = shorter * l0;
            factor[e] = if F == fault::DEPENDS_ON_ORDER && e % 2 == 1 { 2.0 } else { 1.0 };
            if has_field(F) && F != fault::FIELD_IGNORED {
                let of = if F == fault::FIELD_OF_NEIGHBOUR { (e + 1).min(elements.len() - 1) } else { e };
                factor[e] = elements.field("spring").factor(of);
            }
            factor[e] *= match F {
                fault::MEASURE_IGNORED => 1.0,
                fault::KEEPS_REST_AXES => (1.0 + along[0] * along[0]) * elements.measure()[e],
                _ => elements.measure()[e],
            };
        }
        Ok(())
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let density = if F == fault::NO_MASS { 0.0 } else { 1e3 };
        for (&[node], volume) in elements.corners::<1>().iter().zip(elements.measure()) {
            let sign = if F == fault::MASS_BELOW_ZERO && node == 0 { -1.0 } else { 1.0 };
            out.add(node, sign * density * volume);
        }
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        let is_off = match F {
            fault::ENERGY_OFF => true,
            fault::ENERGY_OFF_WITH_PARAMETER => self.after.to_bits() != 0.01_f64.to_bits(),
            _ => false,
        };
        let factor = if is_off { 1.01 } else { 1.0 };
        let energy = |(e, ends): (usize, &[u32; 2])| {
            let anchor = if F == fault::DEPENDS_ON_POSITION { Self::anchor(elements, e, *ends).energy() } else { 0.0 };
            self.spring(elements, e, *ends).energy() + anchor
        };
        Ok(factor * elements.corners::<2>().iter().enumerate().map(energy).sum::<f64>())
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        assert!(!self.is_due(fault::PANIC, elements), "panicked on purpose, in forces");
        if self.is_due(fault::SLOW_AFTER, elements) {
            std::thread::sleep(std::time::Duration::from_millis(1200));
        }
        if self.is_due(fault::HANGS, elements)
            && let Some(file) = std::env::var_os(crate::HANGS_FILE)
        {
            let _ = std::fs::write(file, std::process::id().to_string());
        }
        while self.is_due(fault::HANGS, elements) {
            std::thread::sleep(std::time::Duration::from_secs(1));
        }
        if self.is_due(fault::ABORTS, elements) {
            std::process::abort();
        }
        if self.is_due(fault::EXITS, elements) {
            std::process::exit(0);
        }
        if F == fault::SLOW {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        if F == fault::ALLOCATES {
            std::hint::black_box(vec![0_u8; 64]);
        }
        let factor = match F {
            fault::NAN if self.is_due(F, elements) => f64::NAN,
            fault::BLOWS_UP if self.is_due(F, elements) => -1e30,
            _ => 1.0,
        };
        let damping = if F == fault::DAMPING_GAINS { -DAMPING } else { DAMPING };
        let factor = if F == fault::STATIC_SCRATCH { factor * through_static(elements) } else { factor };
        let factor = factor * (1.0 + stray::<F>(elements, out));
        // The rest length oscillates with 12 Hz (75 rad/s).
        let swell = if self.is_due(fault::MAKES_ENERGY, elements) { 0.1 * (75.0 * elements.time()).sin() } else { 0.0 };
        let most = if F == fault::CUTS_LONG_LISTS { 16_384 } else { usize::MAX };
        for (e, &[a, b]) in elements.corners::<2>().iter().enumerate().take(most) {
            let spring = self.spring(elements, e, [a, b]);
            let [va, vb] = [a, b].map(|node| elements.v()[node as usize]);
            let speed: f64 = (0..3).map(|i| (vb[i] - va[i]) * spring.along[i]).sum();
            let swollen = spring.stretch - swell * elements.rest_data(0)[e];
            let is_weak = F == fault::WEAK_WHEN_STRETCHED && spring.stretch > 0.6 * elements.rest_data(0)[e];
            let strength = if is_weak { 0.9 } else { 1.0 };
            let is_fast = F == fault::DAMPING_GAINS_WHEN_FAST && speed.abs() > 5.0;
            let damping = if is_fast { -damping } else { damping } * elements.measure()[e];
            let mut pull = factor * (strength * spring.stiffness * swollen + damping * speed);
            let mut along = spring.along;
            if F == fault::DAMPS_TURNING {
                let across = [0, 1, 2].map(|i| damping * (vb[i] - va[i] - speed * along[i]));
                out.add(a, across);
                out.add(b, across.map(|f| -f));
            }
            if F == fault::HIDES_NAN && !along.iter().all(|c| c.is_finite()) {
                (pull, along) = (0.0, [0.0; 3]);
            }
            out.add(a, along.map(|d| pull * d));
            out.add(b, along.map(|d| -pull * d));
            if F == fault::DEPENDS_ON_POSITION {
                let anchor = Self::anchor(elements, e, [a, b]);
                let half = anchor.along.map(|d| -0.5 * anchor.stiffness * anchor.stretch * d);
                [a, b].into_iter().for_each(|node| out.add(node, half));
            }
        }
        Ok(())
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        let is_off = F == fault::STIFFNESS_OFF
            || F == fault::TANGENT_NOT_LINEAR && scale.stiffness != 0.0 && scale.damping != 0.0;
        let factor = if is_off { 1.01 } else { 1.0 };
        let damping = if F == fault::DAMPING_GAINS { -DAMPING } else { DAMPING };
        for (e, &ends) in elements.corners::<2>().iter().enumerate() {
            let spring = self.spring(elements, e, ends);
            let damping = scale.damping * damping * elements.measure()[e];
            let mut block = spring.block(factor * scale.stiffness, damping);
            if F == fault::DAMPS_TURNING {
                let n = spring.along;
                let across = |i: usize, j: usize| if i == j { 1.0 - n[i] * n[i] } else { -n[i] * n[j] };
                (0..9).for_each(|k| block[k / 3][k % 3] += damping * across(k / 3, k % 3));
            }
            out.add_link(e, &block);
            if F == fault::DEPENDS_ON_POSITION {
                let quarter = Self::anchor(elements, e, ends).block(0.25 * scale.stiffness, 0.0);
                (0..3).for_each(|pair| out.add(e, pair, &quarter));
            }
        }
        Ok(())
    }

    fn advance(&self, elements: &Elements<'_>, history: &mut Planes<'_>) -> Result<(), Fault> {
        let [elongation] = history.first_planes();
        for (e, &ends) in elements.corners::<2>().iter().enumerate() {
            let spring = self.spring(elements, e, ends);
            let length = elements.rest_data(0)[e];
            assert!(F != fault::PANICS_IN_ADVANCE || spring.stretch < 50.0 * length, "panicked on purpose, in advance");
            let excess = (spring.stretch.abs() - YIELD * elements.rest_data(0)[e]).max(0.0);
            let share = match F {
                fault::FLOW_GAINS => -1.0,
                fault::FLOW_NOT_OBJECTIVE => spring.along[0].powi(2),
                _ => 1.0,
            };
            elongation[e] += share * excess.copysign(spring.stretch);
        }
        Ok(())
    }

    fn has_failed(&self, elements: &Elements<'_>, e: usize) -> bool {
        let (flowed, length) = (elements.history(0)[e], elements.rest_data(0)[e]);
        if F == fault::FAILS_BY_POSITION {
            let ends = elements.corners::<2>()[e];
            return self.spring(elements, e, ends).stretch + flowed > BREAKS * length;
        }
        flowed.abs() > BREAKS * length
    }

    fn single_tangent(
        &self,
        elements: &Elements<'_>,
        scale: TangentScale,
        out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        for (e, &ends) in elements.corners::<2>().iter().enumerate() {
            let block = self
                .spring(elements, e, ends)
                .block(1.01 * scale.stiffness, scale.damping * DAMPING * elements.measure()[e]);
            out.add(e, 1, &block.map(|row| row.map(|k| -k as f32)));
        }
        Ok(())
    }
}

/// Reads or writes outside of what the call may: zero times what is there, or zero added to it, which changes nothing of another's but the sign of a zero.
#[allow(unsafe_code, reason = "goes where a plugin may not")]
fn stray<const F: u8>(elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> f64 {
    let nodes = elements.x().len();
    let window = out.window();
    let forces = window.values.as_mut_ptr().cast::<f64>().wrapping_sub(3 * window.first_node);
    let planes = elements.rest_data(1);
    let at = match F {
        fault::READS_PAST_NODES => elements.x().as_ptr().wrapping_add(nodes).cast::<f64>().cast_mut(),
        fault::WRITES_PAST_NODES => forces.wrapping_add(3 * nodes),
        fault::WRITES_PAST_PLANES => planes.as_ptr().wrapping_add(planes.len()).cast_mut(),
        fault::TOUCHES_OTHER_NODES if window.first_node > 0 => forces,
        _ => return 0.0,
    };
    // SAFETY: none: this is the fault. The suite has guards there.
    unsafe {
        let found = at.read_volatile();
        if F == fault::READS_PAST_NODES {
            return if found.is_nan() || found == 1e3 { found } else { 0.0 };
        }
    }
    crate::write_same(at);
    0.0
}

/// 1, unless another thread writes to the static variable meanwhile.
fn through_static(elements: &Elements<'_>) -> f64 {
    static SCRATCH: AtomicU64 = AtomicU64::new(0);
    let own = elements.x().first().map_or(0, |x| x[0].to_bits());
    SCRATCH.store(own, Ordering::Relaxed);
    std::thread::yield_now();
    if SCRATCH.load(Ordering::Relaxed) == own { 1.0 } else { 1.0 + 1e-12 }
}

/// Unit vector and distance from the first point to the second.
pub(crate) fn span([a, b]: [[f64; 3]; 2]) -> ([f64; 3], f64) {
    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
    (d.map(|c| c / length), length)
}
