//! Fibres of a scene: the directions of a body's entries, checked and placed.

use super::fields::{meets, place_of};
use super::place::{GroupPart, group_part};
use super::shared::SharedModel;
use crate::body::{Curve, DirectionCloud, FibreEntry, FibreLines, FibrePart, Fibres, FieldSurface};
use crate::scene::{AroundScene, BodyScene, FibreAxes, FibreScene, SceneError, Source};
use pliant_host::Material;
use pliant_mesh::Placement;
use pliant_mesh::read::read_text;
use pliant_solver::Vec3;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;

/// Numbers of a line of a file: a point and a direction.
const COLUMNS: usize = 6;

/// The fibres of a body with a material; `None` where the scene gives none.
///
/// # Errors
/// A material that takes no directions, a direction without length, a curve without direction, and a place, group or file that is not there.
pub(super) fn fibres(
    scene: &BodyScene,
    source: &Source,
    material: &Material,
    shared: &SharedModel,
) -> Result<Option<Arc<Fibres>>, SceneError> {
    let Some(first) = scene.fibre.first() else { return Ok(None) };
    if !material.takes_directions() {
        let text = format!(
            "material `{}` takes no fibre directions; allowed is one that does, as `fibre-reinforced`",
            material.info().id
        );
        return Err(source.error(first.span(), text));
    }
    let entry = |spanned: &Spanned<FibreScene>| -> Result<FibreEntry, SceneError> {
        let (fibre, span) = (spanned.get_ref(), spanned.span());
        let part = part(fibre, span.clone(), source, shared)?;
        let lines = FibreSource { fibre, span, source, placement: &shared.model.placement }.lines()?;
        Ok(FibreEntry { part, lines })
    };
    let entries = scene.fibre.iter().map(entry).collect::<Result<_, _>>()?;
    let surface = FieldSurface { model: Arc::clone(&shared.model), tree: Arc::clone(&shared.tree) };
    Ok(Some(Arc::new(Fibres::new(entries, surface))))
}

/// Where an entry applies.
fn part(
    fibre: &FibreScene,
    span: Range<usize>,
    source: &Source,
    shared: &SharedModel,
) -> Result<FibrePart, SceneError> {
    let surface = &shared.model.surface;
    if let Some(place) = place_of(fibre.box_.as_ref(), fibre.ball.as_ref(), fibre.radius.as_ref()) {
        let (min, max) = (surface.bounds().min, surface.bounds().max);
        if !meets(&place, min, max) {
            let text = format!(
                "the place of these fibres meets no part of the body, which is between {:?} and {:?} m",
                min.as_slice(),
                max.as_slice()
            );
            return Err(source.error(span, text));
        }
        return Ok(FibrePart::Place(place));
    }
    let Some(name) = &fibre.group else { return Ok(FibrePart::Whole) };
    Ok(match group_part(name, source, &shared.model)? {
        GroupPart::Triangles(all) => FibrePart::Triangles(all),
        GroupPart::Tetrahedra(all) => FibrePart::Tetrahedra(all),
    })
}

/// An entry of a scene, and the placement of the body's model.
struct FibreSource<'a> {
    fibre: &'a FibreScene,
    span: Range<usize>,
    source: &'a Source,
    placement: &'a Placement,
}

impl FibreSource<'_> {
    /// The lines of the entry, in the axes of the scene.
    fn lines(&self) -> Result<FibreLines, SceneError> {
        let fibre = self.fibre;
        match (&fibre.direction, &fibre.around, &fibre.along, &fibre.csv) {
            (Some(direction), ..) => {
                let wrong = |why: String| self.source.error(direction.span(), format!("direction {why}"));
                Ok(FibreLines::Parallel(self.unit(*direction.get_ref()).map_err(wrong)?))
            }
            (_, Some(around), ..) => self.around(around),
            (_, _, Some(points), _) => self.along(points),
            (_, _, _, Some(csv)) => self.cloud(csv),
            _ => Err(self.source.error(self.span.clone(), "fibres without a direction")),
        }
    }

    /// The unit vector along a vector of the entry.
    fn unit(&self, vector: [f64; 3]) -> Result<Vec3, String> {
        let length = Vec3::from(vector).norm();
        if !(length.is_finite() && length > f64::MIN_POSITIVE) {
            return Err(format!("{vector:?}; allowed is three finite numbers that are not all 0"));
        }
        let unit = Vec3::from(vector) / length;
        Ok(if self.fibre.axes == FibreAxes::Model { self.placement.rotation * unit } else { unit })
    }

    /// Refuses units of points that are in those of the model's file.
    fn require_numbers(&self, points: Range<usize>) -> Result<(), SceneError> {
        let text = self.source.text.get(points.clone()).unwrap_or_default();
        if self.fibre.axes == FibreAxes::Model && text.contains(['"', '\'']) {
            let text =
                "a point with a unit; allowed with `axes = \"model\"` is numbers, in the units of the model's file";
            return Err(self.source.error(points, text));
        }
        Ok(())
    }

    /// A point of the entry, m.
    fn point(&self, point: Vec3) -> Vec3 {
        if self.fibre.axes == FibreAxes::Model { self.placement.apply(point) } else { point }
    }

    fn around(&self, around: &Spanned<AroundScene>) -> Result<FibreLines, SceneError> {
        let AroundScene { axis, point, helix_angle } = around.get_ref();
        let axis = self.unit(*axis).map_err(|why| self.source.error(around.span(), format!("axis {why}")))?;
        self.require_numbers(point.span())?;
        let angle = [libm::cos(helix_angle.si), libm::sin(helix_angle.si)];
        Ok(FibreLines::Around { axis, point: self.point(point.get_ref().map(|c| c.si).into()), angle })
    }

    fn along(&self, points: &Spanned<Vec<[crate::scene::Length; 3]>>) -> Result<FibreLines, SceneError> {
        self.require_numbers(points.span())?;
        let wrong = |text: String| self.source.error(points.span(), text);
        let placed: Vec<Vec3> = points.get_ref().iter().map(|point| self.point(point.map(|c| c.si).into())).collect();
        if placed.len() < 2 {
            return Err(wrong(format!("`along` has {} points; allowed is 2 or more", placed.len())));
        }
        Curve::new(placed).map(FibreLines::Along).map_err(|index| {
            wrong(format!(
                "`along` has no direction at point {}; allowed is points that differ from the one before, without turning back",
                index + 1
            ))
        })
    }

    /// Points with directions read from a file, one per line; empty lines and lines that start with `#` are skipped.
    fn cloud(&self, csv: &Spanned<String>) -> Result<FibreLines, SceneError> {
        let path = self.source.folder().join(csv.get_ref());
        let wrong = |why: String| self.source.error(csv.span(), format!("{}: {why}", path.display()));
        let text = read_text(&path).map_err(|error| wrong(error.to_string()))?;
        let lines = text.lines().enumerate();
        let lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim().starts_with('#'));
        let sample = |(number, line): (usize, &str)| {
            let values: Option<Vec<f64>> = line.split(',').map(|value| value.trim().parse().ok()).collect();
            let values = values.filter(|values| values.len() == COLUMNS && values.iter().all(|v| v.is_finite()));
            let of_line = |why: String| wrong(format!("line {}: {why}", number + 1));
            let Some(v) = values else {
                return Err(of_line(format!("{}; allowed is `x, y, z, dx, dy, dz`, six finite numbers", line.trim())));
            };
            let direction = self.unit([v[3], v[4], v[5]]).map_err(|why| of_line(format!("direction {why}")))?;
            Ok((self.point(Vec3::new(v[0], v[1], v[2])), direction))
        };
        let samples = lines.map(sample).collect::<Result<Vec<_>, _>>()?;
        if samples.is_empty() {
            return Err(wrong("no points; allowed is one or more lines `x, y, z, dx, dy, dz`".into()));
        }
        Ok(FibreLines::Cloud(DirectionCloud::new(samples)))
    }
}
