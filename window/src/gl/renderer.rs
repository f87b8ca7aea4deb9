//! The back end for OpenGL 3.3.

#![allow(
    unsafe_code,
    reason = "every call of OpenGL is unsafe: a renderer lives on the thread whose context it was made with, which eframe makes current"
)]

use super::buffers::BodyBuffers;
use super::material_textures::MaterialTextures;
use super::reference_picture::ReferencePicture;
use super::{Channels, Line, PixelArea, Scene, Shading, SurfaceRenderer, Wireframe, matcap, shaders};
use crate::materials::SurfaceMaterials;
use crate::picture::Upload;
use crate::strings;
use eframe::glow::{self, HasContext};
use image::RgbaImage;
use nalgebra::{Matrix4, Vector3};
use std::sync::Arc;

/// Draws with OpenGL 3.3.
pub struct GlRenderer {
    gl: Arc<glow::Context>,
    name: String,
    surface: glow::Program,
    edge: glow::Program,
    line: glow::Program,
    background: glow::Program,
    picture: glow::Program,
    /// The reference image.
    reference: Option<ReferencePicture>,
    balls: glow::Texture,
    /// Of bodies without materials.
    plain: MaterialTextures,
    /// For drawing what has no vertices.
    empty: glow::VertexArray,
    lines: glow::VertexArray,
    line_buffer: glow::Buffer,
    bodies: Vec<BodyBuffers>,
}

/// What a driver says of itself: the renderer and the version of OpenGL.
pub fn renderer_name(gl: &glow::Context) -> String {
    // SAFETY: eframe, or the test, has made the context current on this thread.
    let [renderer, version] = unsafe { [glow::RENDERER, glow::VERSION].map(|what| gl.get_parameter_string(what)) };
    strings::renderer(&renderer, &version)
}

impl GlRenderer {
    /// Prepares programs and buffers.
    ///
    /// # Errors
    /// A context that is older than 3.3, or a program that it does not take.
    pub fn new(gl: Arc<glow::Context>) -> Result<Self, String> {
        // SAFETY: eframe, or the test, has made the context current on this thread.
        unsafe {
            let version = gl.version();
            if (version.major, version.minor) < (3, 3) && !version.is_embedded {
                let found = gl.get_parameter_string(glow::VERSION);
                return Err(strings::old_context(&found));
            }
            let name = gl.get_parameter_string(glow::RENDERER);
            let surface = program(&gl, shaders::SURFACE_VERTEX, shaders::SURFACE_FRAGMENT)?;
            let edge = program(&gl, shaders::EDGE_VERTEX, shaders::EDGE_FRAGMENT)?;
            let line = program(&gl, shaders::LINE_VERTEX, shaders::LINE_FRAGMENT)?;
            let background = program(&gl, shaders::BACKGROUND_VERTEX, shaders::BACKGROUND_FRAGMENT)?;
            let picture = program(&gl, shaders::PICTURE_VERTEX, shaders::PICTURE_FRAGMENT)?;
            let balls = ball_texture(&gl)?;
            let plain = MaterialTextures::new(&gl, &SurfaceMaterials::default())?;
            let (empty, lines) = (gl.create_vertex_array()?, gl.create_vertex_array()?);
            let line_buffer = gl.create_buffer()?;
            gl.bind_vertex_array(Some(lines));
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(line_buffer));
            gl.vertex_attrib_pointer_f32(0, 3, glow::FLOAT, false, 28, 0);
            gl.vertex_attrib_pointer_f32(1, 4, glow::FLOAT, false, 28, 12);
            gl.enable_vertex_attrib_array(0);
            gl.enable_vertex_attrib_array(1);
            gl.bind_vertex_array(None);
            Ok(Self {
                gl,
                name,
                surface,
                edge,
                line,
                background,
                picture,
                reference: None,
                balls,
                plain,
                empty,
                lines,
                line_buffer,
                bodies: Vec::new(),
            })
        }
    }

    /// Sets the matrices of a program; gives the program's locations of other uniforms.
    fn use_program(&self, program: glow::Program, scene: &Scene, to_eye: &Matrix4<f64>) {
        // SAFETY: see the module.
        unsafe {
            self.gl.use_program(Some(program));
            for (name, matrix) in [("to_eye", to_eye), ("projection", &scene.projection)] {
                let place = self.gl.get_uniform_location(program, name);
                self.gl.uniform_matrix_4_f32_slice(place.as_ref(), false, matrix.map(|c| c as f32).as_slice());
            }
        }
    }

    fn draw_background(&self, scene: &Scene) {
        // SAFETY: see the module.
        unsafe {
            let gl = &self.gl;
            gl.use_program(Some(self.background));
            for (name, [r, g, b]) in ["top", "bottom"].into_iter().zip(scene.background) {
                let place = gl.get_uniform_location(self.background, name);
                gl.uniform_3_f32(place.as_ref(), r, g, b);
            }
            gl.disable(glow::DEPTH_TEST);
            gl.bind_vertex_array(Some(self.empty));
            gl.draw_arrays(glow::TRIANGLES, 0, 3);
        }
    }

    /// Draws the reference image, without depth: nothing is ever behind it.
    fn draw_reference(&self, scene: &Scene) {
        let (Some(quad), Some(picture)) = (&scene.reference, &self.reference) else { return };
        self.use_program(self.picture, scene, &scene.view);
        // SAFETY: see the module; the program makes four vertices by itself.
        unsafe {
            let gl = &self.gl;
            let place = |name| gl.get_uniform_location(self.picture, name);
            gl.uniform_3_f32_slice(place("corners").as_ref(), quad.corners.as_flattened());
            gl.uniform_1_f32(place("opacity").as_ref(), quad.opacity);
            gl.uniform_1_i32(place("image").as_ref(), 0);
            gl.active_texture(glow::TEXTURE0);
            gl.bind_texture(glow::TEXTURE_2D, Some(picture.texture));
            gl.bind_vertex_array(Some(self.empty));
            gl.draw_arrays(glow::TRIANGLE_STRIP, 0, 4);
        }
    }

    fn draw_surfaces(&self, scene: &Scene) {
        // SAFETY: see the module; numbers of indices are those of the buffers.
        unsafe {
            let gl = &self.gl;
            gl.active_texture(glow::TEXTURE0);
            gl.bind_texture(glow::TEXTURE_2D, Some(self.balls));
            for (body, to_eye) in self.bodies.iter().zip(body_views(scene)) {
                self.use_program(self.surface, scene, &to_eye);
                let place = |name| gl.get_uniform_location(self.surface, name);
                gl.uniform_1_i32(place("shading").as_ref(), shading_number(scene.shading));
                gl.uniform_1_i32(place("perspective").as_ref(), i32::from(scene.projection[(3, 2)] != 0.0));
                gl.uniform_1_f32(place("opacity").as_ref(), scene.opacity);
                gl.uniform_1_f32(place("full_displacement").as_ref(), scene.full_displacement.max(1e-9));
                gl.uniform_1_i32(place("mark_backs").as_ref(), i32::from(scene.mark_backs));
                gl.uniform_1_i32(place("balls").as_ref(), 0);
                gl.uniform_1_i32(place("file_colours").as_ref(), i32::from(scene.file_colours));
                gl.uniform_1_i32(place("materials").as_ref(), 1);
                gl.uniform_1_i32(place("images").as_ref(), 2);
                let materials = body.materials.as_ref().unwrap_or(&self.plain);
                gl.active_texture(glow::TEXTURE1);
                gl.bind_texture(glow::TEXTURE_2D, Some(materials.table));
                gl.active_texture(glow::TEXTURE2);
                gl.bind_texture(glow::TEXTURE_2D_ARRAY, Some(materials.images));
                gl.active_texture(glow::TEXTURE0);
                gl.bind_vertex_array(Some(body.surface));
                gl.draw_elements(glow::TRIANGLES, body.triangle_indices, glow::UNSIGNED_INT, 0);
            }
        }
    }

    fn draw_edges(&self, scene: &Scene) {
        let tint = if scene.wireframe == Wireframe::Only { [0.82, 0.84, 0.88, 0.9] } else { [0.05, 0.06, 0.08, 0.55] };
        // SAFETY: see the module; numbers of indices are those of the buffers.
        unsafe {
            let gl = &self.gl;
            for (body, to_eye) in self.bodies.iter().zip(body_views(scene)) {
                self.use_program(self.edge, scene, &to_eye);
                let place = gl.get_uniform_location(self.edge, "tint");
                let [r, g, b, a] = tint;
                gl.uniform_4_f32(place.as_ref(), r, g, b, a);
                gl.bind_vertex_array(Some(body.lines));
                gl.draw_elements(glow::LINES, body.edge_indices, glow::UNSIGNED_INT, 0);
            }
        }
    }

    fn draw_lines(&self, scene: &Scene) {
        let end = |line: &Line, end: usize| {
            let ([x, y, z], [r, g, b, a]) = (line.ends[end], line.colour);
            [x, y, z, r, g, b, a]
        };
        let data: Vec<[f32; 7]> = scene.lines.iter().flat_map(|line| [end(line, 0), end(line, 1)]).collect();
        if data.is_empty() {
            return;
        }
        // SAFETY: see the module; the buffer holds as many vertices as are drawn.
        unsafe {
            let gl = &self.gl;
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(self.line_buffer));
            gl.buffer_data_u8_slice(glow::ARRAY_BUFFER, bytemuck::cast_slice(&data), glow::STREAM_DRAW);
            self.use_program(self.line, scene, &scene.view);
            gl.bind_vertex_array(Some(self.lines));
            gl.draw_arrays(glow::LINES, 0, data.len() as i32);
        }
    }
}

/// From the axes of each body to those of the eye.
fn body_views(scene: &Scene) -> impl Iterator<Item = Matrix4<f64>> + '_ {
    scene.origins.iter().map(|origin| scene.view * Matrix4::new_translation(&Vector3::from(*origin)))
}

fn shading_number(shading: Shading) -> i32 {
    match shading {
        Shading::Studio => 0,
        Shading::Clay => 1,
        Shading::Metal => 2,
        Shading::Wax => 3,
        Shading::Facets => 4,
        Shading::Displacement => 5,
    }
}

impl SurfaceRenderer for GlRenderer {
    fn upload(&mut self, upload: &Upload) {
        while self.bodies.len() <= upload.body {
            self.bodies.push(BodyBuffers::new(&self.gl));
        }
        self.bodies[upload.body].upload(&self.gl, upload);
    }

    fn upload_reference(&mut self, image: &RgbaImage) -> Result<(), String> {
        if let Some(old) = self.reference.take() {
            old.delete(&self.gl);
        }
        self.reference = Some(ReferencePicture::new(&self.gl, image)?);
        Ok(())
    }

    fn clear(&mut self) {
        for body in self.bodies.drain(..) {
            body.delete(&self.gl);
        }
    }

    fn draw(&mut self, scene: &Scene, area: PixelArea) {
        // SAFETY: see the module.
        unsafe {
            let gl = &self.gl;
            gl.viewport(area.left, area.bottom, area.width, area.height);
            gl.enable(glow::SCISSOR_TEST);
            gl.scissor(area.left, area.bottom, area.width, area.height);
            gl.disable(glow::CULL_FACE);
            let (red, others) = (scene.channels != Channels::GreenAndBlue, scene.channels != Channels::Red);
            gl.color_mask(red, others, others, true);
            gl.disable(glow::BLEND);
            gl.depth_mask(true);
            gl.clear_depth_f32(1.0);
            gl.clear(glow::DEPTH_BUFFER_BIT);
            self.draw_background(scene);
            gl.enable(glow::BLEND);
            gl.blend_func(glow::ONE, glow::ONE_MINUS_SRC_ALPHA);
            self.draw_reference(scene);
            gl.enable(glow::DEPTH_TEST);
            gl.depth_func(glow::LEQUAL);
            self.draw_lines(scene);
            if scene.wireframe != Wireframe::Only {
                // What is behind a surface that is seen through shall be seen.
                gl.depth_mask(scene.opacity >= 1.0);
                self.draw_surfaces(scene);
                gl.depth_mask(true);
            }
            if scene.wireframe != Wireframe::Off {
                self.draw_edges(scene);
            }
            gl.disable(glow::DEPTH_TEST);
            gl.color_mask(true, true, true, true);
            gl.bind_vertex_array(None);
            gl.use_program(None);
        }
    }

    fn read_back(&self, area: PixelArea) -> Vec<u8> {
        let (width, height) = (area.width.max(0) as usize, area.height.max(0) as usize);
        let mut pixels = vec![0; width * height * 4];
        let into = glow::PixelPackData::Slice(Some(&mut pixels));
        // SAFETY: see the module; the slice has four bytes for each pixel.
        unsafe {
            self.gl.read_pixels(area.left, area.bottom, area.width, area.height, glow::RGBA, glow::UNSIGNED_BYTE, into);
        }
        pixels.chunks_exact((width * 4).max(1)).rev().flatten().copied().collect()
    }

    fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for GlRenderer {
    fn drop(&mut self) {
        self.clear();
        // SAFETY: see the module; nothing draws any more.
        unsafe {
            self.reference.take().into_iter().for_each(|picture| picture.delete(&self.gl));
            for program in [self.surface, self.edge, self.line, self.background, self.picture] {
                self.gl.delete_program(program);
            }
            self.gl.delete_texture(self.balls);
            self.plain.delete(&self.gl);
            self.gl.delete_vertex_array(self.empty);
            self.gl.delete_vertex_array(self.lines);
            self.gl.delete_buffer(self.line_buffer);
        }
    }
}

/// Compiles and links a program.
unsafe fn program(gl: &glow::Context, vertex: &str, fragment: &str) -> Result<glow::Program, String> {
    // SAFETY: the caller has made the context current.
    unsafe {
        let program = gl.create_program()?;
        for (kind, text) in [(glow::VERTEX_SHADER, vertex), (glow::FRAGMENT_SHADER, fragment)] {
            let shader = gl.create_shader(kind)?;
            gl.shader_source(shader, text);
            gl.compile_shader(shader);
            if !gl.get_shader_compile_status(shader) {
                return Err(strings::shader_problem(&gl.get_shader_info_log(shader)));
            }
            gl.attach_shader(program, shader);
            gl.delete_shader(shader);
        }
        gl.link_program(program);
        if gl.get_program_link_status(program) {
            Ok(program)
        } else {
            Err(strings::link_problem(&gl.get_program_info_log(program)))
        }
    }
}

/// The pictures of balls as a texture.
unsafe fn ball_texture(gl: &glow::Context) -> Result<glow::Texture, String> {
    let (width, height) = (matcap::SIZE as i32, 3 * matcap::SIZE as i32);
    let pixels = matcap::pictures();
    // SAFETY: the caller has made the context current; the slice has four bytes for each pixel.
    unsafe {
        let texture = gl.create_texture()?;
        gl.bind_texture(glow::TEXTURE_2D, Some(texture));
        let data = glow::PixelUnpackData::Slice(Some(&pixels));
        let (format, kind) = (glow::RGBA, glow::UNSIGNED_BYTE);
        gl.tex_image_2d(glow::TEXTURE_2D, 0, glow::RGBA8 as i32, width, height, 0, format, kind, data);
        for (what, how) in [
            (glow::TEXTURE_MIN_FILTER, glow::LINEAR),
            (glow::TEXTURE_MAG_FILTER, glow::LINEAR),
            (glow::TEXTURE_WRAP_S, glow::CLAMP_TO_EDGE),
            (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
        ] {
            gl.tex_parameter_i32(glow::TEXTURE_2D, what, how as i32);
        }
        gl.bind_texture(glow::TEXTURE_2D, None);
        Ok(texture)
    }
}
