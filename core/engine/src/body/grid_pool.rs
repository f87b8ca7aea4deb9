//! Pool of built grids, which go from session to session: a grid serves one caller at a time.

use pliant_host::Grid;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard};

/// Pool of idle grids.
#[derive(Default)]
pub struct GridPool {
    /// By key, the most recently returned last.
    idle: Mutex<Vec<(String, Grid)>>,
    /// Number of kinds of grids that are kept.
    capacity: usize,
}

impl GridPool {
    /// Keeps idle grids of up to `capacity` kinds.
    pub(crate) fn new(capacity: usize) -> Self {
        Self { idle: Mutex::default(), capacity }
    }

    /// Takes an idle grid of this key, the one returned last.
    pub(crate) fn take(&self, key: &str) -> Option<Grid> {
        let mut idle = self.lock();
        let place = idle.iter().rposition(|(of, _)| of == key)?;
        Some(idle.remove(place).1)
    }

    /// Keeps a grid; drops those of the kind that was used longest ago when there are too many kinds.
    fn put(&self, key: String, grid: Grid) {
        let mut idle = self.lock();
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

    fn lock(&self) -> MutexGuard<'_, Vec<(String, Grid)>> {
        self.idle.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// A grid that returns to its pool on drop.
pub struct PooledGrid {
    /// `None` only while it is dropped.
    grid: Option<Grid>,
    key: String,
    home: Arc<GridPool>,
}

impl PooledGrid {
    pub(crate) fn new(key: String, grid: Grid, home: &Arc<GridPool>) -> Self {
        Self { grid: Some(grid), key, home: Arc::clone(home) }
    }

    /// Its key: the model and all settings it was built with.
    pub(crate) fn key(&self) -> &str {
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
        // A grid whose plugin panicked is not reused.
        if let Some(grid) = self.grid.take().filter(|grid| self.home.capacity > 0 && !grid.is_quarantined()) {
            self.home.put(std::mem::take(&mut self.key), grid);
        }
    }
}
