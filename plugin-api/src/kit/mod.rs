//! A small body to hold a material against, for an author's own tests and benches: no host, no library loading.

mod block;

pub use block::{Block, block};

use crate::abi;
use crate::batch::{Blocks, Elements, NodeScalars, NodeVectors, Planes};
use crate::fault::Fault;
use crate::material::{ElementRequest, Material, Tangent};
use crate::param::{Params, Value, defaults, position};
use std::ptr::null;

/// Makes a material from its defaults and the given numbers, as a host would.
///
/// # Errors
/// What the material says of its parameters.
///
/// # Panics
/// On a key that is not declared.
pub fn material<M: Material>(numbers: &[(&str, f64)]) -> Result<M, Fault> {
    let mut values = defaults(M::INFO.params);
    for &(key, value) in numbers {
        let at = position(M::INFO.params, key).unwrap_or_else(|| panic!("parameter `{key}` is not declared"));
        values[at] = Value::Number(value);
    }
    M::new(&Params::new(M::INFO.params, &values))
}

/// Elements of one kind, as an author gives them.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// (m x k), k nodes each
    pub nodes: Vec<u32>,
    /// (m), or empty for all structural
    pub family: Vec<u32>,
    /// (m), or empty for all 1
    pub measure: Vec<f64>,
    /// m (m x k x 2), or empty
    pub material: Vec<f64>,
}

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

/// Corners of an element kind.
///
/// # Panics
/// On a kind there is not.
pub fn corners(kind: u32) -> usize {
    match kind {
        abi::POINT => 1,
        abi::LINK => 2,
        abi::TRIANGLE => 3,
        abi::HINGE | abi::TETRAHEDRON => 4,
        _ => panic!("no element kind {kind}"),
    }
}

impl Body {
    /// A body at rest with the elements `material` asks for, which `elements` gives by kind; rest data written.
    ///
    /// # Errors
    /// What the material says of the rest shape.
    pub fn new<M: Material>(
        material: &M,
        rest: Vec<[f64; 3]>,
        elements: impl Fn(&ElementRequest) -> Given,
    ) -> Result<Self, Fault> {
        let mut body = Self { x: rest.clone(), v: vec![[0.0; 3]; rest.len()], rest, parts: Vec::new() };
        for request in material.elements() {
            let given = elements(&request);
            let corners = corners(request.kind);
            let count = given.nodes.len() / corners;
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
            let batch = body.batch(p);
            material.rest(&Elements(&batch), &mut Planes::new(&batch, data.as_mut_ptr()))?;
            body.parts[p].rest_data = data;
        }
        Ok(body)
    }

    fn batch(&self, part: usize) -> abi::Batch {
        let p = &self.parts[part];
        let count = p.nodes.len() / p.corners;
        abi::Batch {
            size: size_of::<abi::Batch>(),
            kind: p.request.kind,
            corners: p.corners as u32,
            begin: 0,
            end: count,
            count,
            node_begin: 0,
            node_end: self.rest.len(),
            nodes: self.rest.len(),
            elements: p.nodes.as_ptr(),
            family: p.family.as_ptr(),
            measure: p.measure.as_ptr(),
            material: if p.material.is_empty() { null() } else { p.material.as_ptr() },
            rest: self.rest.as_ptr().cast(),
            x: self.x.as_ptr().cast(),
            v: self.v.as_ptr().cast(),
            rest_data: p.rest_data.as_ptr(),
            history: p.history.as_ptr(),
            time: 0.0,
            dt: 1e-3,
        }
    }

    fn each(&self, flag: u32, mut run: impl FnMut(&abi::Batch, &Part) -> Result<(), Fault>) -> Result<(), Fault> {
        (0..self.parts.len())
            .filter(|&p| self.parts[p].request.flags & flag != 0)
            .try_for_each(|p| run(&self.batch(p), &self.parts[p]))
    }

    /// kg (n)
    ///
    /// # Errors
    /// What the material says.
    pub fn mass<M: Material>(&self, material: &M) -> Result<Vec<f64>, Fault> {
        let mut mass = vec![0.0; self.rest.len()];
        self.each(abi::HAS_MASS, |batch, _| {
            material.mass(&Elements(batch), &mut NodeScalars::new(batch, mass.as_mut_ptr()))
        })?;
        Ok(mass)
    }

    /// J
    ///
    /// # Errors
    /// What the material says.
    pub fn energy<M: Material>(&self, material: &M) -> Result<f64, Fault> {
        let mut energy = 0.0;
        self.each(abi::HAS_FORCES, |batch, _| {
            energy += material.energy(&Elements(batch))?;
            Ok(())
        })?;
        Ok(energy)
    }

    /// Adds to `force`, N (n x 3).
    ///
    /// # Errors
    /// What the material says.
    pub fn add_forces<M: Material>(&self, material: &M, force: &mut [[f64; 3]]) -> Result<(), Fault> {
        self.each(abi::HAS_FORCES, |batch, _| {
            material.forces(&Elements(batch), &mut NodeVectors::new(batch, force.as_mut_ptr().cast()))
        })
    }

    /// Dense `scale.stiffness K + scale.damping C`, N/m, (3n x 3n) row-major.
    ///
    /// # Errors
    /// What the material says.
    pub fn tangent<M: Material>(&self, material: &M, scale: Tangent) -> Result<Vec<f64>, Fault> {
        let width = 3 * self.rest.len();
        let mut dense = vec![0.0; width * width];
        self.each(abi::HAS_FORCES, |batch, part| {
            let pairs = part.corners * (part.corners + 1) / 2;
            let blocks = batch.count * pairs;
            let slots: Vec<u32> = (0..blocks as u32).collect();
            let mut values = vec![0.0; 9 * blocks];
            let raw = abi::Blocks {
                size: size_of::<abi::Blocks>(),
                values: values.as_mut_ptr(),
                slots: slots.as_ptr(),
                slot_begin: 0,
                slot_end: blocks,
            };
            material.tangent(&Elements(batch), scale, &mut Blocks::new(batch, &raw))?;
            for e in 0..batch.count {
                let mut slot = e * pairs;
                for a in 0..part.corners {
                    for b in a..part.corners {
                        let (i, j) =
                            (part.nodes[e * part.corners + a] as usize, part.nodes[e * part.corners + b] as usize);
                        for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                            let value = values[9 * slot + 3 * r + c];
                            dense[(3 * i + r) * width + 3 * j + c] += value;
                            if a != b {
                                dense[(3 * j + c) * width + 3 * i + r] += value;
                            }
                        }
                        slot += 1;
                    }
                }
            }
            Ok(())
        })?;
        Ok(dense)
    }
}
