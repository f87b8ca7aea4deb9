//! Fields of material parameters read from surface data (groups, vertex colours, textures, CSV files) or from a group of tetrahedra.

use super::{FACTOR_RANGE, check_factor};
use crate::body::{Layer, factor_at};
use crate::scene::{Channel, FieldScene, SceneError, Source};
use crate::session::place::{GroupPart, group_part};
use crate::session::shared::SharedModel;
use crate::session::surface_values::SurfaceValues;
use pliant_mesh::read::read_text;
use std::ops::Range;
use toml::Spanned;

/// One `[[body.field]]` entry and the model it applies to.
pub(super) struct SurfaceFieldReader<'a> {
    pub(super) field: &'a FieldScene,
    pub(super) span: Range<usize>,
    pub(super) source: &'a Source,
    pub(super) shared: &'a SharedModel,
}

impl SurfaceFieldReader<'_> {
    /// A constant factor on a named group of faces, or of tetrahedra in a tetrahedral mesh; 1 elsewhere.
    pub(super) fn group(&self, name: &Spanned<String>, factor: f64) -> Result<Layer, SceneError> {
        Ok(match group_part(name, self.source, &self.shared.model)? {
            GroupPart::Triangles(in_group) => {
                let factor_of = |in_group| if in_group { factor } else { 1.0 };
                Layer::Triangles(in_group.into_iter().map(factor_of).collect())
            }
            GroupPart::Tetrahedra(is_inside) => Layer::Tetrahedra { is_inside, factor },
        })
    }

    /// Factors of the vertices, from a channel of their colours.
    pub(super) fn colours(&self, channel: Channel) -> Result<Layer, SceneError> {
        let range = self.factor_range()?;
        let values = self.values().colours(channel, &self.span)?;
        Ok(Layer::Vertices(values.into_iter().map(|value| factor_at(range, value)).collect()))
    }

    /// One factor per vertex, supplied by the caller or read from the lines of a file.
    pub(super) fn csv(&self, csv: &Spanned<String>) -> Result<Layer, SceneError> {
        let factors = match self.source.factors.get(csv.get_ref()) {
            Some(given) => caller_factors(given, csv, self.source)?,
            None => read_factors(csv, self.source)?,
        };
        let vertices = self.shared.model.surface.points.len();
        if factors.len() != vertices {
            let text = format!("{}: {} factors; expected one per vertex ({vertices})", csv.get_ref(), factors.len());
            return Err(self.source.error(csv.span(), text));
        }
        Ok(Layer::Vertices(factors))
    }

    /// Factors from a grey image at the texture coordinates.
    pub(super) fn texture(&self, texture: &Spanned<String>) -> Result<Layer, SceneError> {
        let range = self.factor_range()?;
        let corners = self.values().texture_corners(&texture.span())?;
        let image = self.values().image(texture)?;
        Ok(Layer::Texture { image, corners, range })
    }

    /// Reader of the colours, texture coordinates and images of the model.
    fn values(&self) -> SurfaceValues<'_> {
        SurfaceValues { model: &self.shared.model, source: self.source }
    }

    /// Factors for the values 0 and 1; values between are interpolated geometrically.
    fn factor_range(&self) -> Result<[f64; 2], SceneError> {
        let range @ [low, high] = self.field.range.unwrap_or([*FACTOR_RANGE.start(), *FACTOR_RANGE.end()]);
        for factor in range {
            check_factor(factor)
                .map_err(|allowed| self.source.error(self.span.clone(), format!("range [{low}, {high}]; {allowed}")))?;
        }
        Ok(range)
    }
}

/// Factors supplied by the caller, one per vertex.
fn caller_factors(given: &[f64], csv: &Spanned<String>, source: &Source) -> Result<Vec<f64>, SceneError> {
    let check = |(vertex, factor): (usize, &f64)| {
        check_factor(*factor).map_err(|allowed| {
            source.error(csv.span(), format!("{}: vertex {vertex}: {factor}; {allowed}", csv.get_ref()))
        })
    };
    given.iter().enumerate().map(check).collect()
}

/// Factors read from a file, one per line; empty lines and lines that start with `#` are skipped.
fn read_factors(csv: &Spanned<String>, source: &Source) -> Result<Vec<f64>, SceneError> {
    let path = source.folder().join(csv.get_ref());
    let wrong = |why: String| source.error(csv.span(), format!("{}: {why}", path.display()));
    let text = read_text(&path).map_err(|error| wrong(error.to_string()))?;
    let lines = text.lines().map(str::trim).enumerate().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    lines
        .map(|(number, line)| {
            // What is not a number becomes NaN, which is out of range.
            let factor = line.strip_suffix(',').unwrap_or(line).parse().unwrap_or(f64::NAN);
            check_factor(factor).map_err(|allowed| wrong(format!("line {}: {line}; {allowed}", number + 1)))
        })
        .collect()
}
