//! Colours and textures of the materials of a body on the graphics card.

#![allow(unsafe_code, reason = "every call of OpenGL is unsafe; see the module `renderer`")]

use crate::materials::{MaterialLook, SurfaceMaterials};
use eframe::glow::{self, HasContext};
use image::imageops;

/// Entries in a row of the table.
pub(super) const TABLE_WIDTH: usize = 1024;
/// Numbers that [`VertexLook::material`](crate::picture::VertexLook) has before those of the file.
const FIRST_MATERIAL: usize = 2;
/// Fourth number of an entry without a colour of its own.
const NO_COLOUR: f32 = -2.0;
/// Fourth number of an entry with one colour; that of a texture is its layer.
const ONE_COLOUR: f32 = -1.0;

/// A table with an entry for each material, and the textures it refers to.
pub(super) struct MaterialTextures {
    /// Red, green, blue and kind of each material, [`TABLE_WIDTH`] in a row.
    pub(super) table: glow::Texture,
    /// Textures, one for each layer.
    pub(super) images: glow::Texture,
}

impl MaterialTextures {
    /// Uploads the materials of a body; the default has none.
    pub(super) fn new(gl: &glow::Context, materials: &SurfaceMaterials) -> Result<Self, String> {
        let entries = table(materials);
        let rows = entries.len() / TABLE_WIDTH;
        let bytes: &[u8] = bytemuck::cast_slice(&entries);
        // SAFETY: the context is current; the slices have as many bytes as the sizes say.
        unsafe {
            let table = gl.create_texture()?;
            gl.bind_texture(glow::TEXTURE_2D, Some(table));
            let (format, kind) = (glow::RGBA, glow::FLOAT);
            let data = glow::PixelUnpackData::Slice(Some(bytes));
            let (width, height) = (TABLE_WIDTH as i32, rows as i32);
            gl.tex_image_2d(glow::TEXTURE_2D, 0, glow::RGBA32F as i32, width, height, 0, format, kind, data);
            for (what, how) in [(glow::TEXTURE_MIN_FILTER, glow::NEAREST), (glow::TEXTURE_MAG_FILTER, glow::NEAREST)] {
                gl.tex_parameter_i32(glow::TEXTURE_2D, what, how as i32);
            }
            let images = gl.create_texture()?;
            let target = glow::TEXTURE_2D_ARRAY;
            gl.bind_texture(target, Some(images));
            let (width, height) = materials.images.first().map_or((1, 1), |image| image.dimensions());
            let (width, height, depth) = (width as i32, height as i32, materials.images.len().max(1) as i32);
            let (format, kind) = (glow::RGBA, glow::UNSIGNED_BYTE);
            let nothing = glow::PixelUnpackData::Slice(None);
            gl.tex_image_3d(target, 0, glow::RGBA8 as i32, width, height, depth, 0, format, kind, nothing);
            for (layer, image) in materials.images.iter().enumerate() {
                // Texture coordinates begin at the lower left corner.
                let image = imageops::flip_vertical(image);
                let data = glow::PixelUnpackData::Slice(Some(image.as_raw()));
                gl.tex_sub_image_3d(target, 0, 0, 0, layer as i32, width, height, 1, format, kind, data);
            }
            gl.generate_mipmap(target);
            for (what, how) in [
                (glow::TEXTURE_MIN_FILTER, glow::LINEAR_MIPMAP_LINEAR),
                (glow::TEXTURE_MAG_FILTER, glow::LINEAR),
                (glow::TEXTURE_WRAP_S, glow::REPEAT),
                (glow::TEXTURE_WRAP_T, glow::REPEAT),
            ] {
                gl.tex_parameter_i32(target, what, how as i32);
            }
            Ok(Self { table, images })
        }
    }

    /// Gives the memory back.
    pub(super) fn delete(&self, gl: &glow::Context) {
        // SAFETY: the context is current; nothing draws with these textures any more.
        unsafe {
            gl.delete_texture(self.table);
            gl.delete_texture(self.images);
        }
    }
}

/// The entries of the table, filled up to whole rows.
fn table(materials: &SurfaceMaterials) -> Vec<[f32; 4]> {
    let none = [0.0, 0.0, 0.0, NO_COLOUR];
    let entry = |look: &Option<MaterialLook>| match look {
        None => none,
        Some(MaterialLook::Colour([red, green, blue])) => [*red, *green, *blue, ONE_COLOUR],
        Some(MaterialLook::Texture(layer)) => [1.0, 1.0, 1.0, *layer as f32],
    };
    let mut entries = vec![none; FIRST_MATERIAL];
    entries.extend(materials.looks.iter().map(entry));
    entries.resize(entries.len().next_multiple_of(TABLE_WIDTH), none);
    entries
}
