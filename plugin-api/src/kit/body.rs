//! Nodes and elements in a state, and what a material makes of them.

use super::subject::{Call, Subject};
use super::{Given, corners};
use crate::abi;
use crate::fault::Fault;
use crate::material::{ElementRequest, Tangent};
use core::marker::PhantomData;
use std::ops::Range;
use std::ptr::null;

/// Nodes and elements in a state.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// m (n x 3)
    pub rest: Vec<[f64; 3]>,
    /// m (n x 3)
    pub x: Vec<[f64; 3]>,
    /// m/s (n x 3)
    pub v: Vec<[f64; 3]>,
    parts: Vec<Part>,
}

#[derive(Clone, Debug)]
struct Part {
    request: ElementRequest,
    corners: usize,
    nodes: Vec<u32>,
    family: Vec<u32>,
    measure: Vec<f64>,
    material: Vec<f64>,
    rest_data: Vec<f64>,
    history: Vec<f64>,
}

impl Part {
    fn count(&self) -> usize {
        self.nodes.len() / self.corners
    }
}

impl Body {
    /// A body at rest with the elements `material` asks for, which `elements` gives by kind; rest data written.
    ///
    /// # Errors
    /// What the material says of the rest shape.
    pub fn new<S: Subject + ?Sized>(
        material: &S,
        rest: Vec<[f64; 3]>,
        elements: impl Fn(&ElementRequest) -> Given,
    ) -> Result<Self, Fault> {
        let mut body = Self { x: rest.clone(), v: vec![[0.0; 3]; rest.len()], rest, parts: Vec::new() };
        for request in material.wants()? {
            let given = elements(&request);
            let corners = corners(request.kind);
            let count = given.nodes.len() / corners;
            assert!(given.nodes.iter().all(|n| (*n as usize) < body.rest.len()), "a node there is not");
            let or = |list: Vec<f64>| if list.is_empty() { vec![1.0; count] } else { list };
            body.parts.push(Part {
                request,
                corners,
                nodes: given.nodes,
                family: if given.family.is_empty() { vec![abi::STRUCTURAL; count] } else { given.family },
                measure: or(given.measure),
                material: given.material,
                rest_data: vec![0.0; count * request.rest_stride as usize],
                history: vec![0.0; count * request.history_stride as usize],
            });
        }
        for p in 0..body.parts.len() {
            if body.parts[p].request.rest_stride == 0 {
                continue;
            }
            let mut data = std::mem::take(&mut body.parts[p].rest_data);
            material.rest_of(&body.call(p, 0..body.parts[p].count()), &mut data)?;
            body.parts[p].rest_data = data;
        }
        Ok(body)
    }

    /// The call for a range of a part's elements, with the span of nodes they touch.
    fn call(&self, part: usize, range: Range<usize>) -> Call<'_> {
        let p = &self.parts[part];
        let touched = || p.nodes[range.start * p.corners..range.end * p.corners].iter().map(|n| *n as usize);
        let window = (touched().min().unwrap_or(0), touched().max().map_or(0, |n| n + 1));
        let or_null = |list: &[f64]| if list.is_empty() { null() } else { list.as_ptr() };
        let batch = abi::Batch {
            size: size_of::<abi::Batch>(),
            kind: p.request.kind,
            corners: p.corners as u32,
            begin: range.start,
            end: range.end,
            count: p.count(),
            node_begin: window.0,
            node_end: window.1,
            nodes: self.rest.len(),
            elements: p.nodes.as_ptr(),
            family: if p.request.kind == abi::LINK { p.family.as_ptr() } else { null() },
            measure: p.measure.as_ptr(),
            material: or_null(&p.material),
            rest: self.rest.as_ptr().cast(),
            x: self.x.as_ptr().cast(),
            v: self.v.as_ptr().cast(),
            rest_data: or_null(&p.rest_data),
            history: or_null(&p.history),
            time: 0.0,
            dt: 1e-3,
        };
        Call { batch, borrowed: PhantomData }
    }

    /// Runs `run` on every part with `flag`, in ranges of at most `most` elements.
    pub(super) fn each(
        &self,
        flag: u32,
        most: usize,
        mut run: impl FnMut(usize, &Call<'_>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        for p in (0..self.parts.len()).filter(|p| self.parts[*p].request.flags & flag != 0) {
            let count = self.parts[p].count();
            for begin in (0..count).step_by(most.clamp(1, count.max(1))) {
                run(p, &self.call(p, begin..count.min(begin.saturating_add(most))))?;
            }
        }
        Ok(())
    }

    /// Whether any element has all of these flags.
    pub fn has(&self, flags: u32) -> bool {
        self.parts.iter().any(|p| p.request.flags & flags == flags)
    }

    /// Elements of every kind, and the flags of each.
    pub fn counts(&self) -> impl Iterator<Item = (ElementRequest, usize)> + '_ {
        self.parts.iter().map(|p| (p.request, p.count()))
    }

    /// kg (n)
    ///
    /// # Errors
    /// What the material says.
    pub fn mass<S: Subject + ?Sized>(&self, material: &S) -> Result<Vec<f64>, Fault> {
        let mut mass = vec![0.0; self.rest.len()];
        self.each(abi::HAS_MASS, usize::MAX, |_, call| material.mass_of(call, &mut mass))?;
        Ok(mass)
    }

    /// J
    ///
    /// # Errors
    /// What the material says.
    pub fn energy<S: Subject + ?Sized>(&self, material: &S) -> Result<f64, Fault> {
        let mut energy = 0.0;
        self.each(abi::HAS_FORCES, usize::MAX, |_, call| {
            energy += material.energy_of(call)?;
            Ok(())
        })?;
        Ok(energy)
    }

    /// Adds to `force`, N (n x 3).
    ///
    /// # Errors
    /// What the material says.
    pub fn add_forces<S: Subject + ?Sized>(&self, material: &S, force: &mut [[f64; 3]]) -> Result<(), Fault> {
        self.add_forces_in(material, usize::MAX, force)
    }

    /// The same, in ranges of at most `most` elements.
    ///
    /// # Errors
    /// What the material says.
    pub fn add_forces_in<S: Subject + ?Sized>(
        &self,
        material: &S,
        most: usize,
        force: &mut [[f64; 3]],
    ) -> Result<(), Fault> {
        self.each(abi::HAS_FORCES, most, |_, call| material.forces_of(call, force))
    }

    /// N (n x 3)
    ///
    /// # Errors
    /// What the material says.
    pub fn forces<S: Subject + ?Sized>(&self, material: &S) -> Result<Vec<[f64; 3]>, Fault> {
        let mut force = vec![[0.0; 3]; self.rest.len()];
        self.add_forces(material, &mut force)?;
        Ok(force)
    }

    /// Dense `scale.stiffness K + scale.damping C`, N/m, (3n x 3n) row-major.
    ///
    /// # Errors
    /// What the material says.
    pub fn tangent<S: Subject + ?Sized>(&self, material: &S, scale: Tangent) -> Result<Vec<f64>, Fault> {
        let blocks = self.blocks(material, scale, usize::MAX)?;
        Ok(self.dense(&blocks))
    }

    /// The blocks of every element with forces, N/m (m x pairs x 9 for each part), in ranges of at most `most` elements.
    ///
    /// # Errors
    /// What the material says.
    pub fn blocks<S: Subject + ?Sized>(
        &self,
        material: &S,
        scale: Tangent,
        most: usize,
    ) -> Result<Vec<Vec<[f64; 9]>>, Fault> {
        let size = |p: &Part| p.count() * p.corners * (p.corners + 1) / 2;
        let slots: Vec<Vec<u32>> = self.parts.iter().map(|p| (0..size(p) as u32).collect()).collect();
        let mut out: Vec<Vec<[f64; 9]>> = self.parts.iter().map(|p| vec![[0.0; 9]; size(p)]).collect();
        self.each(abi::HAS_FORCES, most, |p, call| material.tangent_of(call, scale, &slots[p], &mut out[p]))?;
        Ok(out)
    }

    /// The same in single precision, of elements that have it: only blocks of two corners.
    ///
    /// # Errors
    /// What the material says.
    pub fn single_blocks<S: Subject + ?Sized>(
        &self,
        material: &S,
        scale: Tangent,
        most: usize,
    ) -> Result<Vec<Vec<[f32; 9]>>, Fault> {
        let size = |p: &Part| p.count() * p.corners * (p.corners + 1) / 2;
        let slots: Vec<Vec<u32>> = self.parts.iter().map(|p| (0..size(p) as u32).collect()).collect();
        let mut out: Vec<Vec<[f32; 9]>> = self.parts.iter().map(|p| vec![[0.0; 9]; size(p)]).collect();
        self.each(abi::HAS_SINGLE, most, |p, call| material.single_tangent_of(call, scale, &slots[p], &mut out[p]))?;
        Ok(out)
    }

    /// Coupled hinges: strains, m, and their gradients by corner and axis (13 x m, plane-major), and their corners (m).
    ///
    /// # Errors
    /// What the material says.
    pub fn strains<S: Subject + ?Sized>(&self, material: &S) -> Result<(Vec<f64>, Vec<[u32; 4]>), Fault> {
        self.planes((abi::HINGE, abi::IS_COUPLED), 13, |call, out| material.strain_of(call, out))
    }

    /// Coupled triangles: compliances between the sides, m/N (6 x m, plane-major), and their corners (m).
    ///
    /// # Errors
    /// What the material says.
    pub fn compliances<S: Subject + ?Sized>(&self, material: &S) -> Result<(Vec<f64>, Vec<[u32; 3]>), Fault> {
        self.planes((abi::TRIANGLE, abi::IS_COUPLED), 6, |call, out| material.compliance_of(call, out))
    }

    /// NaN where nothing was written.
    pub(super) fn planes<const K: usize>(
        &self,
        (kind, flag): (u32, u32),
        planes: usize,
        mut fill: impl FnMut(&Call<'_>, &mut [f64]) -> Result<(), Fault>,
    ) -> Result<(Vec<f64>, Vec<[u32; K]>), Fault> {
        let Some(part) = self.parts.iter().find(|p| p.request.kind == kind) else { return Ok(Default::default()) };
        let mut out = vec![f64::NAN; planes * part.count()];
        self.each(
            flag,
            usize::MAX,
            |p, call| {
                if self.parts[p].request.kind == kind { fill(call, &mut out) } else { Ok(()) }
            },
        )?;
        Ok((out, part.nodes.as_chunks::<K>().0.to_vec()))
    }

    fn dense(&self, blocks: &[Vec<[f64; 9]>]) -> Vec<f64> {
        let width = 3 * self.rest.len();
        let mut dense = vec![0.0; width * width];
        for (part, blocks) in self.parts.iter().zip(blocks) {
            let k = part.corners;
            let pairs = (0..k).flat_map(|a| (a..k).map(move |b| (a, b)));
            for (element, e) in part.nodes.chunks_exact(k).zip(0..) {
                for ((a, b), pair) in pairs.clone().zip(0..) {
                    let (i, j) = (3 * element[a] as usize, 3 * element[b] as usize);
                    for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                        let value = blocks[e * k * (k + 1) / 2 + pair][3 * r + c];
                        dense[(i + r) * width + j + c] += value;
                        if a != b {
                            dense[(j + c) * width + i + r] += value;
                        }
                    }
                }
            }
        }
        dense
    }
}
