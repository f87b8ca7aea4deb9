//! Subdivision of a body's model before it is used, so that a dent has vertices to show it.

use super::SessionError;
use super::memory_checks::ModelCheck;
use crate::body::Subdivision;
use crate::scene::Level;
use pliant_mesh::ObjDocument;

/// Longest side of a face that `auto` leaves, relative to the radius of the smallest tool.
const SIDE_SHARE: f64 = 0.5;
/// Largest number of faces that `auto` makes.
const MOST_FACES: usize = 1_000_000;
/// Largest number of times that a scene may ask for: a million times the faces.
const MOST_LEVELS: u32 = 10;

/// Divides the faces of a body's model as its scene asks for. `scale` is metres per unit of the file, `smallest` the radius of the smallest tool, m, 0
/// without one.
///
/// # Errors
/// Returns an error for a number of levels that is not allowed, or a model that would need more memory than there is.
pub(super) fn subdivide(
    check: &ModelCheck<'_>,
    mut document: ObjDocument,
    scale: f64,
    smallest: f64,
) -> Result<(ObjDocument, Option<Subdivision>), SessionError> {
    let Some(asked) = &check.scene.subdivide else { return Ok((document, None)) };
    let (levels, why) = match asked.get_ref() {
        Level::At(levels) if *levels > MOST_LEVELS => {
            let text = format!("subdivide = {levels}; allowed is 1 to {MOST_LEVELS}, or \"auto\"");
            return Err(check.source.error(asked.span(), text).into());
        }
        Level::At(levels) => (*levels, "the scene asks for it".into()),
        Level::Auto => choose(&document, scale, smallest),
    };
    for _ in 0..levels {
        check.subdivision(&document)?;
        document = document.subdivided()?;
    }
    Ok((document, Some(Subdivision { levels, why })))
}

/// How often the faces of a document are divided by `auto`, and why.
fn choose(document: &ObjDocument, scale: f64, smallest: f64) -> (u32, String) {
    if smallest == 0.0 {
        return (0, "no tool is in use".into());
    }
    let side = document.longest_side() * scale;
    let wanted = (0..u64::BITS).find(|levels| side <= SIDE_SHARE * smallest * (1_u64 << levels) as f64).unwrap_or(0);
    let faces = |levels: u32| match levels {
        0 => document.face_count(),
        more => document.faces_subdivided().saturating_mul(4_usize.saturating_pow(more - 1)),
    };
    let levels = (0..=wanted).rev().find(|levels| faces(*levels) <= MOST_FACES).unwrap_or(0);
    let [left, tool] = [side / (1_u64 << levels) as f64, smallest].map(|length| 1e3 * length);
    let why = if levels < wanted {
        format!("sides of up to {left:.3} mm; once more would make {} faces, over {MOST_FACES}", faces(levels + 1))
    } else {
        format!("sides of up to {left:.3} mm are at most half of the smallest tool's radius, {tool:.3} mm")
    };
    (levels, why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::generate::cuboid;

    #[test]
    fn sides_are_at_most_half_of_the_radius_and_no_level_is_one_too_many() {
        for cells in [1, 3, 10] {
            for (scale, radius) in [(0.1, 6e-3), (0.1, 0.5e-3), (1.0, 6e-3), (0.02, 0.1)] {
                let box_of = cuboid(cells, [1.0; 3]).unwrap();
                let (levels, why) = choose(&box_of, scale, radius);
                let side = scale / f64::from(cells);
                let left = |levels: u32| side / f64::from(1 << levels);
                let faces = 6 * (cells * cells) as usize * 4_usize.pow(levels);
                assert!(faces <= MOST_FACES, "{why}");
                let fits = left(levels) <= SIDE_SHARE * radius * (1.0 + 1e-12);
                assert!(fits || 4 * faces > MOST_FACES, "{cells} {scale} {radius}: {why}");
                assert!(levels == 0 || left(levels - 1) > SIDE_SHARE * radius, "{cells} {scale} {radius}: {why}");
            }
        }
        assert_eq!(choose(&cuboid(1, [1.0; 3]).unwrap(), 1.0, 0.0).0, 0);
    }
}
