//! Material plugins as force models of the solver.

use crate::material::Material;
use pliant_plugin_api::abi::{self, Batch};
use pliant_plugin_api::{ElementRequest, PlanesMut, TangentScale};
use pliant_solver::{ElementCall, ForceError, ForceModel};
use std::ptr::null;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl ForceModel for Material {
    #[allow(clippy::misnamed_getters, reason = "the solver's messages name a material by the id that scenes give it")]
    fn name(&self) -> &str {
        &self.info().id
    }

    fn origin(&self) -> String {
        format!("{} ({})", self.name(), self.library().path().display())
    }

    fn last_warning(&self) -> Option<String> {
        self.instance.inbox().last_warning()
    }

    fn element_warning(&self) -> Option<String> {
        self.instance.inbox().element_warning()
    }

    fn forget_element_warning(&self) {
        self.instance.inbox().forget_element_warning();
    }

    fn wants_whole_lists(&self) -> bool {
        self.info().whole_lists
    }

    fn requests(&self) -> &[ElementRequest] {
        &self.requests
    }

    fn rest(&self, call: &ElementCall<'_>, out: &mut [f64]) -> Result<(), ForceError> {
        let rest = self.table.rest.expect("checked");
        // SAFETY: [sim & active]; `out` holds the planes of all elements.
        Ok(self
            .instance
            .run_about_elements("rest", || unsafe { rest(self.instance.plugin(), &batch(call), out.as_mut_ptr()) })?)
    }

    fn directed_rest(
        &self,
        call: &ElementCall<'_>,
        directions: &[[f64; 3]],
        out: &mut [f64],
    ) -> Result<(), ForceError> {
        let count = call.elements.len() / call.corners;
        // Elements without directions have no fibres.
        let none = if directions.is_empty() { vec![[0.0; 3]; count] } else { Vec::new() };
        let directions = if directions.is_empty() { &none } else { directions };
        assert_eq!(directions.len(), count);
        let rest = self.directions.and_then(|table| table.rest).expect("checked when it was opened");
        // SAFETY: [sim & active]; a direction for each element; `out` holds the planes of all elements.
        Ok(self.instance.run_about_elements("rest", || unsafe {
            rest(self.instance.plugin(), &batch(call), directions.as_ptr().cast(), out.as_mut_ptr())
        })?)
    }

    fn mass(&self, call: &ElementCall<'_>, out: &mut [f64]) -> Result<(), ForceError> {
        assert_eq!(out.len(), call.window.len());
        let (mass, base) = (self.table.mass.expect("checked"), out.as_mut_ptr().wrapping_sub(call.window.start));
        // SAFETY: [sim & active]; the window behind `base` is `out`, all ours.
        Ok(self.instance.run("mass", || unsafe { mass(self.instance.plugin(), &batch(call), base) })?)
    }

    fn energy(&self, call: &ElementCall<'_>) -> Result<f64, ForceError> {
        let (energy, mut sum) = (self.table.energy.expect("checked"), 0.0);
        // SAFETY: [sim & active]; `sum` is ours.
        let status =
            self.instance.within("energy", || unsafe { energy(self.instance.plugin(), &batch(call), &mut sum) });
        self.instance.check("energy", status)?;
        if sum.is_finite() {
            Ok(sum)
        } else {
            Err(self.instance.error("energy", &format!("the result is {sum} J")).into())
        }
    }

    fn forces(&self, call: &ElementCall<'_>, out: &mut [[f64; 3]]) -> Result<(), ForceError> {
        assert_eq!(out.len(), call.window.len());
        let (forces, base) = (self.table.forces.expect("checked"), out.as_mut_ptr().wrapping_sub(call.window.start));
        // SAFETY: [sim & active]; the window behind `base` is `out`, all ours.
        Ok(self.instance.run("forces", || unsafe { forces(self.instance.plugin(), &batch(call), base.cast()) })?)
    }

    fn tangent(
        &self,
        call: &ElementCall<'_>,
        TangentScale { stiffness, damping }: TangentScale,
        slots: &[u32],
        first: usize,
        values: &mut [[f64; 9]],
    ) -> Result<(), ForceError> {
        debug_assert_eq!(slots.len(), call.elements.len() / call.corners * (call.corners * (call.corners + 1) / 2));
        let tangent = self.table.tangent.expect("checked");
        let blocks = abi::Blocks {
            size: size_of::<abi::Blocks>(),
            values: values.as_mut_ptr().wrapping_sub(first).cast(),
            slots: slots.as_ptr(),
            slot_begin: first,
            slot_end: first + values.len(),
        };
        // SAFETY: [sim & active]; the blocks behind `values` are ours for the call.
        let status = self.instance.within("tangent", || unsafe {
            tangent(self.instance.plugin(), &batch(call), stiffness, damping, &blocks)
        });
        Ok(self.instance.check("tangent", status)?)
    }

    fn advance(&self, call: &ElementCall<'_>, history: &mut PlanesMut<'_>) -> Result<(), ForceError> {
        let Some(advance) = self.table.advance else { return Ok(()) };
        let count = call.elements.len() / call.corners;
        let base = history.base_for(&call.range, call.history.len() / count.max(1), count);
        // SAFETY: [sim & active]; `history` holds the planes of all elements, and those of the call's range, which are all that the
        // call writes, are ours.
        Ok(self.instance.run("advance", || unsafe { advance(self.instance.plugin(), &batch(call), base) })?)
    }

    fn failed(&self, call: &ElementCall<'_>, out: &mut [u8]) -> Result<(), ForceError> {
        assert_eq!(out.len(), call.elements.len() / call.corners);
        let failed = self.failure.and_then(|table| table.failed).expect("checked when it was opened");
        // SAFETY: [sim & active]; `out` holds a byte for each element.
        Ok(self.instance.run("failed", || unsafe { failed(self.instance.plugin(), &batch(call), out.as_mut_ptr()) })?)
    }

    fn strain(&self, call: &ElementCall<'_>, planes: &mut PlanesMut<'_>) -> Result<(), ForceError> {
        let strain = self.coupled.and_then(|table| table.strain).expect("checked when it was opened");
        let base = planes.base_for(&call.range, 13, call.elements.len() / call.corners);
        // SAFETY: [sim & active]; `planes` holds the planes of all elements, and those of the call's range, which are all that the
        // call writes, are ours.
        Ok(self.instance.run("strain", || unsafe { strain(self.instance.plugin(), &batch(call), base) })?)
    }

    fn compliance(&self, call: &ElementCall<'_>, planes: &mut [f64]) -> Result<(), ForceError> {
        let compliance = self.coupled.and_then(|table| table.compliance).expect("checked when it was opened");
        // SAFETY: [sim & active]; `planes` holds the planes of all elements.
        let status = self
            .instance
            .within("compliance", || unsafe { compliance(self.instance.plugin(), &batch(call), planes.as_mut_ptr()) });
        Ok(self.instance.check("compliance", status)?)
    }

    fn normals_energy(&self, call: &ElementCall<'_>, normals: &[[f64; 3]]) -> Result<f64, ForceError> {
        assert_eq!(normals.len(), call.x.len());
        let (energy, mut sum) = (self.normals().energy.expect("checked"), 0.0);
        // SAFETY: [sim & active]; a normal for each node; `sum` is ours.
        let status = self.instance.within("normals_energy", || unsafe {
            energy(self.instance.plugin(), &batch(call), normals.as_ptr().cast(), &mut sum)
        });
        self.instance.check("normals_energy", status)?;
        let error = || self.instance.error("normals_energy", &format!("the result is {sum} J")).into();
        if sum.is_finite() { Ok(sum) } else { Err(error()) }
    }

    fn normals_forces(
        &self,
        call: &ElementCall<'_>,
        normals: &[[f64; 3]],
        out: &mut [[f64; 6]],
    ) -> Result<(), ForceError> {
        assert_eq!((normals.len(), out.len()), (call.x.len(), call.window.len()));
        let (forces, base) =
            (self.normals().forces.expect("checked"), out.as_mut_ptr().wrapping_sub(call.window.start));
        // SAFETY: [sim & active]; a normal for each node; the window behind `base` is `out`, all ours.
        let status = self.instance.within("normals_forces", || unsafe {
            forces(self.instance.plugin(), &batch(call), normals.as_ptr().cast(), base.cast())
        });
        Ok(self.instance.check("normals_forces", status)?)
    }

    fn tilt(&self, call: &ElementCall<'_>, planes: &mut [f64]) -> Result<(), ForceError> {
        let tilt = self.normals().tilt.expect("checked");
        // SAFETY: [sim & active]; `planes` holds the planes of all elements.
        Ok(self.instance.run("tilt", || unsafe { tilt(self.instance.plugin(), &batch(call), planes.as_mut_ptr()) })?)
    }

    fn has_single(&self) -> bool {
        let mut forces = self.requests.iter().filter(|r| r.flags & abi::HAS_FORCES != 0);
        self.normals.is_none() && forces.all(|r| r.flags & abi::HAS_SINGLE != 0)
    }

    fn single_tangent(
        &self,
        call: &ElementCall<'_>,
        TangentScale { stiffness, damping }: TangentScale,
        slots: &[u32],
        first: usize,
        values: &mut [[f32; 9]],
    ) -> Result<(), ForceError> {
        debug_assert_eq!(slots.len(), call.elements.len() / call.corners * (call.corners * (call.corners + 1) / 2));
        let tangent = self.single.and_then(|table| table.tangent).expect("checked when it was opened");
        let blocks = abi::SingleBlocks {
            size: size_of::<abi::SingleBlocks>(),
            values: values.as_mut_ptr().wrapping_sub(first).cast(),
            slots: slots.as_ptr(),
            slot_begin: first,
            slot_end: first + values.len(),
        };
        // SAFETY: [sim & active]; the blocks behind `values` are ours for the call.
        let status = self.instance.within("single_tangent", || unsafe {
            tangent(self.instance.plugin(), &batch(call), stiffness, damping, &blocks)
        });
        Ok(self.instance.check("single_tangent", status)?)
    }
}

/// The arguments of a call in the form of the plugin interface. Debug builds check what the interface promises to plugins.
fn batch(call: &ElementCall<'_>) -> Batch {
    let count = call.elements.len() / call.corners;
    debug_assert!(call.range.end <= count && call.window.end <= call.x.len());
    debug_assert!(call.family.is_empty() || call.family.len() == count);
    debug_assert!(call.measure.len() == count);
    debug_assert!(call.material.is_empty() || call.material.len() == 2 * call.elements.len());
    debug_assert!(call.rest.len() == call.x.len() && call.v.len() == call.x.len());
    debug_assert!(
        call.elements[call.range.start * call.corners..call.range.end * call.corners]
            .iter()
            .all(|&n| call.window.contains(&(n as usize)))
    );
    debug_assert!(
        [call.rest_data, call.history, call.fields]
            .iter()
            .all(|data| data.len() == count * (data.len() / count.max(1)))
    );
    let planes = |data: &[f64]| data.len() / count.max(1);
    let or_null = |slice: &[f64]| if slice.is_empty() { null() } else { slice.as_ptr() };
    Batch {
        size: size_of::<Batch>(),
        kind: call.kind,
        corners: call.corners as u32,
        begin: call.range.start,
        end: call.range.end,
        count,
        node_begin: call.window.start,
        node_end: call.window.end,
        nodes: call.x.len(),
        elements: call.elements.as_ptr(),
        family: if call.family.is_empty() { null() } else { call.family.as_ptr() },
        measure: call.measure.as_ptr(),
        material: or_null(call.material),
        rest: call.rest.as_ptr().cast(),
        x: call.x.as_ptr().cast(),
        v: call.v.as_ptr().cast(),
        rest_data: or_null(call.rest_data),
        history: or_null(call.history),
        time: call.time.start,
        dt: call.time.dt,
        rest_stride: planes(call.rest_data),
        history_stride: planes(call.history),
        field_count: planes(call.fields),
        fields: or_null(call.fields),
    }
}
