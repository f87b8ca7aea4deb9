//! Settings of the view of the model.

use crate::gl::{Shading, Stereo, Wireframe};

/// Settings of the view of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSettings {
    /// Shading of the surfaces.
    pub shading: Shading,
    /// How edges of triangles are drawn.
    pub wireframe: Wireframe,
    /// Whether surfaces have the colours and textures of the file.
    pub file_colours: bool,
    /// Opacity of surfaces, 0 to 1.
    pub opacity: f32,
    /// How the pictures of two eyes are shown.
    pub stereo: Stereo,
    /// Whether there is a grid on the ground.
    pub ground: bool,
    /// Whether the simulated cells are drawn.
    pub cells: bool,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            shading: Shading::Studio,
            wireframe: Wireframe::Off,
            file_colours: true,
            opacity: 1.0,
            stereo: Stereo::Off,
            ground: true,
            cells: false,
        }
    }
}
