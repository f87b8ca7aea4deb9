//! Fields that are given on the surface: groups, colours and texture coordinates of its OBJ, and files beside it.

use super::ALLOWED;
use crate::body::{Layer, factor_at};
use crate::scene::{Channel, FieldScene, SceneError, Source};
use crate::session::place::{GroupPart, group_part};
use crate::session::shared::SharedModel;
use crate::session::surface_values::SurfaceValues;
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
        let range = self.range()?;
        let values = self.values().colours(channel, &self.span)?;
        Ok(Layer::Vertices(values.into_iter().map(|value| factor_at(range, value)).collect()))
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
        let corners = self.values().texture_corners(&texture.span())?;
        let image = self.values().image(texture)?;
        Ok(Layer::Texture { image, corners, range })
    }

    fn values(&self) -> SurfaceValues<'_> {
        SurfaceValues { model: &self.shared.model, source: self.source }
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
