//! Fields of a scene: which parameter of a body's material differs, where, and by what factor.

use super::shared::SharedModel;
use crate::body::{FieldSurface, Fields, Layer, Place};
use crate::scene::{BodyScene, Channel, FieldScene, SceneError, Source};
use pliant_host::{ParamKind, ParamSettings, ParamValue, PluginInfo};
use pliant_mesh::geometry::Vec3;
use std::ops::RangeInclusive;
use std::sync::Arc;
use toml::Spanned;

/// Factors that a scene may give.
const ALLOWED: RangeInclusive<f64> = 0.1..=10.0;

/// The fields of a body with a material and its settings; `None` where the scene gives none.
///
/// # Errors
/// A parameter that may not differ, a factor that is not allowed or leads out of the parameter's range, and a place, group, colour or file
/// that is not there.
pub(super) fn fields(
    scene: &BodyScene,
    source: &Source,
    info: &PluginInfo,
    settings: &ParamSettings,
    shared: &SharedModel,
) -> Result<Option<Arc<Fields>>, SceneError> {
    if scene.field.is_empty() {
        return Ok(None);
    }
    let mut planes: Vec<Vec<Layer>> = info.fields().map(|_| Vec::new()).collect();
    for spanned in &scene.field {
        let field = spanned.get_ref();
        let key = field.param.get_ref();
        let Some(plane) = info.fields().position(|param| param.key == *key) else {
            let known: Vec<&str> = info.fields().map(|param| param.key.as_str()).collect();
            let known = if known.is_empty() { "none of its parameters".into() } else { known.join(", ") };
            let text = format!(
                "material `{}`: parameter `{key}` cannot differ from place to place; allowed is {known}",
                info.id
            );
            return Err(source.error(field.param.span(), text));
        };
        let layer = layer(spanned, source, shared)?;
        check_range(field, source, info, settings, &layer)?;
        planes[plane].push(layer);
    }
    let surface = FieldSurface { model: Arc::clone(&shared.model), tree: Arc::clone(&shared.tree) };
    Ok(Some(Arc::new(Fields::new(planes, surface))))
}

/// Refuses a factor that leads out of the parameter's range.
fn check_range(
    field: &FieldScene,
    source: &Source,
    info: &PluginInfo,
    settings: &ParamSettings,
    layer: &Layer,
) -> Result<(), SceneError> {
    let key = field.param.get_ref();
    let Some((index, param)) = info.params.iter().enumerate().find(|(_, param)| param.key == *key) else {
        return Ok(());
    };
    let ParamKind::Number { default, .. } = param.kind else { return Ok(()) };
    let given = settings.iter().find(|(i, _)| *i == index).map(|(_, value)| value);
    let value = if let Some(ParamValue::Number(value)) = given { *value } else { default };
    for factor in layer.bounds() {
        if let Err(why) = param.check(&ParamValue::Number(factor * value)) {
            let text = format!("field of `{key}`: {factor} times {value}: {why}");
            return Err(source.error(field.param.span(), text));
        }
    }
    Ok(())
}

/// What one entry gives.
fn layer(spanned: &Spanned<FieldScene>, source: &Source, shared: &SharedModel) -> Result<Layer, SceneError> {
    let (field, span) = (spanned.get_ref(), spanned.span());
    let (document, surface) = (&shared.model.document, &shared.model.surface);
    if let Some(place) = place(field) {
        if !meets(&place, surface.bounds().min, surface.bounds().max) {
            let (min, max) = (surface.bounds().min, surface.bounds().max);
            let text = format!(
                "the place of this field meets no part of the body, which is between {:?} and {:?} m",
                min.as_slice(),
                max.as_slice()
            );
            return Err(source.error(span, text));
        }
        return Ok(Layer::Place { place, factor: factor(field, source, &span)? });
    }
    if let Some(group) = &field.group {
        let name = group.get_ref();
        let Some(index) = document.groups().iter().position(|known| known == name) else {
            let known = document.groups().iter().map(|known| format!("`{known}`")).collect::<Vec<_>>().join(", ");
            let known = if known.is_empty() { "none: the model has no groups".into() } else { known };
            return Err(source.error(group.span(), format!("no group `{name}` in the model; allowed is {known}")));
        };
        let factor = factor(field, source, &span)?;
        let is_in = |face: u32| document.face(face as usize).and_then(|f| f.attributes.group) == Some(index as u32);
        return Ok(Layer::Triangles(surface.face_of.iter().map(|f| if is_in(*f) { factor } else { 1.0 }).collect()));
    }
    if let Some(channel) = field.colour {
        return colours(field, channel, source, &span, shared);
    }
    let Some(csv) = &field.csv else { return Err(source.error(span, "a field without a place")) };
    let factors = match source.factors.get(csv.get_ref()) {
        Some(given) => given_factors(given, csv, source)?,
        None => read_factors(csv, source)?,
    };
    if factors.len() != surface.points.len() {
        let text = format!(
            "{}: {} factors for {} vertices; allowed is one a vertex",
            csv.get_ref(),
            factors.len(),
            surface.points.len()
        );
        return Err(source.error(csv.span(), text));
    }
    Ok(Layer::Vertices(factors))
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
    let text = std::fs::read_to_string(&path).map_err(|error| wrong(error.to_string()))?;
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

/// The factor of an entry that has one.
fn factor(field: &FieldScene, source: &Source, span: &std::ops::Range<usize>) -> Result<f64, SceneError> {
    let allowed = format!("a number from {} to {}", ALLOWED.start(), ALLOWED.end());
    match &field.factor {
        None => Err(source.error(span.clone(), format!("a field without `factor`; allowed is {allowed}"))),
        Some(factor) if !ALLOWED.contains(factor.get_ref()) => {
            Err(source.error(factor.span(), format!("factor {}; allowed is {allowed}", factor.get_ref())))
        }
        Some(factor) => Ok(*factor.get_ref()),
    }
}

/// The box or ball of an entry.
fn place(field: &FieldScene) -> Option<Place> {
    match (&field.box_, &field.ball) {
        (Some([min, max]), _) => Some(Place::Box { min: min.map(|c| c.si).into(), max: max.map(|c| c.si).into() }),
        (None, Some(centre)) => {
            Some(Place::Ball { centre: centre.map(|c| c.si).into(), radius: field.radius.map_or(0.0, |r| r.si) })
        }
        (None, None) => None,
    }
}

/// Whether a box or ball meets the box of a body (m).
fn meets(place: &Place, low: Vec3, high: Vec3) -> bool {
    match place {
        Place::Box { min, max } => (0..3).all(|i| min[i] <= high[i] && low[i] <= max[i]),
        Place::Ball { centre, radius } => (centre.sup(&low).inf(&high) - centre).norm() <= *radius,
        Place::Nodes(_) => true,
    }
}

/// Factors by a channel of the vertices' colours.
fn colours(
    field: &FieldScene,
    channel: Channel,
    source: &Source,
    span: &std::ops::Range<usize>,
    shared: &SharedModel,
) -> Result<Layer, SceneError> {
    let document = &shared.model.document;
    let [low, high] = field.range.unwrap_or([*ALLOWED.start(), *ALLOWED.end()]);
    if !(ALLOWED.contains(&low) && ALLOWED.contains(&high)) {
        let text = format!("range [{low}, {high}]; allowed is factors from {} to {}", ALLOWED.start(), ALLOWED.end());
        return Err(source.error(span.clone(), text));
    }
    let mut factors = Vec::new();
    for vertex in 0..shared.model.surface.points.len() {
        let value = document.colour_of_vertex(vertex).map(|colour| colour[channel as usize]);
        let Some(value) = value.filter(|value| (0.0..=1.0).contains(value)) else {
            let line = document.line_of_vertex(vertex).unwrap_or(0);
            let found = value.map_or("no colour".into(), |value| format!("a colour of {value}"));
            let text = format!(
                "{}: line {line}: vertex {} has {found}; allowed is `v x y z r g b` with 0 to 1",
                document.name().display(),
                vertex + 1
            );
            return Err(source.error(span.clone(), text));
        };
        factors.push(low * libm::exp(value * libm::log(high / low)));
    }
    Ok(Layer::Vertices(factors))
}
