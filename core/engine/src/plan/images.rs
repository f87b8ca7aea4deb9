//! Mirror images of the hand of an edit with `symmetry`.

use crate::body::Axes;
use crate::scene::{EditScene, SceneError, Source, SymmetryScene};
use pliant_solver::Vec3;
use std::ops::Range;

/// A mirror image of a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Image {
    /// Mirrored along these axes of the scene, about the middle of the first body's box.
    Axes(Axes),
    /// Mirrored along this axis (0 to 2) of the first body's model, about the middle of its box in its file.
    OwnAxis(usize),
    /// Mirrored in a plane of the scene.
    Plane {
        /// A point on it, m.
        point: Vec3,
        /// Its normal, of any length above 0.
        normal: Vec3,
    },
}

/// The mirror images of the hand of an edit; empty without `symmetry`.
///
/// # Errors
/// Fails for axes other than x, y and z, an axis that is repeated, more than one axis of the model, for a point that is not finite, and for a normal without a direction.
pub(super) fn images(edit: &EditScene, source: &Source) -> Result<Vec<Image>, SceneError> {
    let Some(symmetry) = &edit.symmetry else { return Ok(Vec::new()) };
    let span = symmetry.span();
    match symmetry.get_ref() {
        SymmetryScene::Axes(text) => Ok(sets(text, span, source)?.into_iter().map(Image::Axes).collect()),
        SymmetryScene::Own { own } => match ["x", "y", "z"].iter().position(|axis| axis == own) {
            Some(axis) => Ok(vec![Image::OwnAxis(axis)]),
            None => {
                let text =
                    format!("symmetry in the plane {own:?} of the model; allowed is one of \"x\", \"y\" and \"z\"");
                Err(source.error(span, text))
            }
        },
        SymmetryScene::Plane { point, normal } => {
            let point = Vec3::from(point.map(|length| length.si));
            let normal = Vec3::from(*normal);
            let size = normal.norm();
            if !(size > 0.0 && size.is_finite() && point.iter().all(|c| c.is_finite())) {
                let text = format!(
                    "symmetry in a plane through {:?} m with the normal {:?}; allowed are finite numbers, and a normal that is not zero",
                    point.as_slice(),
                    normal.as_slice()
                );
                return Err(source.error(span, text));
            }
            Ok(vec![Image::Plane { point, normal }])
        }
    }
}

/// Every set of the axes in a text but the empty one.
fn sets(text: &str, span: Range<usize>, source: &Source) -> Result<Vec<Axes>, SceneError> {
    let axes: Vec<usize> = text.chars().filter_map(|c| "xyz".find(c)).collect();
    let repeated = (1..axes.len()).any(|i| axes[..i].contains(&axes[i]));
    if axes.is_empty() || axes.len() != text.chars().count() || repeated {
        let allowed = "allowed is one or more of x, y and z, such as \"x\" or \"xz\"";
        return Err(source.error(span, format!("symmetry {text:?}; {allowed}")));
    }
    let image = |set: usize| {
        let mut image = [false; 3];
        axes.iter().enumerate().for_each(|(bit, axis)| image[*axis] = set >> bit & 1 == 1);
        image
    };
    Ok((1..1 << axes.len()).map(image).collect())
}
