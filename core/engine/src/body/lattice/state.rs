//! What of a lattice can be taken back.

use super::bound::Bound;
use super::{Fragments, Kept, Lattice, LatticeError, NodeKey};
use crate::body::fixing::Fixing;
use crate::body::model::Model;
use crate::body::skin::Skin;
use pliant_host::Region;
use pliant_plugin_api::abi::Ball;
use pliant_solver::System;
use std::collections::HashMap;

/// A lattice at one moment: as large as what is active and what was cut.
#[derive(Clone)]
pub struct LatticeState {
    region: Region,
    balls: Vec<Ball>,
    last_balls: Vec<Ball>,
    kept: HashMap<NodeKey, Kept>,
    fragments: Fragments,
    bound: Bound,
    stale: bool,
    steps: u32,
}

impl Lattice {
    /// As it is now.
    pub fn save(&self) -> LatticeState {
        LatticeState {
            region: self.region.clone(),
            balls: self.balls.clone(),
            last_balls: self.last_balls.clone(),
            kept: self.kept.clone(),
            fragments: self.fragments.clone(),
            bound: self.bound.clone(),
            stale: self.stale,
            steps: self.steps,
        }
    }

    /// As it was, with its nodes at rest, on a model and skin that are as they were and settled.
    ///
    /// # Errors
    /// What grid or material say.
    pub fn restore(
        &mut self,
        state: &LatticeState,
        model: &Model,
        fixings: &[Fixing],
        skin: &mut Skin,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let LatticeState { region, balls, last_balls, kept, fragments, bound, stale, steps } = state.clone();
        (self.region, self.spare) = (Region::default(), region);
        self.uncut.clear();
        (self.balls, self.kept, self.fragments) = (balls, kept, fragments);
        (self.bound, self.stale, self.steps, self.last_balls) = (bound, stale, steps, last_balls);
        self.exchange(model, fixings, skin, system)
    }
}
