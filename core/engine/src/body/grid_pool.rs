//! Pool of built grids, which sessions use one after the other: a grid has one user at a time.

use pliant_host::Grid;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard};

/// Pool of idle grids.
#[derive(Default)]
pub struct GridPool {
    /// Idle grids with their keys, the most recently returned last.
    idle: Mutex<Vec<(String, Grid)>>,
    /// Number of different keys of which grids are kept.
    capacity: usize,
}

impl GridPool {
    /// A pool that keeps idle grids of up to `capacity` different keys.
    pub(crate) fn new(capacity: usize) -> Self {
        Self { idle: Mutex::default(), capacity }
    }

    /// Takes an idle grid with this key out of the pool: the one returned last.
    pub(crate) fn take(&self, key: &str) -> Option<Grid> {
        let mut idle = self.lock();
        let index = idle.iter().rposition(|(other, _)| other == key)?;
        Some(idle.remove(index).1)
    }

    /// Returns a grid to the pool. With more than `capacity` keys, grids of the least recently used key are dropped.
    fn put(&self, key: String, grid: Grid) {
        let mut idle = self.lock();
        idle.push((key, grid));
        let mut keys: Vec<&str> = Vec::new();
        for (key, _) in idle.iter().rev() {
            if !keys.contains(&key.as_str()) {
                keys.push(key);
            }
        }
        if let Some(oldest) = keys.get(self.capacity).map(|key| (*key).to_owned()) {
            idle.retain(|(key, _)| *key != oldest);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<(String, Grid)>> {
        self.idle.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// A grid that returns to its pool on drop.
pub struct PooledGrid {
    /// `Some` until the drop.
    grid: Option<Grid>,
    key: String,
    pool: Arc<GridPool>,
}

impl PooledGrid {
    /// A grid that returns to `pool`; `key` names the model and all settings it was built with.
    pub(crate) fn new(key: String, grid: Grid, pool: &Arc<GridPool>) -> Self {
        Self { grid: Some(grid), key, pool: Arc::clone(pool) }
    }
}

impl Deref for PooledGrid {
    type Target = Grid;

    fn deref(&self) -> &Grid {
        self.grid.as_ref().expect("a grid until the drop")
    }
}

impl Drop for PooledGrid {
    fn drop(&mut self) {
        // A grid whose plugin panicked is not reused.
        if let Some(grid) = self.grid.take().filter(|grid| self.pool.capacity > 0 && !grid.is_quarantined()) {
            self.pool.put(std::mem::take(&mut self.key), grid);
        }
    }
}
