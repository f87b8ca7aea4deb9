//! Positions lent to numpy without a copy.
//!
//! An array shows the session's own memory. Before the session writes to that memory or gives it back, it looks which arrays are still
//! held: these keep the memory, with the positions they were made with, and the session goes on with a copy. So an array never
//! shows half a step and never points to memory that is gone, and one that is dropped before the next step costs nothing.

use super::arrays::rows_of;
use numpy::{PyArray2, PyArrayMethods};
use pliant_engine::body::Body;
use pliant_solver::Vec3;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The memory of positions once the session has given it up; alive while an array shows it.
#[derive(Default)]
struct Keeper(Mutex<Option<Arc<Vec<Vec3>>>>);

/// What an array of positions holds on to.
#[pyclass(frozen, module = "pliant._native")]
struct Lease {
    _keeper: Arc<Keeper>,
}

/// Positions of a body that an array may show.
pub struct Lent {
    keeper: Weak<Keeper>,
    body: usize,
}

/// A read-only array (n x 3) of `positions`, which are those of the body `body`.
#[allow(unsafe_code, reason = "an array that shows memory it does not own")]
pub fn lend<'py>(py: Python<'py>, positions: &[Vec3], body: usize) -> PyResult<(Bound<'py, PyArray2<f64>>, Lent)> {
    let keeper = Arc::new(Keeper::default());
    let lent = Lent { keeper: Arc::downgrade(&keeper), body };
    let lease = Bound::new(py, Lease { _keeper: keeper })?;
    // SAFETY: the array holds `lease`, which holds the keeper. Its memory stays where it is and as it is while it does: before the
    // session writes to it, frees it or is dropped, `take_back` moves the vector into every keeper that is still alive.
    let array = unsafe { PyArray2::borrow_from_array(&rows_of(positions), lease.into_any()) };
    array.readwrite().make_nonwriteable();
    Ok((array, lent))
}

/// Before positions of `bodies` change or are freed: those that an array still shows become its own. The interpreter's lock is held, so
/// no array ends meanwhile.
pub fn take_back(_py: Python<'_>, lent: &mut Vec<Lent>, bodies: &mut [Body]) {
    let mut given: BTreeMap<usize, Arc<Vec<Vec3>>> = BTreeMap::new();
    for lent in lent.drain(..) {
        let Some(keeper) = lent.keeper.upgrade() else { continue };
        let memory = given.entry(lent.body).or_insert_with(|| {
            let now = &mut bodies[lent.body].skin.x;
            let copy = now.clone();
            Arc::new(std::mem::replace(now, copy))
        });
        *keeper.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(memory));
    }
}
