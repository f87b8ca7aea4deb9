//! Drawing the model. A back end is one file: it takes uploads, draws views, and reads pictures back.

mod buffers;
mod matcap;
mod material_textures;
mod reference_picture;
mod renderer;
mod shaders;

pub use renderer::{GlRenderer, renderer_name};

use crate::picture::Upload;
use crate::reference::ReferenceQuad;
use image::RgbaImage;
use nalgebra::Matrix4;

/// How surfaces are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// Three lights that stand with the viewer.
    Studio,
    /// A picture of a ball of the material: clay.
    Clay,
    /// A picture of a ball of the material: dark metal with a bright rim, which shows dents.
    Metal,
    /// A picture of a ball of the material: wax.
    Wax,
    /// Each triangle has one tone.
    Facets,
    /// Colours tell how far a point is from its place at rest.
    Displacement,
}

impl Shading {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Studio, Self::Clay, Self::Metal, Self::Wax, Self::Facets, Self::Displacement];
}

/// Edges of the model's faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wireframe {
    /// None.
    Off,
    /// Over the surface.
    Over,
    /// Alone.
    Only,
}

/// How the pictures of two eyes are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stereo {
    /// One picture for both eyes.
    Off,
    /// Red for the left eye, green and blue for the right one, through glasses of these colours.
    Anaglyph,
    /// The left eye's picture beside the right one's, each half as wide, as screens and headsets for such pictures take them.
    SideBySide,
}

impl Stereo {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::Anaglyph, Self::SideBySide];
}

/// Channels of the picture that are drawn: red, green, blue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// All three channels.
    #[default]
    All,
    /// Only the red channel, for the left eye of red-cyan glasses.
    Red,
    /// The green and blue channels, for the right eye.
    GreenAndBlue,
}

/// A view of the bodies: camera, shading, background and lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Transform from scene axes (m) to eye axes.
    pub view: Matrix4<f64>,
    /// Transform from eye axes to clip space.
    pub projection: Matrix4<f64>,
    /// Origin of the positions of each body in the scene, m.
    pub origins: Vec<[f64; 3]>,
    /// Shading of the surfaces.
    pub shading: Shading,
    /// How edges of triangles are drawn.
    pub wireframe: Wireframe,
    /// Whether surfaces have the colours and textures of their materials, where light and not a picture of a ball shades them.
    pub file_colours: bool,
    /// Opacity of surfaces, 0 to 1.
    pub opacity: f32,
    /// Whether the inner side of surfaces is marked: that of a solid is seen only through a hole, a sheet has two good sides.
    pub mark_backs: bool,
    /// Displacement of the last colour of [`Shading::Displacement`], m.
    pub full_displacement: f32,
    /// Colours of the background at the top and at the bottom, red, green, blue, 0 to 1.
    pub background: [[f32; 3]; 2],
    /// Channels that are drawn; the others keep what they have.
    pub channels: Channels,
    /// Lines to draw in the scene: two ends (m) and a colour each.
    pub lines: Vec<Line>,
    /// Area in which the reference image is drawn, behind everything else; `None` draws none.
    pub reference: Option<ReferenceQuad>,
}

/// A line in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Ends of the line, m.
    pub ends: [[f32; 3]; 2],
    /// Red, green, blue, opacity, 0 to 1.
    pub colour: [f32; 4],
}

/// A part of the picture, in pixels from the lower left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelArea {
    /// Distance of the left edge from that of the window, pixels.
    pub left: i32,
    /// Distance of the lower edge from that of the window, pixels.
    pub bottom: i32,
    /// Width of the area, pixels.
    pub width: i32,
    /// Height of the area, pixels.
    pub height: i32,
}

/// Draws surfaces. All calls come from the thread that owns the graphics context.
pub trait SurfaceRenderer {
    /// Takes over what has changed of a body.
    fn upload(&mut self, upload: &Upload);

    /// Takes over the reference image.
    ///
    /// # Errors
    /// A sentence why the graphics card does not take it, as where it is too large; there is no image then.
    fn upload_reference(&mut self, image: &RgbaImage) -> Result<(), String>;

    /// Forgets all bodies.
    fn clear(&mut self);

    /// Draws all bodies into a part of the present target.
    fn draw(&mut self, scene: &Scene, area: PixelArea);

    /// Red, green, blue and opacity of each pixel of a part of the present target (height x width x 4), top row first.
    fn read_back(&self, area: PixelArea) -> Vec<u8>;

    /// What draws: the name of the graphics card or program.
    fn name(&self) -> &str;
}
