//! Cache of parts that sessions of one process share, so that many small runs do not each load, sort and sample the same model.
//!
//! Immutable parts are shared: a placed model, its triangle tree, its samples, its frequencies. A session that changes a part (by a cut, or when a shape
//! is kept) copies it. A grid serves one caller at a time, so grids are pooled: a session takes an idle one and returns it when it ends. The
//! least recently used parts are dropped, so memory is bounded.

use super::edit_costs::RegionSize;
use crate::body::{GridPool, Model, PooledGrid, Samples};
use pliant_host::Grid;
use pliant_mesh::geometry::TriangleTree;
use pliant_solver::Frequencies;
use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

/// A placed model with the triangle tree of its surface.
#[derive(Clone)]
pub(super) struct SharedModel {
    /// Unique number of the model in this process, part of the keys of everything derived from it.
    pub(super) number: u64,
    pub(super) model: Arc<Model>,
    pub(super) tree: Arc<TriangleTree>,
}

/// Number of the next model.
static NUMBERS: AtomicU64 = AtomicU64::new(0);

/// Frequencies and cost of a body, with a local region around one of its points.
#[derive(Clone)]
pub(super) struct Measured {
    pub(super) frequencies: Frequencies,
    /// Largest mass of a node, kg.
    pub(super) mass: f64,
    /// Number of nodes and elements of the region.
    pub(super) nodes: usize,
    pub(super) elements: usize,
    /// Time of one evaluation of the forces, s.
    pub(super) seconds: f64,
    /// Sizes of the regions that edits of the scene simulate.
    pub(super) regions: Vec<RegionSize>,
}

/// A cache shared by sessions. [`SharedParts::default`] caches nothing.
#[derive(Default)]
pub struct SharedParts {
    models: Cache<SharedModel>,
    samples: Cache<Arc<Samples>>,
    measured: Cache<Measured>,
    grids: Arc<GridPool>,
}

impl SharedParts {
    /// A cache for the parts of up to `models` models, and for as many idle grids as sessions are open at a time.
    pub fn new(models: usize) -> Self {
        Self {
            models: Cache::new(models),
            samples: Cache::new(models),
            // Small entries, one for each material of a model.
            measured: Cache::new(256 * models),
            grids: Arc::new(GridPool::new(models)),
        }
    }

    /// The model with a key; calls `make` if it is not cached or has no key.
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

    /// The samples with a key; calls `make` if they are not cached.
    pub(super) fn samples<E>(
        &self,
        key: impl FnOnce() -> String,
        make: impl FnOnce() -> Result<Samples, E>,
    ) -> Result<Arc<Samples>, E> {
        self.samples.get(|| Some(key()), || make().map(Arc::new))
    }

    /// The measurements with a key; calls `make` if they are not cached.
    pub(super) fn measured<E>(
        &self,
        key: impl FnOnce() -> String,
        measure: impl FnOnce() -> Result<Measured, E>,
    ) -> Result<Measured, E> {
        self.measured.get(|| Some(key()), measure)
    }

    /// Takes an idle grid with this key; `None` if there is none.
    pub(super) fn idle_grid(&self, key: &str) -> Option<Grid> {
        self.grids.take(key)
    }

    /// Wraps a grid that returns to the pool under this key when its session ends.
    pub(super) fn pool(&self, key: String, grid: Grid) -> PooledGrid {
        PooledGrid::new(key, grid, &self.grids)
    }
}

impl fmt::Debug for SharedParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SharedParts")
    }
}

/// A cache with least-recently-used replacement.
struct Cache<V> {
    capacity: usize,
    entries: Mutex<Entries<V>>,
}

/// The values of a cache.
struct Entries<V> {
    /// Each value by its key, with the count of uses at its last use.
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
    /// The value with a key; calls `make` if it is not cached. If two sessions make the same value concurrently, one of them is kept.
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
