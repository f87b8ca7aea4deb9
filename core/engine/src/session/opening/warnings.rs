//! Warnings about a scene that are found when it is opened.

use crate::body::{Body, Model, Place};
use crate::scene::{BodyScene, Scene, Source};
use crate::session::overlap::{Extended, Extents, OverlapDetection};
use crate::session::warning::{Warning, WarningCode};
use crate::session::{Session, SessionError};
use pliant_host::Region;
use pliant_mesh::check::Kind;
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
        let mut found = Vec::new();
        let mut extended = Vec::new();
        let largest = self.tools.iter().map(|slot| slot.tool.proxy.shape.shape().length_scale()).fold(0.0, f64::max);
        let mut standing = self.standing.iter();
        let mut moving = 0;
        for (index, given) in scene.body.iter().enumerate() {
            let mut extend = |moving: Option<usize>, extents: Extents| {
                let (name, place) = (given.name.get_ref().clone(), place_of_body(given, source));
                extended.push(Extended { name, place, moving, rest: extents, extents, before: extents });
            };
            if self.plan.moving[index] {
                let body = &self.bodies[moving];
                let tool_radius = (!(is_replaced && index == 0)).then_some(largest);
                self.warnings.material_places.push(place(source, given.material.plugin.span()));
                found.extend(warn_body(body, given, source, tool_radius)?);
                extend(Some(moving), extents(&body.model));
                moving += 1;
            } else if let Some((_, model)) = standing.next() {
                extend(None, extents(model));
            }
        }
        let crossing = self.interactions.body_contacts.exclude_crossing_pairs(&mut self.bodies)?;
        let place_of = |body: usize| extended.iter().find(|e| e.moving == Some(body)).map_or("", |e| e.place.as_str());
        found.extend(crossing.iter().map(|&(pair, count)| self.crossing_warning(pair, count, place_of(pair[1]))));
        let handled = self.interactions.body_contacts.pairs().chain(crossing.iter().map(|(bodies, _)| *bodies));
        let mut tied = Vec::new();
        self.interactions.ties.find_pairs(&self.bodies, &mut tied);
        let is_tied = |pair: [usize; 2]| tied.binary_search(&pair).is_ok();
        let (detection, overlaps) = OverlapDetection::new(extended, handled, is_tied);
        self.warnings.overlaps = detection;
        found.extend(overlaps);
        found.extend(self.interactions.obstacles.opening_warnings(&self.bodies));
        found.extend(self.find_contact_law_warnings(scene, source));
        found.extend(self.find_radius_warnings());
        self.warnings.opening = found;
        Ok(())
    }

    /// The warning that two bodies, or a sheet and itself, cut through each other at the start; `count` edges go through triangles.
    fn crossing_warning(&self, [i, j]: [usize; 2], count: usize, place: &str) -> Warning {
        let name = |b: usize| &self.bodies[b].name;
        let who = match i == j {
            true => format!("sheet `{}` cuts through itself", name(i)),
            false => format!("bodies `{}` and `{}` cut through each other", name(i), name(j)),
        };
        let message = format!(
            "{who} at the start: {count} edges go through triangles, so they do not meet and pass through each other; move them apart"
        );
        Warning { code: WarningCode::BodiesOverlap, place: place.to_owned(), message }
    }
}

/// File, line and column of a place in the scene.
fn place(source: &Source, span: Range<usize>) -> String {
    source.error(span, "").place()
}

/// Where the scene gives a body: at its mesh, else its name, else its material.
fn place_of_body(given: &BodyScene, source: &Source) -> String {
    let span = given.mesh.as_ref().map_or(given.name.span(), |mesh| mesh.span());
    place(source, if span == (0..0) { given.material.plugin.span() } else { span })
}

/// Warnings about a moving body. `tool_radius` (m) is that of the largest tool, if the units of the model are to be doubted.
fn warn_body(
    body: &Body,
    given: &BodyScene,
    source: &Source,
    tool_radius: Option<f64>,
) -> Result<Vec<Warning>, SessionError> {
    let of_body = place_of_body(given, source);
    let mut found = Vec::new();
    let mut add = |code: WarningCode, place: String, message: Option<String>| {
        found.extend(message.map(|message| Warning { code, place, message }));
    };
    let units = tool_radius.and_then(|largest| warn_units(given, body, largest));
    add(WarningCode::DoubtfulUnits, of_body.clone(), units);
    add(WarningCode::CoincidentBorders, of_body.clone(), warn_coincident_borders(given, body));
    add(WarningCode::OpenBody, of_body.clone(), warn_openness(body));
    add(WarningCode::NoFibres, place(source, given.material.plugin.span()), warn_fibres(given, body));
    if let Some((span, message)) = warn_smooth(given, body) {
        add(WarningCode::SmoothIgnored, place(source, span), Some(message));
    }
    add(WarningCode::DoubtfulMesh, of_body, warn_mesh(body));
    for (fixing, spanned) in body.fixings.iter().zip(&given.fixed) {
        if is_empty_selection(body, &fixing.place)? {
            let (name, Extents { min, max }) = (&body.name, extents(&body.model));
            let message = format!(
                "a `fixed` of body `{name}` holds no node; the body reaches from {:?} m to {:?} m",
                min.as_slice(),
                max.as_slice()
            );
            add(WarningCode::FixesNothing, place(source, spanned.span()), Some(message));
        }
    }
    Ok(found)
}

/// A warning if the body falls apart along borders that lie together, of which the scene does not say whether they are welded or stitched.
fn warn_coincident_borders(given: &BodyScene, body: &Body) -> Option<String> {
    let model = &body.model;
    let is_open = model.findings.iter().any(|finding| finding.kind == Kind::Border);
    let is_told = given.weld.is_some() || !given.stitch.is_empty() || model.document.has_cut_borders();
    if is_told || !is_open || model.tetrahedra.is_some() {
        return None;
    }
    let count = model.document.coincident_borders(&model.surface, 0.0).len();
    (count > 0).then(|| {
        format!(
            "{count} vertices on borders of body `{}` lie exactly where others do and are not joined to them, so that it is in pieces there; \
             `weld = true` joins them, `weld = false` leaves them and this warning out",
            body.name
        )
    })
}

/// A warning if the material takes fibre directions and the scene gives none.
fn warn_fibres(given: &BodyScene, body: &Body) -> Option<String> {
    let is_without = given.fibre.is_empty() && body.system.sets.iter().any(|set| set.has(abi::WANTS_DIRECTIONS));
    is_without.then(|| {
        format!(
            "material `{0}` of body `{1}` takes fibre directions and the scene gives none, so it has no fibres; `[[body.fibre]]` gives them",
            body.system.material.name(),
            body.name
        )
    })
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
