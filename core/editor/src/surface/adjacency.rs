//! Triangles around each vertex: one packed list, with separate lists for vertices that a cut has changed.

use pliant_engine::body::TriangleLook;
use std::collections::HashMap;

/// Triangles around vertices.
pub(super) struct Adjacency {
    /// Triangles around vertex v: `list[start[v]..start[v + 1]]`.
    start: Vec<u32>,
    list: Vec<u32>,
    /// Replacement lists of vertices whose triangles have changed.
    changed: HashMap<u32, Vec<u32>>,
}

impl Adjacency {
    /// The adjacency of `count` vertices.
    pub(super) fn new(count: usize, triangles: &[Option<TriangleLook>]) -> Self {
        let mut start = vec![0_u32; count + 1];
        for vertex in triangles.iter().flatten().flat_map(|look| look.corners) {
            start[vertex as usize + 1] += 1;
        }
        for v in 0..count {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut list = vec![0; start[count] as usize];
        for (triangle, look) in triangles.iter().enumerate() {
            for vertex in look.iter().flat_map(|look| look.corners) {
                let at = &mut next[vertex as usize];
                list[*at as usize] = triangle as u32;
                *at += 1;
            }
        }
        Self { start, list, changed: HashMap::new() }
    }

    /// Triangles around a vertex, ascending; empty for an unknown vertex.
    pub(super) fn of(&self, vertex: u32) -> &[u32] {
        if !self.changed.is_empty()
            && let Some(list) = self.changed.get(&vertex)
        {
            return list;
        }
        match (self.start.get(vertex as usize), self.start.get(vertex as usize + 1)) {
            (Some(from), Some(to)) => &self.list[*from as usize..*to as usize],
            _ => &[],
        }
    }

    fn of_mut(&mut self, vertex: u32) -> &mut Vec<u32> {
        if !self.changed.contains_key(&vertex) {
            let own = self.of(vertex).to_vec();
            self.changed.insert(vertex, own);
        }
        self.changed.entry(vertex).or_default()
    }

    /// Adds a triangle to a vertex.
    pub(super) fn insert(&mut self, vertex: u32, triangle: u32) {
        let list = self.of_mut(vertex);
        if let Err(place) = list.binary_search(&triangle) {
            list.insert(place, triangle);
        }
    }

    /// Removes a triangle from a vertex.
    pub(super) fn remove(&mut self, vertex: u32, triangle: u32) {
        self.of_mut(vertex).retain(|other| *other != triangle);
    }
}
