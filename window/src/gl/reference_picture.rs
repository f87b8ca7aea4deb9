//! The reference image on the graphics card: one texture on one rectangle.

#![allow(unsafe_code, reason = "every call of OpenGL is unsafe; see the module `renderer`")]

use eframe::glow::{self, HasContext};
use image::{RgbaImage, imageops};

/// The texture of a reference image.
pub(super) struct ReferencePicture {
    pub(super) texture: glow::Texture,
}

impl ReferencePicture {
    /// Uploads an image.
    pub(super) fn new(gl: &glow::Context, image: &RgbaImage) -> Result<Self, String> {
        // Texture coordinates begin at the lower left corner.
        let image = imageops::flip_vertical(image);
        let (width, height) = (image.width() as i32, image.height() as i32);
        let data = glow::PixelUnpackData::Slice(Some(image.as_raw()));
        // SAFETY: the context is current; the slice has as many bytes as the sizes say.
        unsafe {
            let texture = gl.create_texture()?;
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            let (target, kind) = (glow::TEXTURE_2D, glow::UNSIGNED_BYTE);
            gl.tex_image_2d(target, 0, glow::RGBA8 as i32, width, height, 0, glow::RGBA, kind, data);
            gl.generate_mipmap(target);
            for (what, how) in [
                (glow::TEXTURE_MIN_FILTER, glow::LINEAR_MIPMAP_LINEAR),
                (glow::TEXTURE_MAG_FILTER, glow::LINEAR),
                (glow::TEXTURE_WRAP_S, glow::CLAMP_TO_EDGE),
                (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
            ] {
                gl.tex_parameter_i32(target, what, how as i32);
            }
            Ok(Self { texture })
        }
    }

    /// Gives the memory back.
    pub(super) fn delete(&self, gl: &glow::Context) {
        // SAFETY: the context is current; nothing draws with the texture any more.
        unsafe { gl.delete_texture(self.texture) }
    }
}
