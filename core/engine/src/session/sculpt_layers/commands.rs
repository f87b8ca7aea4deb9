//! What a user asks of sculpt layers, and what is refused.

use super::SculptLayerState;
use crate::session::{EventKind, Session};

/// Why a change of the layers was refused.
type Refusal = String;

impl Session {
    /// The sculpt layers, the lowest first.
    pub fn sculpt_layers(&self) -> Vec<SculptLayerState> {
        self.editing.layers.states()
    }

    /// Adds a layer, which records strokes from now on.
    pub(in crate::session) fn add_layer(&mut self, name: &str) -> bool {
        self.change_layers(
            None,
            |_| Ok(true),
            |session| {
                session.editing.layers.add(name, &session.bodies);
                Ok(())
            },
        )
    }

    /// Gives a layer another name.
    pub(in crate::session) fn rename_layer(&mut self, layer: u32, name: &str) -> bool {
        let differs =
            |session: &Self| Ok(*session.editing.layers.layers[session.editing.layers.index(layer)?].name != *name);
        self.change_layers(None, differs, |session| {
            let layer = session.editing.layers.index(layer)?;
            session.editing.layers.layers[layer].name = name.into();
            Ok(())
        })
    }

    /// Strokes are recorded in a layer, which gets its full strength, or in the base.
    pub(in crate::session) fn record_layer(&mut self, layer: Option<u32>) -> bool {
        let differs = |session: &Self| {
            let layer = layer.map(|layer| session.editing.layers.free_index(layer)).transpose()?;
            Ok(session.editing.layers.recording != layer)
        };
        self.change_layers(None, differs, |session| {
            let Some(layer) = layer else {
                session.editing.layers.recording = None;
                return Ok(());
            };
            let layer = session.editing.layers.free_index(layer)?;
            session.editing.layers.recording = Some(layer);
            session.blend(layer, 1.0)
        })
    }

    /// Gives a layer another strength, 0 to 1. At less than 1 it no longer records.
    pub(in crate::session) fn set_layer_strength(&mut self, layer: u32, strength: f64) -> bool {
        let differs = |session: &Self| {
            let layer = &session.editing.layers.layers[session.editing.layers.free_index(layer)?];
            if !(0.0..=1.0).contains(&strength) {
                return Err(format!("layer `{}`: strength {strength}; allowed is 0 to 1", layer.name));
            }
            Ok(layer.strength != strength)
        };
        self.change_layers(Some(layer), differs, |session| {
            let layer = session.editing.layers.free_index(layer)?;
            if strength < 1.0 {
                session.editing.layers.recording = session.editing.layers.recording.filter(|other| *other != layer);
            }
            session.blend(layer, strength)
        })
    }

    /// Makes a layer a part of the base, at its present strength.
    pub(in crate::session) fn merge_layer(&mut self, layer: u32) -> bool {
        let exists = |session: &Self| session.editing.layers.index(layer).map(|_| true);
        self.change_layers(None, exists, |session| {
            let layer = session.editing.layers.index(layer)?;
            session.editing.layers.remove(layer, true);
            Ok(())
        })
    }

    /// Deletes a layer with what it does to the shape.
    pub(in crate::session) fn delete_layer(&mut self, layer: u32) -> bool {
        let is_free = |session: &Self| session.editing.layers.free_index(layer).map(|_| true);
        self.change_layers(None, is_free, |session| {
            let layer = session.editing.layers.free_index(layer)?;
            session.blend(layer, 0.0)?;
            session.editing.layers.remove(layer, false);
            Ok(())
        })
    }

    /// Ends edits, changes the layers and remembers what was before, if `differs` says that there is anything to change; a change that it refuses leaves
    /// edits under way alone. Changes of the strength of one layer after another, `strength_of`, are taken back together. Returns whether anything
    /// has changed; where it was refused, an event says why.
    fn change_layers(
        &mut self,
        strength_of: Option<u32>,
        differs: impl FnOnce(&Self) -> Result<bool, Refusal>,
        change: impl FnOnce(&mut Self) -> Result<(), Refusal>,
    ) -> bool {
        match differs(self) {
            Ok(true) => {}
            Ok(false) => return false,
            Err(why) => {
                self.refuse_layers(why);
                return false;
            }
        }
        self.end_edits();
        self.editing.layers.assign(&self.bodies);
        let (before, layers) = (self.editing.history.kept.then(|| self.save()), self.editing.layers.clone());
        if let Err(why) = change(self) {
            self.editing.layers = layers;
            self.refuse_layers(why);
            return false;
        }
        if let Some(before) = before {
            self.editing.history.record_layers(before, strength_of);
        }
        true
    }

    fn refuse_layers(&mut self, why: Refusal) {
        let time = self.time();
        self.events.add(EventKind::LayerRefused, time, || why);
    }

    /// Gives a layer a strength and all bodies the shape that they have then.
    fn blend(&mut self, layer: usize, strength: f64) -> Result<(), Refusal> {
        if self.editing.layers.layers[layer].strength == strength {
            return Ok(());
        }
        self.editing.layers.layers[layer].strength = strength;
        let shapes: Vec<_> = (0..self.bodies.len()).map(|body| self.editing.layers.shape(body)).collect();
        let changes: Vec<_> =
            shapes.iter().enumerate().map(|(body, shape)| self.editing.layers.change(body, shape)).collect();
        let name = std::sync::Arc::clone(&self.editing.layers.layers[layer].name);
        let refused =
            |body: &str, why: String| format!("layer `{name}` at strength {strength:.2}: body `{body}`: {why}");
        let changing = self.bodies.iter().zip(&shapes).zip(&changes).filter(|(_, change)| !change.is_empty());
        for ((body, shape), change) in changing {
            let flat = body.flat_parts(shape, change).map_err(|error| refused(&body.name, error.to_string()))?;
            if let Some(flat) = flat {
                let (parts, count, at) = (flat.parts, flat.count, flat.place.as_slice());
                let why = format!("{count} {parts} near {at:?} m would be inverted or flat");
                return Err(refused(&body.name, why));
            }
        }
        let before: Vec<_> = self.bodies.iter().map(crate::body::Body::rest_shape).collect();
        for index in 0..self.bodies.len() {
            if changes[index].is_empty() {
                continue;
            }
            if let Err(error) = self.bodies[index].set_rest_shape(&shapes[index]) {
                let why = refused(&self.bodies[index].name, error.to_string());
                // Those before it took their shapes and take the old ones again.
                for earlier in (0..index).filter(|earlier| !changes[*earlier].is_empty()) {
                    if let Err(error) = self.bodies[earlier].set_rest_shape(&before[earlier]) {
                        self.freeze(earlier, self.time(), error.to_string());
                    }
                    self.changed(earlier);
                }
                return Err(why);
            }
            self.changed(index);
            if let Err(error) = self.bodies[index].find_one_sided(self.motion.pool()) {
                self.freeze(index, self.time(), error.to_string());
            }
        }
        for slot in &mut self.tools {
            slot.tool.release(&slot.hand);
        }
        self.editing.layers.take_shapes(&self.bodies);
        Ok(())
    }
}
