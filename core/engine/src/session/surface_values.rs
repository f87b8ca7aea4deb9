//! Values from 0 to 1 that the OBJ of a body gives over its surface: channels of its vertices' colours, and grey images by its texture coordinates.

use crate::body::Model;
use crate::scene::{Channel, SceneError, Source};
use pliant_mesh::GreyImage;
use std::ops::Range;
use toml::Spanned;

/// A model whose surface an entry of a scene takes values from.
#[derive(Clone, Copy)]
pub(super) struct SurfaceValues<'a> {
    pub(super) model: &'a Model,
    pub(super) source: &'a Source,
}

impl SurfaceValues<'_> {
    /// A channel of the colour of each vertex, 0 to 1 (n).
    ///
    /// # Errors
    /// A vertex without a colour, or with one outside of 0 to 1. `span` is that of the entry.
    pub(super) fn colours(&self, channel: Channel, span: &Range<usize>) -> Result<Vec<f64>, SceneError> {
        let document = &self.model.document;
        let value = |vertex: usize| {
            let value = document.colour_of_vertex(vertex).map(|colour| colour[channel as usize]);
            value.filter(|value| (0.0..=1.0).contains(value)).ok_or_else(|| {
                let line = document.line_of_vertex(vertex).unwrap_or(0);
                let found = value.map_or("no colour".into(), |value| format!("a colour of {value}"));
                let text = format!(
                    "{}: line {line}: vertex {} has {found}; allowed is `v x y z r g b` with 0 to 1",
                    document.name().display(),
                    vertex + 1
                );
                self.source.error(span.clone(), text)
            })
        };
        (0..self.model.surface.points.len()).map(value).collect()
    }

    /// Texture coordinates of the corners of each triangle (m x 3).
    ///
    /// # Errors
    /// A face without texture coordinates. `span` is that of the entry.
    pub(super) fn texture_corners(&self, span: &Range<usize>) -> Result<Vec<[[f64; 2]; 3]>, SceneError> {
        let Model { document, surface, .. } = self.model;
        let mut all = Vec::with_capacity(surface.triangles.len());
        for (corners, face) in surface.triangles.iter().zip(&surface.face_of) {
            let [a, b, c] = corners.map(|vertex| document.texcoord_at(*face, vertex));
            let (Some(a), Some(b), Some(c)) = (a, b, c) else {
                let line = document.face(*face as usize).map_or(0, |face| face.line);
                let text = format!(
                    "{}: line {line}: a face without texture coordinates; allowed is `f v/vt v/vt v/vt`, with coordinates at every corner of \
                     every face",
                    document.name().display()
                );
                return Err(self.source.error(span.clone(), text));
            };
            all.push([a, b, c]);
        }
        Ok(all)
    }

    /// The grey image in a file, by its path relative to the scene.
    ///
    /// # Errors
    /// A file that is not there or is no image that is read.
    pub(super) fn image(&self, texture: &Spanned<String>) -> Result<GreyImage, SceneError> {
        let image = GreyImage::read(&self.source.folder().join(texture.get_ref()));
        image.map_err(|error| self.source.error(texture.span(), error.to_string()))
    }
}
