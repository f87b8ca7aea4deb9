//! Buffers of one body on the graphics card.

#![allow(unsafe_code, reason = "every call of OpenGL is unsafe; see the module `renderer`")]

use super::material_textures::MaterialTextures;
use crate::picture::{Patch, Upload, VertexLook, VertexPlace};
use bytemuck::Pod;
use eframe::glow::{self, HasContext};

/// A buffer with room to grow.
struct Growing {
    buffer: glow::Buffer,
    target: u32,
    /// Bytes there is room for.
    capacity: usize,
}

/// The buffers of a body.
pub(super) struct BodyBuffers {
    pub(super) surface: glow::VertexArray,
    pub(super) lines: glow::VertexArray,
    places: Growing,
    looks: Growing,
    corners: Growing,
    edges: Growing,
    /// Indices to draw: three of each triangle, two of each edge.
    pub(super) triangle_indices: i32,
    pub(super) edge_indices: i32,
    /// Colours and textures; `None` until they are read.
    pub(super) materials: Option<MaterialTextures>,
}

/// Room beyond what is needed, so that a cut does not ask for new memory with every advance.
const ROOM: f64 = 1.25;

impl Growing {
    /// Puts patches into a buffer of `count` items; one that is too small is made anew with what it had.
    fn put<T: Pod>(&mut self, gl: &glow::Context, count: usize, patches: &[Patch<T>]) {
        let needed = count * size_of::<T>();
        // SAFETY: the context is current; sizes are those of the slices.
        unsafe {
            if needed > self.capacity {
                let capacity = (needed as f64 * ROOM) as usize;
                let larger = gl.create_buffer().expect("a buffer");
                gl.bind_buffer(glow::COPY_WRITE_BUFFER, Some(larger));
                gl.buffer_data_size(glow::COPY_WRITE_BUFFER, capacity as i32, glow::DYNAMIC_DRAW);
                gl.bind_buffer(glow::COPY_READ_BUFFER, Some(self.buffer));
                if self.capacity > 0 {
                    let length = self.capacity as i32;
                    gl.copy_buffer_sub_data(glow::COPY_READ_BUFFER, glow::COPY_WRITE_BUFFER, 0, 0, length);
                }
                gl.delete_buffer(self.buffer);
                (self.buffer, self.capacity) = (larger, capacity);
            }
            // An index buffer is part of the vertex array's state, so data go through a target that is not.
            gl.bind_buffer(glow::COPY_WRITE_BUFFER, Some(self.buffer));
            for patch in patches {
                let offset = (patch.first * size_of::<T>()) as i32;
                gl.buffer_sub_data_u8_slice(glow::COPY_WRITE_BUFFER, offset, bytemuck::cast_slice(&patch.items));
            }
        }
    }
}

impl BodyBuffers {
    pub(super) fn new(gl: &glow::Context) -> Self {
        let growing = |target| Growing {
            // SAFETY: the context is current.
            buffer: unsafe { gl.create_buffer() }.expect("a buffer"),
            target,
            capacity: 0,
        };
        // SAFETY: the context is current.
        let array = || unsafe { gl.create_vertex_array() }.expect("a vertex array");
        Self {
            surface: array(),
            lines: array(),
            places: growing(glow::ARRAY_BUFFER),
            looks: growing(glow::ARRAY_BUFFER),
            corners: growing(glow::ELEMENT_ARRAY_BUFFER),
            edges: growing(glow::ELEMENT_ARRAY_BUFFER),
            triangle_indices: 0,
            edge_indices: 0,
            materials: None,
        }
    }

    /// Takes over what has changed.
    pub(super) fn upload(&mut self, gl: &glow::Context, upload: &Upload) {
        self.places.put(gl, upload.vertices, &upload.places);
        self.looks.put(gl, upload.vertices, &upload.looks);
        self.corners.put(gl, upload.triangles, &upload.corners);
        self.triangle_indices = 3 * upload.triangles as i32;
        if let Some(edges) = &upload.edges {
            self.edges.put(gl, edges.len(), &[Patch { first: 0, items: edges.clone() }]);
            self.edge_indices = 2 * edges.len() as i32;
        }
        if let Some(materials) = &upload.materials {
            if let Some(old) = self.materials.take() {
                old.delete(gl);
            }
            // Where the card takes no textures the surface is plain.
            self.materials = MaterialTextures::new(gl, materials).ok();
        }
        self.describe(gl);
    }

    /// Tells the vertex arrays where their data are.
    fn describe(&self, gl: &glow::Context) {
        let place = size_of::<VertexPlace>() as i32;
        let look = size_of::<VertexLook>() as i32;
        // SAFETY: the context is current; offsets and types are those of the structures.
        unsafe {
            gl.bind_vertex_array(Some(self.surface));
            gl.bind_buffer(self.places.target, Some(self.places.buffer));
            gl.vertex_attrib_pointer_f32(0, 3, glow::FLOAT, false, place, 0);
            gl.vertex_attrib_pointer_f32(1, 1, glow::FLOAT, false, place, 12);
            gl.vertex_attrib_pointer_f32(2, 4, glow::SHORT, true, place, 16);
            gl.vertex_attrib_pointer_f32(5, 1, glow::FLOAT, false, place, 24);
            gl.bind_buffer(self.looks.target, Some(self.looks.buffer));
            gl.vertex_attrib_pointer_f32(3, 2, glow::FLOAT, false, look, 0);
            gl.vertex_attrib_pointer_i32(4, 1, glow::UNSIGNED_INT, look, 8);
            (0..6).for_each(|attribute| gl.enable_vertex_attrib_array(attribute));
            gl.bind_buffer(self.corners.target, Some(self.corners.buffer));
            gl.bind_vertex_array(Some(self.lines));
            gl.bind_buffer(self.places.target, Some(self.places.buffer));
            gl.vertex_attrib_pointer_f32(0, 3, glow::FLOAT, false, place, 0);
            gl.enable_vertex_attrib_array(0);
            gl.bind_buffer(self.edges.target, Some(self.edges.buffer));
            gl.bind_vertex_array(None);
            gl.bind_buffer(glow::ARRAY_BUFFER, None);
        }
    }

    /// Gives the memory back.
    pub(super) fn delete(&self, gl: &glow::Context) {
        // SAFETY: the context is current; nothing draws from these buffers any more.
        unsafe {
            for growing in [&self.places, &self.looks, &self.corners, &self.edges] {
                gl.delete_buffer(growing.buffer);
            }
            gl.delete_vertex_array(self.surface);
            gl.delete_vertex_array(self.lines);
        }
        if let Some(materials) = &self.materials {
            materials.delete(gl);
        }
    }
}
