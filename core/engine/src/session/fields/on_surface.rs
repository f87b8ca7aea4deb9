//! Fields that are given on the surface: groups, colours and texture coordinates of its OBJ, and files beside it.

use super::ALLOWED;
use crate::body::{Layer, factor_at};
use crate::scene::{Channel, FieldScene, SceneError, Source};
use crate::session::place::{GroupPart, group_part};
use crate::session::shared::SharedModel;
use pliant_mesh::GreyImage;
use pliant_mesh::read::read_text;
use std::ops::Range;
use toml::Spanned;

/// An entry of a scene, and the surface it is about.
pub(super) struct SurfaceSource<'a> {
    pub(super) field: &'a FieldScene,
    pub(super) span: Range<usize>,
    pub(super) source: &'a Source,
    pub(super) shared: &'a SharedModel,
}

impl SurfaceSource<'_> {
    /// One factor for the faces with a name, or of a tetrahedral mesh for the tetrahedra of a group.
    pub(super) fn group(&self, name: &Spanned<String>, factor: f64) -> Result<Layer, SceneError> {
        Ok(match group_part(name, self.source, &self.shared.model)? {
            GroupPart::Triangles(all) => {
                Layer::Triangles(all.into_iter().map(|is| if is { factor } else { 1.0 }).collect())
            }
            GroupPart::Tetrahedra(is_inside) => Layer::Tetrahedra { is_inside, factor },
        })
    }

    /// Factors by a channel of the vertices' colours.
    pub(super) fn colours(&self, channel: Channel) -> Result<Layer, SceneError> {
        let document = &self.shared.model.document;
        let range = self.range()?;
        let mut factors = Vec::new();
        for vertex in 0..self.shared.model.surface.points.len() {
            let value = document.colour_of_vertex(vertex).map(|colour| colour[channel as usize]);
            let Some(value) = value.filter(|value| (0.0..=1.0).contains(value)) else {
                let line = document.line_of_vertex(vertex).unwrap_or(0);
                let found = value.map_or("no colour".into(), |value| format!("a colour of {value}"));
                let text = format!(
                    "{}: line {line}: vertex {} has {found}; allowed is `v x y z r g b` with 0 to 1",
                    document.name().display(),
                    vertex + 1
                );
                return Err(self.source.error(self.span.clone(), text));
            };
            factors.push(factor_at(range, value));
        }
        Ok(Layer::Vertices(factors))
    }

    /// A factor of each vertex, from the program or from the lines of a file.
    pub(super) fn csv(&self, csv: &Spanned<String>) -> Result<Layer, SceneError> {
        let factors = match self.source.factors.get(csv.get_ref()) {
            Some(given) => given_factors(given, csv, self.source)?,
            None => read_factors(csv, self.source)?,
        };
        let vertices = self.shared.model.surface.points.len();
        if factors.len() != vertices {
            let text = format!(
                "{}: {} factors for {vertices} vertices; allowed is one a vertex",
                csv.get_ref(),
                factors.len()
            );
            return Err(self.source.error(csv.span(), text));
        }
        Ok(Layer::Vertices(factors))
    }

    /// Factors by a grey image.
    pub(super) fn texture(&self, texture: &Spanned<String>) -> Result<Layer, SceneError> {
        let range = self.range()?;
        let corners = self.texture_corners(texture.span())?;
        let image = GreyImage::read(&self.source.folder().join(texture.get_ref()));
        let image = image.map_err(|error| self.source.error(texture.span(), error.to_string()))?;
        Ok(Layer::Texture { image, corners, range })
    }

    /// Texture coordinates of the corners of each triangle.
    fn texture_corners(&self, span: Range<usize>) -> Result<Vec<[[f64; 2]; 3]>, SceneError> {
        let (document, surface) = (&self.shared.model.document, &self.shared.model.surface);
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
                return Err(self.source.error(span, text));
            };
            all.push([a, b, c]);
        }
        Ok(all)
    }

    /// The factors at 0 and 1.
    fn range(&self) -> Result<[f64; 2], SceneError> {
        let [low, high] = self.field.range.unwrap_or([*ALLOWED.start(), *ALLOWED.end()]);
        if ALLOWED.contains(&low) && ALLOWED.contains(&high) {
            return Ok([low, high]);
        }
        let text = format!("range [{low}, {high}]; allowed is factors from {} to {}", ALLOWED.start(), ALLOWED.end());
        Err(self.source.error(self.span.clone(), text))
    }
}

/// Factors that the program hands over, one a vertex.
fn given_factors(given: &[f64], csv: &Spanned<String>, source: &Source) -> Result<Vec<f64>, SceneError> {
    if let Some(vertex) = given.iter().position(|factor| !ALLOWED.contains(factor)) {
        let (least, most) = (ALLOWED.start(), ALLOWED.end());
        let text = format!("{}: vertex {vertex}: {}; allowed is {least} to {most}", csv.get_ref(), given[vertex]);
        return Err(source.error(csv.span(), text));
    }
    Ok(given.to_vec())
}

/// Factors of a file, one a line; empty lines and those with `#` are skipped.
fn read_factors(csv: &Spanned<String>, source: &Source) -> Result<Vec<f64>, SceneError> {
    let path = source.folder().join(csv.get_ref());
    let wrong = |why: String| source.error(csv.span(), format!("{}: {why}", path.display()));
    let text = read_text(&path).map_err(|error| wrong(error.to_string()))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.trim().starts_with('#'));
    lines
        .map(|(number, line)| {
            let value = line.trim().trim_end_matches(',').parse::<f64>().ok().filter(|value| ALLOWED.contains(value));
            value.ok_or_else(|| {
                let (least, most) = (ALLOWED.start(), ALLOWED.end());
                wrong(format!("line {}: {}; allowed is a number from {least} to {most}", number + 1, line.trim()))
            })
        })
        .collect()
}
