//! Calls of a material's functions with every array between guards.

use super::super::guarded::{Guarded, Value, describe_offset};
use super::super::protected_memory::{Edge, ProtectedMemory};
use super::super::tested_material::{Call, MaterialUnderTest};
use super::Body;
use crate::abi;
use crate::fault::Fault;
use crate::material::TangentScale;
use std::ops::Range;

/// The functions of a material that get arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::kit) enum Function {
    Rest,
    Mass,
    Energy,
    Forces,
    Tangent,
    SingleTangent,
    Advance,
    Failed,
    Strain,
    Compliance,
    NormalsEnergy,
    NormalsForces,
    Tilt,
}

impl Function {
    /// Every function once.
    pub(in crate::kit) const ALL: [Self; 13] = [
        Self::Rest,
        Self::Mass,
        Self::Energy,
        Self::Forces,
        Self::Tangent,
        Self::SingleTangent,
        Self::Advance,
        Self::Failed,
        Self::Strain,
        Self::Compliance,
        Self::NormalsEnergy,
        Self::NormalsForces,
        Self::Tilt,
    ];

    /// Name of the function in `pliant.h`.
    pub(in crate::kit) fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Mass => "mass",
            Self::Energy => "energy",
            Self::Forces => "forces",
            Self::Tangent => "tangent",
            Self::SingleTangent => "tangent` of `pliant.single/1",
            Self::Advance => "advance",
            Self::Failed => "failed",
            Self::Strain => "strain",
            Self::Compliance => "compliance",
            Self::NormalsEnergy => "energy` of `pliant.normals/1",
            Self::NormalsForces => "forces` of `pliant.normals/1",
            Self::Tilt => "tilt",
        }
    }
}

/// The guards of one array: a number at some of their offsets, or at all.
#[derive(Clone, Copy, Debug)]
pub(in crate::kit) struct GuardChange {
    /// Name of the array.
    pub(in crate::kit) array: &'static str,
    /// What the guards hold: a whole number for an array of integers.
    pub(in crate::kit) number: f64,
    /// Offset of the only guard that has it; `None` for all.
    pub(in crate::kit) offset: Option<isize>,
}

/// One array of a call at a guard page, in the place of guards.
#[derive(Clone, Copy, Debug)]
pub(in crate::kit) struct AtPage {
    /// Name of the array.
    pub(in crate::kit) array: &'static str,
    /// Where the array is moved to.
    pub(in crate::kit) memory: ProtectedMemory,
    /// Which end of it lies at the page.
    pub(in crate::kit) edge: Edge,
}

/// What is around the arrays of a call.
#[derive(Clone, Copy, Debug)]
pub(in crate::kit) enum Surroundings {
    /// Guards around all.
    Guards,
    /// Guards around all, those of one array with another number.
    Changed(GuardChange),
    /// Guards around all but one.
    Page(AtPage),
}

/// What a call did.
#[derive(Clone, Debug)]
pub(in crate::kit) struct Done {
    /// Bits of its results; a fault counts as a result.
    pub(in crate::kit) bits: Result<Vec<u64>, String>,
    /// The first value that it wrote and that is not its own.
    pub(in crate::kit) stray_write: Option<StrayWrite>,
}

/// A value that a call wrote and that is not its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::kit) struct StrayWrite {
    /// Name of the array.
    pub(in crate::kit) array: &'static str,
    /// Whether the value lies outside of the array.
    pub(in crate::kit) is_outside: bool,
    /// Where it lies.
    pub(in crate::kit) place: String,
}

/// Names of the arrays that hold planes of the material's own.
pub(in crate::kit) const PLANES: [&str; 3] = ["rest_data", "history", "fields"];
/// Names of the other arrays that a call reads.
pub(in crate::kit) const INPUTS: [&str; 10] =
    ["elements", "family", "measure", "material", "rest", "x", "v", "directions", "normals", "slots"];
/// Name of the array that a call writes.
pub(in crate::kit) const OUTPUT: &str = "out";

/// What an output holds before a call, at nodes that are not its own: adding anything, or zero, changes its bits.
const OUTSIDE_SPAN: f64 = -0.0;
/// The same within the span of the call's nodes, where a kernel may add zero.
const INSIDE_SPAN: f64 = 5e-324;

/// Guards of all arrays; numbers of nodes and slots are small, so that a plugin that follows them stays in its arrays.
const GUARD: f64 = -0.0;

/// Copies of the arrays that a call of one set of elements reads.
struct Inputs {
    elements: Guarded<u32>,
    family: Guarded<u32>,
    measure: Guarded<f64>,
    material: Guarded<f64>,
    rest: Guarded<[f64; 3]>,
    x: Guarded<[f64; 3]>,
    v: Guarded<[f64; 3]>,
    rest_data: Guarded<f64>,
    history: Guarded<f64>,
    fields: Guarded<f64>,
    directions: Guarded<[f64; 3]>,
    normals: Guarded<[f64; 3]>,
    slots: Guarded<u32>,
}

/// An array of any type between guards.
trait AnyGuarded {
    /// See [`Guarded::set_guard`].
    fn set_guard(&mut self, offset: isize, number: f64);
    /// See [`Guarded::guard_offsets`]; empty for an array without values, which is not handed over.
    fn guard_offsets(&self) -> Vec<isize>;
    /// See [`Guarded::move_to`].
    fn move_to(&mut self, memory: ProtectedMemory, edge: Edge) -> bool;
    /// The first write to the array, of which no value may be changed.
    fn write_into(&self, name: &'static str) -> Option<StrayWrite>;
}

impl<T: Value> AnyGuarded for Guarded<T> {
    fn set_guard(&mut self, offset: isize, number: f64) {
        Self::set_guard(self, offset, number);
    }

    fn guard_offsets(&self) -> Vec<isize> {
        if self.array().is_empty() { Vec::new() } else { Self::guard_offsets(self).collect() }
    }

    fn move_to(&mut self, memory: ProtectedMemory, edge: Edge) -> bool {
        Self::move_to(self, memory, edge)
    }

    fn write_into(&self, name: &'static str) -> Option<StrayWrite> {
        stray_write(name, self, |_| false)
    }
}

/// The write to guards of an array, or to values of it that are not the call's own.
fn stray_write<T: Value>(name: &'static str, array: &Guarded<T>, is_own: impl Fn(usize) -> bool) -> Option<StrayWrite> {
    let offset = array.first_change(is_own)?;
    let is_outside = !(0..array.len() as isize).contains(&offset);
    Some(StrayWrite { array: name, is_outside, place: describe_offset(offset, array.len()) })
}

impl Inputs {
    /// The arrays of a set.
    fn new(body: &Body, set: usize, around: Surroundings) -> Self {
        let s = &body.sets[set];
        let is_link = s.request.kind == abi::LINK;
        let normals = match s.request.flags & abi::WANTS_NORMALS != 0 && s.request.kind == abi::TRIANGLE {
            true => body.normals(s.nodes.as_chunks::<3>().0),
            false => Vec::new(),
        };
        let slots: Vec<u32> = (0..s.block_count() as u32).collect();
        let mut inputs = Self {
            elements: Guarded::new(&s.nodes, 0.0),
            family: Guarded::new(if is_link { &s.family } else { &[] }, f64::from(abi::STRUCTURAL)),
            measure: Guarded::new(&s.measure, GUARD),
            material: Guarded::new(&s.material, GUARD),
            rest: Guarded::new(&body.rest, GUARD),
            x: Guarded::new(&body.x, GUARD),
            v: Guarded::new(&body.v, GUARD),
            rest_data: Guarded::with_plane(s.rest_data.planes(), GUARD, s.count()),
            history: Guarded::with_plane(s.history.planes(), GUARD, s.count()),
            fields: Guarded::with_plane(s.fields.planes(), GUARD, s.count()),
            directions: Guarded::new(&s.directions, GUARD),
            normals: Guarded::new(&normals, GUARD),
            slots: Guarded::new(&slots, 0.0),
        };
        match around {
            Surroundings::Guards => {}
            Surroundings::Changed(GuardChange { array, number, offset }) => {
                if let Some(guarded) = inputs.named(array) {
                    let offsets = offset.map_or_else(|| guarded.guard_offsets(), |offset| vec![offset]);
                    offsets.into_iter().for_each(|offset| guarded.set_guard(offset, number));
                }
            }
            Surroundings::Page(AtPage { array, memory, edge }) => {
                if let Some(guarded) = inputs.named(array) {
                    guarded.move_to(memory, edge);
                }
            }
        }
        inputs
    }

    /// The array with a name, if it is an input.
    fn named(&mut self, array: &str) -> Option<&mut dyn AnyGuarded> {
        self.all_mut().into_iter().find(|(name, _)| *name == array).map(|(_, guarded)| guarded)
    }

    /// All arrays with their names.
    fn all_mut(&mut self) -> [(&'static str, &mut dyn AnyGuarded); 13] {
        [
            ("elements", &mut self.elements),
            ("family", &mut self.family),
            ("measure", &mut self.measure),
            ("material", &mut self.material),
            ("rest", &mut self.rest),
            ("x", &mut self.x),
            ("v", &mut self.v),
            ("rest_data", &mut self.rest_data),
            ("history", &mut self.history),
            ("fields", &mut self.fields),
            ("directions", &mut self.directions),
            ("normals", &mut self.normals),
            ("slots", &mut self.slots),
        ]
    }

    /// The call of the body with these arrays in the place of its own.
    fn call<'a>(&'a self, body: &'a Body, set: usize, range: Range<usize>) -> Call<'a> {
        let mut call = body.call(set, range);
        let batch = &mut call.batch;
        batch.elements = self.elements.as_ptr();
        batch.family = self.family.as_ptr();
        batch.measure = self.measure.as_ptr();
        batch.material = self.material.as_ptr();
        batch.rest = self.rest.as_ptr().cast();
        batch.x = self.x.as_ptr().cast();
        batch.v = self.v.as_ptr().cast();
        batch.rest_data = self.rest_data.as_ptr();
        batch.history = self.history.as_ptr();
        batch.fields = self.fields.as_ptr();
        call
    }

    /// The first input that was written to.
    fn stray_write(mut self) -> Option<StrayWrite> {
        self.all_mut().into_iter().find_map(|(name, guarded)| guarded.write_into(name))
    }
}

impl Body {
    /// Numbers of elements in each set.
    pub(in crate::kit) fn set_counts(&self) -> Vec<usize> {
        self.sets.iter().map(super::ElementSet::count).collect()
    }

    /// Kind of the elements of a set.
    pub(in crate::kit) fn set_kind(&self, set: usize) -> u32 {
        self.sets[set].request.kind
    }

    /// Whether elements of a set are called with a function.
    pub(in crate::kit) fn calls(&self, set: usize, function: Function) -> bool {
        let request = &self.sets[set].request;
        let has = |flag: u32| request.flags & flag != 0;
        match function {
            Function::Rest => request.rest_stride > 0,
            Function::Mass => has(abi::HAS_MASS),
            Function::Energy | Function::Forces | Function::Tangent => has(abi::HAS_FORCES),
            Function::SingleTangent => has(abi::HAS_SINGLE),
            Function::Advance => has(abi::HAS_HISTORY),
            Function::Failed => has(abi::CAN_FAIL),
            Function::Strain => has(abi::IS_COUPLED) && request.kind == abi::HINGE,
            Function::Compliance => has(abi::IS_COUPLED) && request.kind == abi::TRIANGLE,
            Function::NormalsEnergy | Function::NormalsForces | Function::Tilt => {
                has(abi::WANTS_NORMALS) && request.kind == abi::TRIANGLE
            }
        }
    }

    /// Calls a function for a range of a set's elements, with all arrays between guards, or one at a guard page.
    pub(in crate::kit) fn guarded_call<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        set: usize,
        function: Function,
        range: Range<usize>,
        around: Surroundings,
    ) -> Done {
        let inputs = Inputs::new(self, set, around);
        let call = inputs.call(self, set, range.clone());
        let s = &self.sets[set];
        let (count, nodes) = (s.count(), self.rest.len());
        let pairs = s.corners * (s.corners + 1) / 2;
        let own_nodes = &s.nodes[range.start * s.corners..range.end * s.corners];
        let span = call.batch.node_begin..call.batch.node_end;
        let is_own_node = |node: usize| own_nodes.contains(&(node as u32));
        let node_start = |node: usize| match (is_own_node(node), span.contains(&node)) {
            (true, _) => 0.0,
            (false, true) => INSIDE_SPAN,
            (false, false) => OUTSIDE_SPAN,
        };
        let block_start = |block: usize| if range.contains(&(block / pairs)) { 0.0 } else { OUTSIDE_SPAN };
        let is_own_block = |block: usize| range.contains(&(block / pairs));
        let is_own_value = |value: usize| range.contains(&(value % count));
        let scale = TangentScale { stiffness: 1.0, damping: 0.5 };
        let planes = |number: usize| vec![f64::NAN; number * count];
        let (slots, normals) = (inputs.slots.array(), inputs.normals.array());
        let of_planes = |start: Vec<f64>, fill: &dyn Fn(&mut [f64]) -> Result<(), Fault>| {
            finish(around, Guarded::with_plane(&start, GUARD, count), fill, is_own_value)
        };
        let (bits, written) = match function {
            Function::Rest => {
                let start = s.rest_data.planes().to_vec();
                let is_directed = s.request.flags & abi::WANTS_DIRECTIONS != 0;
                of_planes(start, &|out| match is_directed {
                    true => material.call_directed_rest(&call, inputs.directions.array(), out),
                    false => material.call_rest(&call, out),
                })
            }
            Function::Mass => {
                let start: Vec<f64> = (0..nodes).map(node_start).collect();
                finish(around, Guarded::new(&start, GUARD), &|out| material.call_mass(&call, out), is_own_node)
            }
            Function::Energy => (material.call_energy(&call).map(|e| vec![e.to_bits()]).map_err(text), None),
            Function::Forces => {
                let start: Vec<[f64; 3]> = (0..nodes).map(|n| [node_start(n); 3]).collect();
                finish(around, Guarded::new(&start, GUARD), &|out| material.call_forces(&call, out), is_own_node)
            }
            Function::Tangent => {
                let start: Vec<[f64; 9]> = (0..slots.len()).map(|b| [block_start(b); 9]).collect();
                let fill = |out: &mut [[f64; 9]]| material.call_tangent(&call, scale, slots, out);
                finish(around, Guarded::new(&start, GUARD), &fill, is_own_block)
            }
            Function::SingleTangent => {
                let start: Vec<[f32; 9]> = (0..slots.len()).map(|b| [block_start(b) as f32; 9]).collect();
                let fill = |out: &mut [[f32; 9]]| material.call_single_tangent(&call, scale, slots, out);
                finish(around, Guarded::new(&start, GUARD), &fill, is_own_block)
            }
            Function::Advance => of_planes(s.history.planes().to_vec(), &|out| material.call_advance(&call, out)),
            Function::Failed => {
                let start = vec![0xa5_u8; count];
                finish(around, Guarded::new(&start, 165.0), &|out| material.call_failed(&call, out), is_own_value)
            }
            Function::Strain => of_planes(planes(13), &|out| material.call_strain(&call, out)),
            Function::Compliance => of_planes(planes(6), &|out| material.call_compliance(&call, out)),
            Function::NormalsEnergy => {
                (material.call_normals_energy(&call, normals).map(|e| vec![e.to_bits()]).map_err(text), None)
            }
            Function::NormalsForces => {
                let start: Vec<[f64; 6]> = (0..nodes).map(|n| [node_start(n); 6]).collect();
                let fill = |out: &mut [[f64; 6]]| material.call_normals_forces(&call, normals, out);
                finish(around, Guarded::new(&start, GUARD), &fill, is_own_node)
            }
            Function::Tilt => of_planes(planes(3), &|out| material.call_tilt(&call, out)),
        };
        Done { bits, stray_write: written.or_else(|| inputs.stray_write()) }
    }

    /// Offsets of the guards of an array of a set.
    pub(in crate::kit) fn guard_offsets(&self, set: usize, array: &str) -> Vec<isize> {
        let mut inputs = Inputs::new(self, set, Surroundings::Guards);
        inputs.named(array).map_or_else(Vec::new, |guarded| guarded.guard_offsets())
    }

    /// Where a guard of an array of a set lies.
    pub(in crate::kit) fn describe_guard(&self, set: usize, array: &str, offset: isize) -> String {
        let end = self.guard_offsets(set, array).into_iter().find(|offset| *offset > 0);
        describe_offset(offset, end.unwrap_or(0) as usize)
    }
}

/// The sentence of a fault.
fn text(fault: Fault) -> String {
    fault.to_string()
}

/// Bits of what `fill` writes into an output, and its first write that is not its own.
fn finish<T: Value>(
    around: Surroundings,
    mut out: Guarded<T>,
    fill: &dyn Fn(&mut [T]) -> Result<(), Fault>,
    is_own: impl Fn(usize) -> bool,
) -> (Result<Vec<u64>, String>, Option<StrayWrite>) {
    if let Surroundings::Page(AtPage { array: OUTPUT, memory, edge }) = around {
        out.move_to(memory, edge);
    }
    let result = fill(out.array_mut());
    let bits = result.map(|()| out.array().iter().flat_map(|value| value.bits()).collect()).map_err(text);
    (bits, stray_write(OUTPUT, &out, is_own))
}
