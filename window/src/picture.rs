//! The surfaces of a session as bytes for a graphics card: of each frame only what has changed.

use crate::materials::SurfaceMaterials;
use bytemuck::{Pod, Zeroable};
use pliant_editor::surface::{SurfaceChanges, ViewSurface};
use pliant_engine::body::{ABSENT, CAP, PINNED_TINT};
use std::ops::Range;
use std::sync::Arc;

/// What moves of a drawn vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VertexPlace {
    /// m, relative to the origin of the body
    pub position: [f32; 3],
    /// m, distance from its place at rest
    pub displacement: f32,
    /// Unit normal in units of 1/32767; the fourth is 32767 where the vertex is pinned.
    pub normal: [i16; 4],
    /// Decimal logarithm of the painted factor.
    pub painted: f32,
}

/// What stays of a drawn vertex until a cut.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VertexLook {
    /// Texture coordinates u and v, 0 to 1 over the image.
    pub texture: [f32; 2],
    /// One of [`PLAIN`], [`CUT`], or 2 + the index of a material.
    pub material: u32,
}

/// Material of a triangle that has none.
pub const PLAIN: u32 = 0;
/// Material of a face that a cut has made.
pub const CUT: u32 = 1;

/// Items to put at a place of a buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch<T> {
    /// Index of the first item that is replaced.
    pub first: usize,
    /// The items from there on, in order.
    pub items: Vec<T>,
}

/// What has changed of a body since the last upload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Upload {
    /// Index of the body.
    pub body: usize,
    /// Vertices there are now.
    pub vertices: usize,
    /// Triangles there are now.
    pub triangles: usize,
    /// Changed positions and normals, by ranges of vertices.
    pub places: Vec<Patch<VertexPlace>>,
    /// Changed colours and values, by ranges of vertices.
    pub looks: Vec<Patch<VertexLook>>,
    /// Corners of triangles.
    pub corners: Vec<Patch<[u32; 3]>>,
    /// All edges to draw (e x 2), where they have changed.
    pub edges: Option<Vec<[u32; 2]>>,
    /// Materials, where they have just been read.
    pub materials: Option<Arc<SurfaceMaterials>>,
}

impl Upload {
    /// Everything of a surface.
    pub fn whole(body: usize, surface: &ViewSurface) -> Self {
        let (vertices, triangles) = (surface.drawn().len(), surface.corners().len());
        let mut upload = Self { body, vertices, triangles, ..Self::default() };
        upload.places.push(places(surface, 0..vertices));
        upload.looks.push(looks(surface, 0..vertices));
        upload.corners.push(corners(surface, 0..triangles));
        upload
    }

    /// What an update of a surface has changed.
    pub fn changes(body: usize, surface: &ViewSurface, changes: &SurfaceChanges) -> Self {
        Self {
            body,
            vertices: surface.drawn().len(),
            triangles: surface.corners().len(),
            places: changes.vertices.iter().map(|range| places(surface, range.clone())).collect(),
            looks: changes.looks.iter().map(|range| looks(surface, range.clone())).collect(),
            corners: changes.triangles.iter().map(|range| corners(surface, range.clone())).collect(),
            ..Self::default()
        }
    }

    /// Bytes that go to the graphics card.
    pub fn bytes(&self) -> usize {
        let of = |count: usize, size: usize| count * size;
        let places: usize = self.places.iter().map(|p| of(p.items.len(), size_of::<VertexPlace>())).sum();
        let looks: usize = self.looks.iter().map(|p| of(p.items.len(), size_of::<VertexLook>())).sum();
        let corners: usize = self.corners.iter().map(|p| of(p.items.len(), size_of::<[u32; 3]>())).sum();
        places + looks + corners + self.edges.as_ref().map_or(0, |edges| of(edges.len(), size_of::<[u32; 2]>()))
    }
}

fn places(surface: &ViewSurface, range: Range<usize>) -> Patch<VertexPlace> {
    let place = |drawn: usize| {
        let [x, y, z] = surface.normals()[drawn].map(|c| (c * 32767.0) as i16);
        let (position, displacement) = (surface.position(drawn), surface.displacement(drawn));
        let tint = surface.tint(drawn);
        let (pinned, painted) = if tint == PINNED_TINT { (i16::MAX, 0.0) } else { (0, tint) };
        VertexPlace { position, displacement, normal: [x, y, z, pinned], painted }
    };
    Patch { first: range.start, items: range.map(place).collect() }
}

fn looks(surface: &ViewSurface, range: Range<usize>) -> Patch<VertexLook> {
    let look = |drawn: usize| {
        let vertex = surface.drawn()[drawn];
        let material = match vertex.material {
            ABSENT => PLAIN,
            CAP => CUT,
            index => index + 2,
        };
        VertexLook { texture: vertex.texture, material }
    };
    Patch { first: range.start, items: range.map(look).collect() }
}

fn corners(surface: &ViewSurface, range: Range<usize>) -> Patch<[u32; 3]> {
    Patch { first: range.start, items: surface.corners()[range].to_vec() }
}
