//! Fields of a scene: which parameter of a body's material differs, where, and by what factor.

mod mesh_data;
mod on_surface;
mod painted;

use super::shared::SharedModel;
use crate::body::{FieldSurface, Fields, Layer, Place};
use crate::scene::{BodyScene, FieldScene, Length, SceneError, Source};
use mesh_data::ArrayField;
use on_surface::SurfaceFieldReader;
pub(super) use painted::{check_paint_range, refusal};
use pliant_host::{ParamKind, ParamSettings, ParamValue, PluginInfo};
use pliant_mesh::geometry::Vec3;
use std::ops::RangeInclusive;
use std::sync::Arc;
use toml::Spanned;

/// Range of the factors that a scene may give.
const FACTOR_RANGE: RangeInclusive<f64> = 0.1..=10.0;

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
        let layer = match &field.data {
            Some(data) => ArrayField { data, unit: field.unit.as_ref(), key, source, shared }.layer(info, settings)?,
            None => layer(spanned, source, shared)?,
        };
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
    check_factors(key, layer.bounds(), info, settings)
        .map_err(|why| source.error(field.param.span(), format!("field of `{key}`: {why}")))
}

/// Refuses factors that lead out of the range of the parameter `key`.
fn check_factors(key: &str, factors: [f64; 2], info: &PluginInfo, settings: &ParamSettings) -> Result<(), String> {
    let Some((index, param)) = info.params.iter().enumerate().find(|(_, param)| param.key == key) else {
        return Ok(());
    };
    let ParamKind::Number { default, .. } = param.kind else { return Ok(()) };
    let given = settings.iter().find(|(i, _)| *i == index).map(|(_, value)| value);
    let value = if let Some(ParamValue::Number(value)) = given { *value } else { default };
    let check = |factor: f64| {
        let checked = param.check(&ParamValue::Number(factor * value));
        checked.map_err(|why| format!("{factor} times {value}: {why}"))
    };
    factors.into_iter().try_for_each(check)
}

/// What one entry gives.
fn layer(spanned: &Spanned<FieldScene>, source: &Source, shared: &SharedModel) -> Result<Layer, SceneError> {
    let (field, span) = (spanned.get_ref(), spanned.span());
    let surface = &shared.model.surface;
    if let Some(place) = place_of(field.box_.as_ref(), field.ball.as_ref(), field.radius.as_ref()) {
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
    let on_surface = SurfaceFieldReader { field, span, source, shared };
    match field {
        FieldScene { group: Some(name), .. } => on_surface.group(name, factor(field, source, &spanned.span())?),
        FieldScene { colour: Some(channel), .. } => on_surface.colours(*channel),
        FieldScene { csv: Some(csv), .. } => on_surface.csv(csv),
        FieldScene { texture: Some(texture), .. } => on_surface.texture(texture),
        _ => Err(source.error(spanned.span(), "a field without a place")),
    }
}

/// `factor`, if it is in [`FACTOR_RANGE`]; otherwise an error that names the range.
fn check_factor(factor: f64) -> Result<f64, String> {
    if FACTOR_RANGE.contains(&factor) { Ok(factor) } else { Err(format!("allowed: {}", factor_range_text())) }
}

/// [`FACTOR_RANGE`] as text: `0.1 to 10`.
fn factor_range_text() -> String {
    format!("{} to {}", FACTOR_RANGE.start(), FACTOR_RANGE.end())
}

/// The factor of an entry that has one.
fn factor(field: &FieldScene, source: &Source, span: &std::ops::Range<usize>) -> Result<f64, SceneError> {
    let Some(factor) = &field.factor else {
        return Err(source.error(span.clone(), format!("a field without `factor`; allowed: {}", factor_range_text())));
    };
    check_factor(*factor.get_ref())
        .map_err(|allowed| source.error(factor.span(), format!("factor {}; {allowed}", factor.get_ref())))
}

/// The box or ball of an entry; `None` for one without.
pub(super) fn place_of(
    corners: Option<&[[Length; 3]; 2]>,
    ball: Option<&[Length; 3]>,
    radius: Option<&Length>,
) -> Option<Place> {
    let point = |point: &[Length; 3]| Vec3::from(point.map(|c| c.si));
    match (corners, ball) {
        (Some([min, max]), _) => Some(Place::Box { min: point(min), max: point(max) }),
        (None, Some(centre)) => {
            Some(Place::Ball { centre: point(centre), radius: radius.map_or(0.0, |radius| radius.si) })
        }
        (None, None) => None,
    }
}

/// Whether a box or ball meets the box of a body (m).
pub(super) fn meets(place: &Place, low: Vec3, high: Vec3) -> bool {
    match place {
        Place::Box { min, max } => (0..3).all(|i| min[i] <= high[i] && low[i] <= max[i]),
        Place::Ball { centre, radius } => (centre.sup(&low).inf(&high) - centre).norm() <= *radius,
        Place::Nodes(_) | Place::Vertices(_) | Place::Cells(_) => true,
    }
}
