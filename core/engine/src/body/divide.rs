//! Division of a body: each of its parts becomes a body of its own, as after a cut right through it.
//!
//! Each part keeps the vertices of the whole with their numbers, so that nothing that is known of a vertex has to be moved: rest shape, pins, fixings by
//! vertex, where it is embedded. It has its own triangles and its own nodes and elements, with positions, velocities and histories. A solid keeps the cells of
//! the whole: its grid is built once more around the same surface, and what is in other parts counts as outside.

use super::fixing::{Fixing, Place};
use super::lattice::{LatticeComponents, LatticePart, PartCells};
use super::sheet::SheetPart;
use super::state::DiscretizationState;
use super::{Body, BodyState, Discretization, FailedTriangles, LatticeError, Samples, Skin};
use pliant_cut::{CutMesh, MeshPart, PartError};
use pliant_host::HostError;
use pliant_mesh::DisjointSets;
use pliant_mesh::Surface;
use pliant_solver::System;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use thiserror::Error;

/// Which bodies a body is divided into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// One for each part, the largest first.
    EachPart,
    /// What is left, and the part with this triangle.
    PartOf(u32),
}

/// Why a body is not divided. It is as it was.
#[derive(Debug, Error)]
pub enum DivideError {
    /// The body is in one part.
    #[error(
        "it is in one part; allowed is a body that a cut has gone right through, or with several parts from the start"
    )]
    OnePart,
    /// The surface is in several parts and the grid is not.
    #[error(
        "its surface is in {shells} parts, which cells of its grid still hold together, as where a part is thinner than half a cell beside the cut, or lies in \
         several of the others; allowed is a cut that is farther inside or goes through all of them, or a grid of a higher `level`"
    )]
    HeldByGrid {
        /// Number of parts of the surface.
        shells: u32,
    },
    /// The body is simulated on a tetrahedral mesh of a file.
    #[error("it is a tetrahedral mesh of a file, which cannot be divided; allowed is a solid in a grid or a sheet")]
    Tetrahedra,
    /// The material has failed somewhere: what hangs together follows from histories there.
    #[error("{elements} of its elements have failed; allowed is a body without failed elements")]
    Failed {
        /// Number of elements that have failed.
        elements: usize,
    },
    /// The triangle is not there or not drawn.
    #[error("it has no triangle {triangle}; allowed is the number of a triangle of its surface, below {count}")]
    NoTriangle {
        /// The number that was given.
        triangle: u32,
        /// Number of triangles.
        count: usize,
    },
    /// A part is no model of its own.
    #[error(transparent)]
    Document(#[from] PartError),
    /// A plugin refused.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

impl From<HostError> for DivideError {
    fn from(error: HostError) -> Self {
        Self::Lattice(error.into())
    }
}

/// The parts of a body.
struct BodyParts {
    /// Part of each triangle (t).
    of_triangle: Vec<u32>,
    /// Part of each vertex, or `u32::MAX` for one without triangles (n).
    of_vertex: Vec<u32>,
    /// The cells of a solid.
    cells: Option<CellParts>,
    /// Number of parts.
    count: u32,
    /// Number of connected parts of the surface, which a grid may hold together.
    shells: u32,
}

/// The parts of a lattice, by its connected components.
struct CellParts {
    components: LatticeComponents,
    /// Part of each component.
    of_component: Vec<u32>,
}

impl Body {
    /// The bodies that this one is divided into, each with its state; `cap_material` names the group and material of faces that cuts have made. Active edits must
    /// have ended.
    ///
    /// # Errors
    /// A body that cannot be divided, and errors of plugins.
    pub fn divided(&mut self, division: Division, cap_material: &str) -> Result<Vec<Self>, DivideError> {
        if self.model.tetrahedra.is_some() {
            return Err(DivideError::Tetrahedra);
        }
        let elements = self.system.failed_count();
        if elements > 0 {
            return Err(DivideError::Failed { elements });
        }
        let outdated = self.discretization.lattice().filter(|lattice| lattice.is_outdated());
        if let Some(balls) = outdated.map(super::Lattice::present_balls) {
            let Self { model, skin, system, discretization, fixings, .. } = self;
            discretization.follow(&balls, model, fixings, skin, system)?;
        }
        let parts = self.find_parts(division)?;
        if parts.count < 2 {
            let shells = parts.shells;
            return Err(if shells < 2 { DivideError::OnePart } else { DivideError::HeldByGrid { shells } });
        }
        let own_mesh;
        let mesh = match &self.cut {
            Some(mesh) => mesh,
            None => {
                let surface = self.model.surface.clone();
                let (document, is_sheet) = (&self.model.document, self.discretization.sheet().is_some());
                own_mesh = Box::new(CutMesh::of_surface(document, surface, &self.model.placement, is_sheet));
                &own_mesh
            }
        };
        let around = match self.discretization.lattice().map(super::Lattice::built_around) {
            Some(Some(around)) => Arc::clone(around),
            _ => Arc::new(Surface::from_document(&self.model.document).placed(&self.model.placement)),
        };
        (0..parts.count).map(|part| self.part(&parts, part, mesh, &around, cap_material)).collect()
    }

    /// Finds the parts: what is connected by triangles, by stitches, or by the cells of a solid.
    fn find_parts(&self, division: Division) -> Result<BodyParts, DivideError> {
        let surface = &self.model.surface;
        let shells = surface.joined_shells(&self.joined_vertices(), |_| false);
        let count = shells.iter().max().map_or(0, |last| last + 1);
        let vertices = surface.points.len();
        let components = self.discretization.lattice().map(|lattice| lattice.components(vertices)).transpose()?;
        let mut sets = DisjointSets::new((count + components.as_ref().map_or(0, |of| of.count)) as usize);
        if let Some(components) = &components {
            for (corners, shell) in surface.triangles.iter().zip(&shells) {
                let of = corners.iter().map(|v| components.of_vertex[*v as usize]);
                of.filter(|of| *of < components.count).for_each(|of| sets.unite(*shell, count + of));
            }
        }
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| surface.points[v as usize]);
            (b - a).cross(&(c - a)).norm()
        };
        let roots: Vec<u32> = shells.iter().map(|shell| sets.find(*shell)).collect();
        let mut areas: HashMap<u32, (f64, usize)> = HashMap::new();
        for (triangle, (corners, root)) in surface.triangles.iter().zip(&roots).enumerate() {
            areas.entry(*root).or_insert((0.0, triangle)).0 += area(corners);
        }
        let mut order: Vec<(u32, (f64, usize))> = areas.into_iter().collect();
        order.sort_by(|(_, (a, first)), (_, (b, second))| b.total_cmp(a).then(first.cmp(second)));
        let mut number: HashMap<u32, u32> = order.iter().zip(0..).map(|((root, _), part)| (*root, part)).collect();
        let mut parts = order.len() as u32;
        if let Division::PartOf(triangle) = division {
            let drawn = (triangle as usize) < roots.len() && !self.model.is_lid(triangle);
            let count = roots.len();
            let chosen =
                *roots.get(triangle as usize).filter(|_| drawn).ok_or(DivideError::NoTriangle { triangle, count })?;
            number.iter_mut().for_each(|(root, part)| *part = u32::from(*root == chosen));
            parts = parts.min(2);
        }
        let of_triangle: Vec<u32> = roots.iter().map(|root| number[root]).collect();
        let mut of_vertex = vec![u32::MAX; vertices];
        for (corners, part) in surface.triangles.iter().zip(&of_triangle) {
            corners.iter().for_each(|v| of_vertex[*v as usize] = *part);
        }
        // Cells without surface stay with the largest part.
        let part_of = |of: u32, sets: &mut DisjointSets| number.get(&sets.find(count + of)).copied().unwrap_or(0);
        let cells = components.map(|components| CellParts {
            of_component: (0..components.count).map(|of| part_of(of, &mut sets)).collect(),
            components,
        });
        Ok(BodyParts { of_triangle, of_vertex, cells, count: parts, shells: count })
    }

    /// The body of a part.
    fn part(
        &self,
        parts: &BodyParts,
        part: u32,
        mesh: &CutMesh,
        around: &Arc<Surface>,
        cap_material: &str,
    ) -> Result<Self, DivideError> {
        let owned = |triangle: u32| parts.of_triangle[triangle as usize] == part;
        let owns = |vertex: u32| parts.of_vertex[vertex as usize] == part;
        let MeshPart { document, surface, triangle } = mesh.part(&self.model.document, owned, cap_material)?;
        let faces = triangle.iter().zip(&surface.face_of);
        let is_cap = |of: u32| mesh.is_cap(of) || self.model.is_cap_face(mesh.surface().face_of[of as usize]);
        let caps: HashSet<u32> = faces.filter(|(of, _)| is_cap(**of)).map(|(_, face)| *face).collect();
        let cut = self.cut.as_ref().map(|_| {
            let is_sheet = self.discretization.sheet().is_some();
            Box::new(CutMesh::of_surface(&document, surface.clone(), &self.model.placement, is_sheet))
        });
        let mut model = self.model.of_part(document, surface, caps);
        let count = model.surface.triangles.len().max(self.model.surface.triangles.len());
        model.pages.mark_all(count);
        let new_triangle: HashMap<u32, u32> = triangle.iter().copied().zip(0..).collect();
        let saved = self.save();
        let (discretization, state, node_number) = match &self.discretization {
            Discretization::Lattice(lattice) => {
                let cells = parts.cells.as_ref().ok_or(DivideError::OnePart)?;
                let own = PartCells::new(lattice, &cells.components, |of| cells.of_component[of as usize] == part);
                let made = lattice.part(&own, around, owns)?.ok_or(DivideError::Tetrahedra)?;
                let LatticePart { lattice, state, node_number } = made;
                (Discretization::Lattice(Box::new(lattice)), DiscretizationState::Lattice(Box::new(state)), node_number)
            }
            Discretization::Sheet(sheet) => {
                let SheetPart { sheet, state, node_number } =
                    sheet.part(&self.model, owns, |t| new_triangle.get(&t).copied());
                (Discretization::Sheet(Box::new(sheet)), DiscretizationState::Sheet(state), node_number)
            }
        };
        let kept: Vec<u32> = (0..node_number.len() as u32).filter(|n| node_number[*n as usize] != u32::MAX).collect();
        let nodes = self.system.nodes.select(&kept);
        let history = self.system.sets.iter().map(|set| history_of_part(set, &node_number)).collect();
        let state = BodyState { nodes, history, discretization: state, cuts: 0, ..saved };
        let tree = Arc::new(model.tree());
        let mut skin = Skin::new(&model, tree);
        skin.pages.clone_from(&self.skin.pages);
        let mut body = Self {
            name: self.name.clone(),
            number: self.number,
            model: Arc::new(model),
            cut,
            cut_margins: self.cut_margins.clone(),
            skin,
            system: System::new(Box::new(self.recipe.open()?)),
            recipe: Arc::clone(&self.recipe),
            discretization,
            samples: Arc::default(),
            layer_stiffness: self.layer_stiffness,
            layer_mass: self.layer_mass,
            params: self.params.clone(),
            most_stiffening: self.most_stiffening,
            failed_triangles: FailedTriangles::default(),
            tints: Default::default(),
            fixings: fixings_of_part(self, &node_number),
            symmetry: None,
            frozen: None,
        };
        if self.system.matrix.is_some() {
            body.system.enable_matrix();
        }
        body.restore(&state)?;
        // Vertices of other parts stay where they are at rest.
        let places = body.skin.x.iter_mut().zip(&self.skin.x).zip(&parts.of_vertex);
        places.filter(|(_, of)| **of == part).for_each(|((x, now), _)| *x = *now);
        body.skin.pages.mark_all(body.skin.x.len());
        if !self.samples.is_empty()
            && let Some(lattice) = body.discretization.lattice()
        {
            let mut samples = Samples::new(&drawn(&body.model), lattice)?;
            let cells: Vec<u64> = lattice.cut_cells().collect();
            samples.take_cut(&cells, &body.model, &body.skin, lattice)?;
            body.samples = Arc::new(samples);
        }
        Ok(body)
    }
}

/// The surface of a model without lids, which nothing touches.
fn drawn(model: &super::Model) -> Surface {
    let surface = &model.surface;
    let seen = (0..surface.triangles.len()).filter(|t| !model.is_lid(*t as u32));
    let (triangles, face_of) = seen.map(|t| (surface.triangles[t], surface.face_of[t])).unzip();
    Surface { points: surface.points.clone(), triangles, face_of }
}

/// History variables of the elements of a part: those whose nodes all have a new number.
fn history_of_part(set: &pliant_solver::ElementSet, node_number: &[u32]) -> Vec<f64> {
    let count = set.count();
    if count == 0 || set.history().is_empty() {
        return Vec::new();
    }
    let stencils = set.nodes().chunks_exact(set.stencil());
    let is_kept: Vec<bool> = stencils
        .flat_map(|nodes| {
            let kept = nodes.iter().all(|node| node_number[*node as usize] != u32::MAX);
            std::iter::repeat_n(kept, set.parts())
        })
        .collect();
    let planes = set.history().chunks_exact(count);
    planes.flat_map(|plane| plane.iter().zip(&is_kept).filter(|(_, kept)| **kept).map(|(value, _)| *value)).collect()
}

/// The fixings of a part. Nodes of a lattice that are held by their numbers have others in it; vertices keep theirs.
fn fixings_of_part(body: &Body, node_number: &[u32]) -> Vec<Fixing> {
    let is_lattice = body.discretization.lattice().is_some();
    let of_part = |fixing: &Fixing| match &fixing.place {
        Place::Nodes(list) if is_lattice => {
            let new = list.iter().filter_map(|node| node_number.get(*node as usize).copied());
            Fixing { place: Place::Nodes(new.filter(|node| *node != u32::MAX).collect()), ..fixing.clone() }
        }
        Place::Box { .. } | Place::Ball { .. } | Place::Nodes(_) | Place::Vertices(_) | Place::Cells(_) => {
            fixing.clone()
        }
    };
    body.fixings.iter().map(of_part).collect()
}
