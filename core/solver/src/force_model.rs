//! What the solver asks of a material: element requests, rest data, masses, energy, forces and stiffness.
//!
//! The solver calls a [`ForceModel`] on ranges of elements ([`ElementCall`]) and never learns where it comes from: `pliant-host`
//! implements it for a plugin, a test or a program may implement it directly.

use pliant_plugin_api::{ElementRequest, PlanesMut, TangentScale};
use std::ops::Range;
use thiserror::Error;

/// One call: a range of the elements of one kind, and the state they are in.
#[derive(Clone, Debug)]
pub struct ElementCall<'a> {
    /// One of [`POINT`](pliant_plugin_api::abi::POINT), [`LINK`](pliant_plugin_api::abi::LINK) and the others of that module.
    pub kind: u32,
    /// Number of nodes of each element, k.
    pub corners: usize,
    /// Indices of the elements of this call.
    pub range: Range<usize>,
    /// Span of nodes they touch: all of their corners lie in it.
    pub window: Range<usize>,
    /// Node indices of all elements (m x k).
    pub elements: &'a [u32],
    /// Family of each element (m), or empty.
    pub family: &'a [u32],
    /// Volume, area or length that each element represents (m).
    pub measure: &'a [f64],
    /// Material coordinates of the corners, m (m x k x 2), or empty.
    pub material: &'a [f64],
    /// Rest positions of all nodes, m (n x 3).
    pub rest: &'a [[f64; 3]],
    /// Positions of all nodes, m (n x 3).
    pub x: &'a [[f64; 3]],
    /// Velocities of all nodes, m/s (n x 3).
    pub v: &'a [[f64; 3]],
    /// Rest data the model wrote (stride x m).
    pub rest_data: &'a [f64],
    /// History of the elements (stride x m).
    pub history: &'a [f64],
    /// Factors of the parameters that may differ from element to element (fields x m), or empty.
    pub fields: &'a [f64],
    /// Time of the state and length of the step that begins there.
    pub time: StepTime,
}

/// Start and length of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepTime {
    /// Time at which the step begins, s.
    pub start: f64,
    /// Length of the step, s.
    pub dt: f64,
}

impl StepTime {
    /// Time at which the step ends, s.
    pub fn end(self) -> f64 {
        self.start + self.dt
    }
}

/// A call into the force model failed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{model}: {call}: {reason}")]
pub struct ForceError {
    /// The model's name and where it comes from.
    pub model: String,
    /// The function that failed.
    pub call: &'static str,
    /// What went wrong, with the model's own message.
    pub reason: String,
}

/// Elastic and viscous forces of elements, with their derivatives.
///
/// Methods are called from several threads at once, each with a range of elements and the window of nodes they touch, unless the model
/// [wants whole lists](ForceModel::wants_whole_lists). Those with a default body are called only where a request carries the flag they are named for.
pub trait ForceModel: Send + Sync {
    /// Name for messages, for example `mass-spring`.
    fn name(&self) -> &str;

    /// Name and origin for errors, for example `mass-spring (/usr/lib/libpliant_mass_spring.so)`.
    fn origin(&self) -> String {
        self.name().to_owned()
    }

    /// What the model found doubtful about its elements since [`ForceModel::forget_element_warning`], for people; `None` where nothing is.
    fn element_warning(&self) -> Option<String> {
        None
    }

    /// Forgets what was doubtful about elements, whose rest data are about to be written anew.
    fn forget_element_warning(&self) {}

    /// The last warning of the model that is not about its elements, for people; `None` where it gave none.
    fn last_warning(&self) -> Option<String> {
        None
    }

    /// Whether each call is to have all elements of its kind, and no two calls are to run at once.
    fn wants_whole_lists(&self) -> bool {
        false
    }

    /// Element kinds the model acts on, with what it computes for each.
    fn requests(&self) -> &[ElementRequest];

    /// Writes rest data of the call's range into `out` (stride x m).
    ///
    /// # Errors
    /// What the model reports, or a value that is not finite.
    fn rest(&self, call: &ElementCall<'_>, out: &mut [f64]) -> Result<(), ForceError>;

    /// As [`ForceModel::rest`], of elements with fibre `directions`, unit vectors or zero (m x 3), empty where none has fibres (`WANTS_DIRECTIONS`).
    ///
    /// # Errors
    /// As [`ForceModel::rest`].
    fn directed_rest(
        &self,
        _call: &ElementCall<'_>,
        _directions: &[[f64; 3]],
        _out: &mut [f64],
    ) -> Result<(), ForceError> {
        Err(self.not_offered("directed_rest"))
    }

    /// Adds masses, kg, to `out`, one per node of the call's window.
    ///
    /// # Errors
    /// What the model reports.
    fn mass(&self, call: &ElementCall<'_>, out: &mut [f64]) -> Result<(), ForceError>;

    /// Elastic energy of the call's range, J.
    ///
    /// # Errors
    /// What the model reports, or a value that is not finite.
    fn energy(&self, call: &ElementCall<'_>) -> Result<f64, ForceError>;

    /// Adds `-dE/dx - C v`, N, to `out`, one per node of the call's window. The velocities of the call are zero in the first iteration of a
    /// step of backward Euler, which takes `C v` from the matrix, and in a quasi-static step, which damps nothing.
    ///
    /// # Errors
    /// What the model reports.
    fn forces(&self, call: &ElementCall<'_>, out: &mut [[f64; 3]]) -> Result<(), ForceError>;

    /// Adds `stiffness` K + `damping` C to blocks of the matrix. `values` are the 3 x 3 blocks from slot `first` on; `slots` (m x pairs) are the
    /// slots of each pair of corners of all elements.
    ///
    /// # Errors
    /// What the model reports.
    fn tangent(
        &self,
        call: &ElementCall<'_>,
        tangent: TangentScale,
        slots: &[u32],
        first: usize,
        values: &mut [[f64; 9]],
    ) -> Result<(), ForceError>;

    /// Whether all stiffness is available in single precision (`HAS_SINGLE`).
    fn has_single(&self) -> bool {
        false
    }

    /// As [`ForceModel::tangent`], in single precision and without diagonal blocks (`HAS_SINGLE`).
    ///
    /// # Errors
    /// What the model reports.
    fn single_tangent(
        &self,
        _call: &ElementCall<'_>,
        _tangent: TangentScale,
        _slots: &[u32],
        _first: usize,
        _values: &mut [[f32; 9]],
    ) -> Result<(), ForceError> {
        Err(self.not_offered("single_tangent"))
    }

    /// Updates the history (stride x m) of the call's range after a step; it holds the values before the step (`HAS_HISTORY`).
    ///
    /// # Errors
    /// What the model reports.
    fn advance(&self, _call: &ElementCall<'_>, _history: &mut PlanesMut<'_>) -> Result<(), ForceError> {
        Ok(())
    }

    /// Writes 1 for each element of the call's range that is gone, else 0, from its history, rest data, measure and fields, into `out` (m)
    /// (`CAN_FAIL`).
    ///
    /// # Errors
    /// What the model reports.
    fn failed(&self, _call: &ElementCall<'_>, _out: &mut [u8]) -> Result<(), ForceError> {
        Err(self.not_offered("failed"))
    }

    /// Writes strain and its gradient of the call's range of coupled hinges into `planes` (13 x m) (`IS_COUPLED`).
    ///
    /// # Errors
    /// What the model reports.
    fn strain(&self, _call: &ElementCall<'_>, _planes: &mut PlanesMut<'_>) -> Result<(), ForceError> {
        Err(self.not_offered("strain"))
    }

    /// Writes the compliance of the call's range of coupled triangles into `planes` (6 x m) (`IS_COUPLED`).
    ///
    /// # Errors
    /// What the model reports.
    fn compliance(&self, _call: &ElementCall<'_>, _planes: &mut [f64]) -> Result<(), ForceError> {
        Err(self.not_offered("compliance"))
    }

    /// Energy of the call's triangles with unit vertex normals `normals` (n x 3), J (`WANTS_NORMALS`).
    ///
    /// # Errors
    /// What the model reports, or a value that is not finite.
    fn normals_energy(&self, _call: &ElementCall<'_>, _normals: &[[f64; 3]]) -> Result<f64, ForceError> {
        Err(self.not_offered("normals_energy"))
    }

    /// Adds to `out`, a row for each node of the call's window, the forces at fixed normals, N, and the derivatives of the energy by the normals,
    /// J (w x 6) (`WANTS_NORMALS`).
    ///
    /// # Errors
    /// What the model reports.
    fn normals_forces(
        &self,
        _call: &ElementCall<'_>,
        _normals: &[[f64; 3]],
        _out: &mut [[f64; 6]],
    ) -> Result<(), ForceError> {
        Err(self.not_offered("normals_forces"))
    }

    /// Writes the stiffness of the energy against a change of the normals across each side of the call's triangles, N m, into `planes` (3 x m)
    /// (`WANTS_NORMALS`).
    ///
    /// # Errors
    /// What the model reports.
    fn tilt(&self, _call: &ElementCall<'_>, _planes: &mut [f64]) -> Result<(), ForceError> {
        Err(self.not_offered("tilt"))
    }

    /// The error of a result of `call` that is not finite at `node`.
    fn not_finite(&self, call: &'static str, node: usize) -> ForceError {
        ForceError { model: self.origin(), call, reason: format!("the result for node {node} is not finite") }
    }

    /// The error of a function that a request promises and the model lacks.
    fn not_offered(&self, call: &'static str) -> ForceError {
        ForceError { model: self.origin(), call, reason: "not offered".into() }
    }
}
