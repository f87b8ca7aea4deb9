//! The layers of a session and the shapes below them.

use crate::body::{Body, RestDifference, RestShape};
use std::sync::Arc;

/// A sculpt layer, for viewers.
#[derive(Clone, Debug, PartialEq)]
pub struct SculptLayerState {
    /// Name that the user has given.
    pub name: Arc<str>,
    /// Factor of what is in the layer, 0 (hidden) to 1.
    pub strength: f64,
    /// Whether strokes are recorded in it.
    pub records: bool,
    /// Whether its strength can no longer change, because of a cut or a stitch.
    pub is_fixed: bool,
    /// Number of vertices that it moves, of all bodies.
    pub vertices: usize,
}

/// A sculpt layer: changes of the rest shapes of bodies, with a strength.
#[derive(Clone)]
pub(super) struct SculptLayer {
    pub(super) name: Arc<str>,
    pub(super) strength: f64,
    /// [`SculptLayers::topology`] when it was made.
    pub(super) topology: u64,
    /// What is in it, by body.
    differences: Arc<Vec<RestDifference>>,
}

/// All layers, the lowest first. A clone shares what is in them.
#[derive(Clone, Default)]
pub(in crate::session) struct SculptLayers {
    pub(super) layers: Vec<SculptLayer>,
    /// The layer that records strokes; `None` for the base.
    pub(super) recording: Option<usize>,
    /// Shape of each body below the layers; empty where there are none.
    base: Vec<RestShape>,
    /// Shape of each body when strokes were last assigned.
    assigned: Vec<RestShape>,
    /// Stamp of the connectivity: another one after each cut and stitch.
    topology: u64,
}

impl SculptLayers {
    /// Stamp of the connectivity.
    pub(in crate::session) fn topology(&self) -> u64 {
        self.topology
    }

    /// Whether the strength of a layer can no longer change.
    pub(super) fn is_fixed(&self, layer: usize) -> bool {
        self.layers[layer].topology != self.topology
    }

    /// The index of the layer with this number.
    ///
    /// # Errors
    /// Says which numbers there are.
    pub(super) fn index(&self, layer: u32) -> Result<usize, String> {
        let count = self.layers.len();
        let none = || match count {
            0 => format!("layer {layer}: there is none"),
            _ => format!("layer {layer}: there is none; allowed is 0 to {}", count - 1),
        };
        Some(layer as usize).filter(|layer| *layer < count).ok_or_else(none)
    }

    /// The index of the layer with this number, whose strength may change.
    ///
    /// # Errors
    /// Those of [`SculptLayers::index`]; a layer from before a cut or a stitch.
    pub(super) fn free_index(&self, layer: u32) -> Result<usize, String> {
        let layer = self.index(layer)?;
        if self.is_fixed(layer) {
            let name = &self.layers[layer].name;
            return Err(format!(
                "layer `{name}`: something was cut or stitched since, and the new surface is not in the layer; take that back first, \
                 or merge the layer"
            ));
        }
        Ok(layer)
    }

    /// The layers, for viewers.
    pub(super) fn states(&self) -> Vec<SculptLayerState> {
        let state = |(index, layer): (usize, &SculptLayer)| SculptLayerState {
            name: Arc::clone(&layer.name),
            strength: layer.strength,
            records: self.recording == Some(index),
            is_fixed: self.is_fixed(index),
            vertices: layer.differences.iter().map(RestDifference::vertex_count).sum(),
        };
        self.layers.iter().enumerate().map(state).collect()
    }

    /// Adds an empty layer above the others, which records from now on.
    pub(super) fn add(&mut self, name: &str, bodies: &[Body]) {
        if self.layers.is_empty() {
            self.begin(bodies);
        }
        let differences = Arc::new(vec![RestDifference::default(); bodies.len()]);
        self.layers.push(SculptLayer { name: name.into(), strength: 1.0, topology: self.topology, differences });
        self.recording = Some(self.layers.len() - 1);
    }

    /// Takes a layer out of the stack. With `merge` the base becomes what it is with the layer.
    pub(super) fn remove(&mut self, layer: usize, merge: bool) {
        if merge && !self.is_fixed(layer) {
            let SculptLayer { strength, differences, .. } = &self.layers[layer];
            for (base, difference) in self.base.iter_mut().zip(differences.iter()) {
                base.add(difference, *strength);
            }
        }
        self.layers.remove(layer);
        self.recording = self.recording.filter(|other| *other != layer).map(|other| other - usize::from(other > layer));
        if self.layers.is_empty() {
            (self.base, self.assigned) = (Vec::new(), Vec::new());
        }
    }

    /// Gives what has changed since the last call to the layer that records, or to the base.
    pub(in crate::session) fn assign(&mut self, bodies: &[Body]) {
        if self.layers.is_empty() {
            return;
        }
        for (index, body) in bodies.iter().enumerate() {
            let now = body.rest_shape();
            let changed = now.since(&self.assigned[index]);
            if changed.is_empty() {
                continue;
            }
            match self.recording {
                Some(layer) => Arc::make_mut(&mut self.layers[layer].differences)[index].add(&changed),
                None => {
                    let mut base = self.base[index].clone();
                    base.go_below(&now, &changed, self.above(index));
                    self.base[index] = base;
                }
            }
            self.assigned[index] = now;
        }
    }

    /// A cut or a stitch has changed the connectivity, which now has the stamp `topology`: all layers are fixed in the base from now on. Returns
    /// the name of the layer that recorded.
    pub(in crate::session) fn fix(&mut self, topology: u64, bodies: &[Body]) -> Option<Arc<str>> {
        self.topology = topology;
        if !self.layers.is_empty() {
            self.begin(bodies);
        }
        self.recording.take().map(|layer| Arc::clone(&self.layers[layer].name))
    }

    /// The shape that a body has with its layers.
    pub(super) fn shape(&self, body: usize) -> RestShape {
        let mut shape = self.base[body].clone();
        self.above(body).for_each(|(difference, strength)| shape.add(difference, strength));
        shape
    }

    /// What `shape` changes of a body.
    pub(super) fn change(&self, body: usize, shape: &RestShape) -> RestDifference {
        shape.since(&self.assigned[body])
    }

    /// The bodies have the shapes that the layers give them.
    pub(super) fn take_shapes(&mut self, bodies: &[Body]) {
        self.assigned = bodies.iter().map(Body::rest_shape).collect();
    }

    /// The present shapes are the base.
    fn begin(&mut self, bodies: &[Body]) {
        self.take_shapes(bodies);
        self.base.clone_from(&self.assigned);
    }

    /// What layers that are not fixed add to the base of a body, with their strengths.
    fn above(&self, body: usize) -> impl Iterator<Item = (&RestDifference, f64)> {
        let moving = self.layers.iter().filter(|layer| layer.topology == self.topology);
        moving.map(move |layer| (&layer.differences[body], layer.strength))
    }
}
