//! What may hold nodes during a step.

use crate::algebra::Vec3;
use crate::system::System;

/// Times contacts are looked at anew in a step, at most.
pub const PASSES: usize = 4;

/// What holds nodes during a step and lets them go again, such as a sphere in contact.
pub trait Holds {
    /// Constrains nodes, from the positions they have. `dt` (s) is how long the velocities of the step last.
    fn begin(&mut self, system: &mut System, dt: f64);
    /// Adds what it does besides, N.
    fn add_forces(&self, force: &mut [Vec3]);
    /// Looks at what a step does. Gives whether other nodes are held now, or other forces act. Where the step is not solved to the end,
    /// only what is certain changes.
    fn revise(&mut self, system: &mut System, outcome: &Outcome<'_>) -> bool;
    /// Whether it is certain, from a step that is being solved, what [`Holds::revise`] is going to change, and that it is something.
    fn foresees(&self, _: &System, _: &Outcome<'_>) -> bool {
        false
    }
    /// Whether it may come to hold a node in this step.
    fn is_near(&self) -> bool;
    /// Whether it holds any node.
    fn is_holding(&self) -> bool;
    /// Lets go of all nodes. To what it took to hold each, N (n x 3), it adds what it did to them besides.
    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]);
}

/// What a step does to nodes.
pub struct Outcome<'a> {
    /// m/s, the velocity it gives a node
    pub after: &'a dyn Fn(&System, usize) -> Vec3,
    /// N, what it takes to hold a node
    pub reaction: &'a dyn Fn(usize) -> Vec3,
    /// How far they may be off, where the step is not solved to the end.
    pub doubt: Option<&'a Doubt<'a>>,
}

/// N, how far what it takes to hold a node may be off along a unit vector, and m/s, its velocity.
pub type Doubt<'a> = dyn Fn(&System, usize, Vec3) -> [f64; 2] + 'a;

/// Nothing is held.
pub struct HoldsNothing;

impl Holds for HoldsNothing {
    fn begin(&mut self, _: &mut System, _: f64) {}

    fn add_forces(&self, _: &mut [Vec3]) {}

    fn revise(&mut self, _: &mut System, _: &Outcome<'_>) -> bool {
        false
    }

    fn is_near(&self) -> bool {
        false
    }

    fn is_holding(&self) -> bool {
        false
    }

    fn end(&mut self, _: &mut System, _: &mut [Vec3]) {}
}
