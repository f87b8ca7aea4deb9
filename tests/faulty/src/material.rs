//! A material of linear springs.

use crate::{AFTER, fault, info};
use pliant_plugin_api::{
    Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params, Planes, Tangent,
    abi,
};

/// N/m, of every spring.
const STIFFNESS: f64 = 20.0;
/// s
const DAMPING_TIME: f64 = 1e-3;

/// Springs along the edges and face diagonals of the cells.
pub struct Springs<const F: u8> {
    after: f64,
}

impl<const F: u8> Springs<F> {
    /// Whether it is time for this fault.
    fn is_due(&self, fault: u8, at: &Elements<'_>) -> bool {
        F == fault && at.time().0 >= self.after
    }
}

impl<const F: u8> Material for Springs<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC_IN_NEW => c"panics-in-new",
            fault::PANIC => c"panics-in-forces",
            fault::NOT_A_NUMBER => c"forces-not-a-number",
            fault::REFUSES => c"refuses-in-rest",
            fault::UNKNOWN_KIND => c"unknown-elements",
            fault::NOTHING => c"no-mass",
            fault::BLOWS_UP => c"blows-up",
            _ => c"sound-springs",
        },
        const { &[AFTER] as &[Param] },
    );

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        assert!(F != fault::PANIC_IN_NEW, "panicked on purpose, in new");
        Ok(Self { after: params.number("after") })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let plain =
            ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
        let (families, flags) = (abi::STRUCTURAL | abi::SHEAR, abi::HAS_FORCES | abi::HAS_DAMPING);
        let kind = if F == fault::UNKNOWN_KIND { 99 } else { abi::LINK };
        vec![plain, ElementRequest { kind, families, flags, rest_stride: 1, ..plain }]
    }

    fn rest(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        if F == fault::REFUSES {
            return Err(Fault::diverged("refused on purpose"));
        }
        let [length] = out.first();
        for (length, ends) in length.iter_mut().zip(at.corners::<2>()) {
            (_, *length) = span(ends.map(|node| at.rest()[node as usize]));
        }
        Ok(())
    }

    fn mass(&self, at: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let density = if F == fault::NOTHING { 0.0 } else { 1e3 };
        at.corners::<1>().iter().zip(at.measure()).for_each(|(&[node], volume)| out.add(node, density * volume));
        Ok(())
    }

    fn energy(&self, at: &Elements<'_>) -> Result<f64, Fault> {
        let springs = at.corners::<2>().iter().zip(at.rest_data(0));
        let energy = |ends: &[u32; 2], rest: f64| span(ends.map(|node| at.x()[node as usize])).1 - rest;
        Ok(springs.map(|(ends, rest)| 0.5 * STIFFNESS * energy(ends, *rest).powi(2)).sum())
    }

    fn forces(&self, at: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        assert!(!self.is_due(fault::PANIC, at), "panicked on purpose, in forces");
        let factor = match F {
            fault::NOT_A_NUMBER if self.is_due(F, at) => f64::NAN,
            fault::BLOWS_UP if self.is_due(F, at) => -1e30,
            _ => 1.0,
        };
        for (&[a, b], rest) in at.corners::<2>().iter().zip(at.rest_data(0)) {
            let (along, length) = span([a, b].map(|node| at.x()[node as usize]));
            let [va, vb] = [a, b].map(|node| at.v()[node as usize]);
            let speed: f64 = (0..3).map(|i| (vb[i] - va[i]) * along[i]).sum();
            let pull = factor * STIFFNESS * (length - rest + DAMPING_TIME * speed);
            out.add(a, along.map(|d| pull * d));
            out.add(b, along.map(|d| -pull * d));
        }
        Ok(())
    }

    fn tangent(&self, at: &Elements<'_>, scale: Tangent, out: &mut Blocks<'_>) -> Result<(), Fault> {
        for (e, &ends) in at.corners::<2>().iter().enumerate() {
            let (n, _) = span(ends.map(|node| at.x()[node as usize]));
            let k = STIFFNESS * (scale.stiffness + scale.damping * DAMPING_TIME);
            out.add_link(e, &n.map(|a| n.map(|b| k * a * b)));
        }
        Ok(())
    }
}

/// From one point to another: direction and length.
fn span([a, b]: [[f64; 3]; 2]) -> ([f64; 3], f64) {
    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
    (d.map(|c| c / length), length)
}
