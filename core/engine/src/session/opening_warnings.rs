//! Warnings about a scene that are found when it is opened.

use super::warning::{Extended, Extents, Warning, WarningCode};
use super::{Session, SessionError};
use crate::body::{Body, Model, Place};
use crate::scene::{BodyScene, Scene, Source};
use pliant_host::Region;
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::abi::{self, Ball};
use std::ops::Range;

impl Session {
    /// Finds the warnings, after bodies and tools have been created. `is_replaced` tells that the model of the first body was replaced.
    pub(super) fn find_opening_warnings(
        &mut self,
        scene: &Scene,
        source: &Source,
        is_replaced: bool,
    ) -> Result<(), SessionError> {
        let place = |span: Range<usize>| source.error(span, "").place();
        let mut found = Vec::new();
        let mut extended = Vec::new();
        let largest = self.tools.iter().map(|slot| slot.tool.proxy.shape.shape().length_scale()).fold(0.0, f64::max);
        let mut standing = self.standing.iter();
        let mut moving = 0;
        for (index, given) in scene.body.iter().enumerate() {
            let at = |span: &Range<usize>| if *span == (0..0) { given.material.plugin.span() } else { span.clone() };
            let of_body = place(at(&given.mesh.as_ref().map_or(given.name.span(), |mesh| mesh.span())));
            let name = given.name.get_ref().clone();
            if !self.plan.moving[index] {
                if let Some((_, model)) = standing.next() {
                    extended.push(Extended {
                        name,
                        place: of_body,
                        moving: None,
                        rest: extents(model),
                        extents: extents(model),
                        before: extents(model),
                    });
                }
                continue;
            }
            self.warnings.material_places.push(place(given.material.plugin.span()));
            let body = &self.bodies[moving];
            let extents = extents(&body.model);
            if !(is_replaced && index == 0) {
                found.extend(warn_units(given, body, largest).map(|message| Warning {
                    code: WarningCode::DoubtfulUnits,
                    place: of_body.clone(),
                    message,
                }));
            }
            found.extend(warn_openness(body).map(|message| Warning {
                code: WarningCode::OpenBody,
                place: of_body.clone(),
                message,
            }));
            if given.fibre.is_empty() && body.system.sets.iter().any(|set| set.has(abi::WANTS_DIRECTIONS)) {
                let message = format!(
                    "material `{0}` of body `{name}` takes fibre directions and the scene gives none, so it has no fibres; `[[body.fibre]]` gives them",
                    body.system.material.name()
                );
                let place = place(given.material.plugin.span());
                found.push(Warning { code: WarningCode::NoFibres, place, message });
            }
            found.extend(warn_smooth(given, body).map(|(span, message)| Warning {
                code: WarningCode::SmoothIgnored,
                place: place(span),
                message,
            }));
            found.extend(warn_mesh(body).map(|message| Warning {
                code: WarningCode::DoubtfulMesh,
                place: of_body.clone(),
                message,
            }));
            for (fixing, spanned) in body.fixings.iter().zip(&given.fixed) {
                if is_empty_selection(body, &fixing.place)? {
                    let Extents { min, max } = extents;
                    let message = format!(
                        "a `fixed` of body `{name}` holds no node; the body reaches from {:?} m to {:?} m",
                        min.as_slice(),
                        max.as_slice()
                    );
                    found.push(Warning { code: WarningCode::FixesNothing, place: place(spanned.span()), message });
                }
            }
            extended.push(Extended {
                name,
                place: of_body,
                moving: Some(moving),
                rest: extents,
                extents,
                before: extents,
            });
            moving += 1;
        }
        let crossing = self.exclude_crossing_pairs()?;
        let place_of = |body: usize| extended.iter().find(|e| e.moving == Some(body)).map_or("", |e| e.place.as_str());
        for &([i, j], count) in &crossing {
            let name = |b: usize| &self.bodies[b].name;
            let who = match i == j {
                true => format!("sheet `{}` cuts through itself", name(i)),
                false => format!("bodies `{}` and `{}` cut through each other", name(i), name(j)),
            };
            let message = format!(
                "{who} at the start: {count} edges go through triangles, so they do not meet and pass through each other; move them apart"
            );
            found.push(Warning { code: WarningCode::BodiesOverlap, place: place_of(j).to_owned(), message });
        }
        let is_handled = |i: usize, j: usize| {
            self.meetings.has_pair(i, j) || crossing.iter().any(|(bodies, _)| *bodies == [i.min(j), i.max(j)])
        };
        let (meetings, overlaps) = super::warning::OverlapDetection::new(extended, is_handled);
        self.warnings.overlaps = meetings;
        found.extend(overlaps);
        found.extend(self.find_obstacle_warnings());
        found.extend(self.find_contact_law_warnings(scene, source));
        self.warnings.opening = found;
        Ok(())
    }
}

fn extents(model: &Model) -> Extents {
    let bounds = model.surface.bounds();
    Extents { min: bounds.min, max: bounds.max }
}

/// A warning if one metre per file unit is unlikely: cells are wider than the largest tool, of radius `largest` (m), or the tool is larger than the
/// model.
fn warn_units(scene: &BodyScene, body: &Body, largest: f64) -> Option<String> {
    if scene.mesh.is_none() || scene.size.is_some() || scene.scale.is_some() || largest == 0.0 {
        return None;
    }
    let (edge, longest) = (body.discretization.edge(), body.model.surface.bounds().longest_edge());
    let is_coarse = body.discretization.lattice().is_some() && edge > 2.0 * largest;
    (is_coarse || largest > longest).then(|| {
        format!(
            "body `{}` has neither `size` nor `scale`, so a unit of the file is 1 m: it is {longest:.4} m long, its cells {edge:.4} m, and \
             the largest tool is {:.4} m wide; give `size = \"100 mm\"`, or `scale = 0.001` for a file in mm",
            body.name,
            2.0 * largest
        )
    })
}

/// A warning if a body other than a sheet has triangles that bound no volume, for cuts.
fn warn_openness(body: &Body) -> Option<String> {
    let mesh = body.cut.as_ref().filter(|_| body.discretization.lattice().is_some())?;
    let (open, border) = (mesh.open_triangles(), mesh.border_edges());
    (open > 0).then(|| {
        format!(
            "body `{}` is not closed: {open} of its triangles bound no volume and have {border} border edges; a blade cuts them as a sheet, \
             without a cut surface inside; close the holes, or make it a `sheet`",
            body.name
        )
    })
}

/// A warning if the scene asks for continuous slopes of a body whose material can fail, with the place of the request.
fn warn_smooth(scene: &BodyScene, body: &Body) -> Option<(Range<usize>, String)> {
    let asked = scene.grid.get_ref().smooth.as_ref().filter(|smooth| *smooth.get_ref())?;
    let can_fail = body.system.sets.iter().any(|set| set.has(abi::CAN_FAIL));
    can_fail.then(|| {
        let material = body.system.material.name();
        let message = format!(
            "`smooth = true` has no effect on body `{}`: its material `{material}` can fail, and slopes would be continued across cracks, so its surface follows the \
             trilinear weights of the cells; leave `smooth` out, or give it another material",
            body.name
        );
        (asked.span(), message)
    })
}

/// A warning for what a user of a tetrahedral mesh may not expect of it.
fn warn_mesh(body: &Body) -> Option<String> {
    let mesh = body.model.tetrahedra.as_ref()?.mesh();
    let notes: Vec<String> = mesh.notes.iter().filter(|note| note.is_doubtful()).map(ToString::to_string).collect();
    (!notes.is_empty()).then(|| format!("body `{}`: {}: {}", body.name, mesh.name().display(), notes.join("; ")))
}

/// Whether a selection contains no node of a body.
fn is_empty_selection(body: &Body, place: &Place) -> Result<bool, SessionError> {
    let Some(lattice) = body.discretization.lattice() else {
        let points = body.model.surface.points.iter().enumerate();
        return Ok(!points.into_iter().any(|(node, rest)| place.contains(node as u32, *rest)));
    };
    let ball = match place {
        Place::Box { min, max } => Ball { centre: (0.5 * (min + max)).into(), radius: 0.5 * (max - min).norm() },
        Place::Ball { centre, radius } => Ball { centre: (*centre).into(), radius: *radius },
        Place::Cells(corners) if corners.is_empty() => return Ok(true),
        Place::Cells(_) | Place::Nodes(_) | Place::Vertices(_) => Ball { centre: [0.0; 3], radius: f64::INFINITY },
    };
    let mut near = Region::default();
    let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
    let asked = lattice.source.region(lattice.settings.level, 0, &[ball], &[], &mut near);
    asked.map_err(|error| of_body(error.into()))?;
    let rest = near.node_rest.iter().enumerate();
    Ok(!rest.into_iter().any(|(node, rest)| place.contains(node as u32, Vec3::from(*rest))))
}
