//! What sessions of one process have in common, so that many small runs do not each read, sort and sample the same model.
//!
//! Parts that never change are shared: a placed model, the tree over it, its samples, its frequencies. A part that changes (under a blade, or
//! when a shape is kept) is copied by the session that changes it. A grid answers one caller at a time, so it goes from session to session:
//! a session takes one that no other has, and gives it back when it ends. The least recently used parts are dropped, so memory stays flat
//! however many models there are.

use crate::body::{Model, Samples};
use pliant_host::Grid;
use pliant_mesh::geometry::TriangleTree;
use pliant_solver::Frequencies;
use std::collections::HashMap;
use std::fmt;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

/// A placed model and the tree over its surface as it was handed in.
#[derive(Clone)]
pub(super) struct SharedModel {
    /// Unlike that of any other model this program has made: a part of the keys of what hangs on the model.
    pub(super) number: u64,
    pub(super) model: Arc<Model>,
    pub(super) tree: Arc<TriangleTree>,
}

/// Number of the next model.
static NUMBERS: AtomicU64 = AtomicU64::new(0);

/// What was measured of a body whose region was around one of its points.
#[derive(Clone, Copy)]
pub(super) struct Measured {
    pub(super) frequencies: Frequencies,
    /// kg, largest mass of a node
    pub(super) mass: f64,
    /// Nodes and elements of the region.
    pub(super) nodes: usize,
    pub(super) elements: usize,
    /// s, a pass over the forces
    pub(super) seconds: f64,
}

/// What sessions have in common. [`SharedParts::default`] keeps nothing.
#[derive(Default)]
pub struct SharedParts {
    models: Cache<SharedModel>,
    samples: Cache<Arc<Samples>>,
    measured: Cache<Measured>,
    grids: Arc<GridPool>,
}

impl SharedParts {
    /// Keeps the parts of up to `models` models. One grid more is kept for each session that is open at a time.
    pub fn new(models: usize) -> Self {
        Self {
            models: Cache::new(models),
            samples: Cache::new(models),
            // A few numbers each; one for each material a model is given.
            measured: Cache::new(256 * models),
            grids: Arc::new(GridPool { idle: Mutex::default(), capacity: models }),
        }
    }

    /// The model under a key, made if it is not there; without a key it is made.
    pub(super) fn model<E>(
        &self,
        key: impl FnOnce() -> Option<String>,
        make: impl FnOnce() -> Result<Model, E>,
    ) -> Result<SharedModel, E> {
        self.models.get(key, || {
            let model = Arc::new(make()?);
            let tree = Arc::new(model.tree());
            let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
            Ok(SharedModel { number, model, tree })
        })
    }

    /// The samples under a key, made if they are not there.
    pub(super) fn samples<E>(
        &self,
        key: impl FnOnce() -> String,
        make: impl FnOnce() -> Result<Samples, E>,
    ) -> Result<Arc<Samples>, E> {
        self.samples.get(|| Some(key()), || make().map(Arc::new))
    }

    /// What was measured under a key, or is now.
    pub(super) fn measured<E>(
        &self,
        key: impl FnOnce() -> String,
        measure: impl FnOnce() -> Result<Measured, E>,
    ) -> Result<Measured, E> {
        self.measured.get(|| Some(key()), measure)
    }

    /// A built grid of this key that no session has, if there is one.
    pub(super) fn idle_grid(&self, key: &str) -> Option<Grid> {
        self.grids.take(key)
    }

    /// A grid that comes back under this key when its session ends.
    pub(super) fn pool(&self, key: String, grid: Grid) -> PooledGrid {
        PooledGrid { grid: Some(grid), key, home: Arc::clone(&self.grids) }
    }
}

impl fmt::Debug for SharedParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SharedParts")
    }
}

/// Values by key, of which the most recently used are kept.
struct Cache<V> {
    capacity: usize,
    entries: Mutex<Entries<V>>,
}

/// The values of a cache.
struct Entries<V> {
    /// By key: when a value was last used, and the value.
    values: HashMap<String, (u64, V)>,
    /// Number of uses so far.
    clock: u64,
}

impl<V> Default for Cache<V> {
    fn default() -> Self {
        Self::new(0)
    }
}

impl<V> Cache<V> {
    fn new(capacity: usize) -> Self {
        Self { capacity, entries: Mutex::new(Entries { values: HashMap::new(), clock: 0 }) }
    }
}

impl<V: Clone> Cache<V> {
    /// The value under a key, made if it is not there. Two sessions may make the same value at once; one of them is kept.
    fn get<E>(&self, key: impl FnOnce() -> Option<String>, make: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        if self.capacity == 0 {
            return make();
        }
        let Some(key) = key() else { return make() };
        if let Some(found) = self.find(&key) {
            return Ok(found);
        }
        let made = make()?;
        let mut entries = lock(&self.entries);
        let Entries { values, clock } = &mut *entries;
        *clock += 1;
        if values.len() >= self.capacity
            && let Some(oldest) = values.iter().min_by_key(|(_, (used, _))| *used).map(|(key, _)| key.clone())
        {
            values.remove(&oldest);
        }
        values.insert(key, (*clock, made.clone()));
        Ok(made)
    }

    fn find(&self, key: &str) -> Option<V> {
        let mut entries = lock(&self.entries);
        let Entries { values, clock } = &mut *entries;
        *clock += 1;
        let (used, value) = values.get_mut(key)?;
        *used = *clock;
        Some(value.clone())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Built grids that no session has.
#[derive(Default)]
struct GridPool {
    /// By key, the most recently returned last.
    idle: Mutex<Vec<(String, Grid)>>,
    /// Number of kinds of grids that are kept.
    capacity: usize,
}

impl GridPool {
    fn take(&self, key: &str) -> Option<Grid> {
        let mut idle = lock(&self.idle);
        let place = idle.iter().rposition(|(of, _)| of == key)?;
        Some(idle.remove(place).1)
    }

    fn put(&self, key: String, grid: Grid) {
        let mut idle = lock(&self.idle);
        idle.push((key, grid));
        let mut kinds: Vec<&str> = Vec::new();
        for (key, _) in idle.iter().rev() {
            if !kinds.contains(&key.as_str()) {
                kinds.push(key);
            }
        }
        if let Some(oldest) = kinds.get(self.capacity).map(|key| (*key).to_owned()) {
            idle.retain(|(key, _)| *key != oldest);
        }
    }
}

/// A built grid that is given back when its session ends.
pub struct PooledGrid {
    /// `None` only while it is dropped.
    grid: Option<Grid>,
    key: String,
    home: Arc<GridPool>,
}

impl PooledGrid {
    /// What it is known by: the model and everything it was built with.
    pub(super) fn key(&self) -> &str {
        &self.key
    }
}

impl Deref for PooledGrid {
    type Target = Grid;

    fn deref(&self) -> &Grid {
        self.grid.as_ref().expect("there until it is dropped")
    }
}

impl Drop for PooledGrid {
    fn drop(&mut self) {
        // One whose plugin panicked is not used again.
        if let Some(grid) = self.grid.take().filter(|grid| self.home.capacity > 0 && !grid.is_quarantined()) {
            self.home.put(std::mem::take(&mut self.key), grid);
        }
    }
}
