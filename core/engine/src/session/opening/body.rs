//! Opening of a body: its material, and the sheet or lattice that carries it.

use super::Opening;
use super::plugins::span_of;
use crate::body::{Body, Discretization, FailedTriangles, Lattice, MaterialRecipe, Sheet, Skin, StiffnessFactor};
use crate::scene::{BodyScene, EditScene};
use crate::session::fixings::FixedBody;
use crate::session::shared::SharedModel;
use crate::session::{SessionError, fibres, fields, place};
use pliant_cut::CutMesh;
use pliant_host::{Material, PluginKind};
use pliant_mesh::require_for_mesh_elements;
use pliant_solver::System;
use std::sync::Arc;

/// Parameter of materials that is a factor of all their stiffness.
const STIFFNESS: &str = "young";

impl Opening<'_> {
    /// Opens the body `index` of the scene; `cuts` says whether any of the `edits` of the scene cuts.
    pub(super) fn body(
        &mut self,
        scene: &BodyScene,
        index: usize,
        name: String,
        shared: SharedModel,
        edits: &[EditScene],
        cuts: bool,
    ) -> Result<Body, SessionError> {
        let (library, info, settings) =
            self.plugin(PluginKind::Material, &scene.material.plugin, &scene.material.params)?;
        let material_key = format!("{} {} {settings:?}", library.path().display(), info.id);
        let material = Material::open(library, &info.id, &settings, self.dt).map_err(|error| {
            let material = &scene.material;
            self.refused(span_of(&error, &material.params, material.plugin.span()), error)
        })?;
        let model = Arc::clone(&shared.model);
        fields::check_paint_range(edits, self.source, info, &settings)?;
        let fields = fields::fields(scene, self.source, info, &settings, &shared)?;
        let fibres = fibres::fibres(scene, self.source, &material, &shared)?;
        let files = scene.field.iter().filter_map(|field| field.get_ref().file());
        let files = files.filter(|file| !self.source.factors.contains_key(file.get_ref()));
        let files = files.chain(scene.fibre.iter().filter_map(|fibre| fibre.get_ref().csv.as_ref()));
        let files = files.chain(scene.fixed.iter().filter_map(|fixed| fixed.get_ref().texture.as_ref()));
        self.inputs.field_files.extend(files.map(|file| self.source.folder().join(file.get_ref())));
        let mut discretization = match &scene.sheet {
            Some(sheet) => {
                let of_mesh = |error| place::of_mesh(scene, &model.document, error);
                require_for_mesh_elements(&model.findings).map_err(of_mesh)?;
                self.check_sheet(scene, index, model.surface.triangles.len())?;
                Discretization::Sheet(Box::new(Sheet::new(&model, place::warp(sheet.get_ref()))))
            }
            None => Discretization::Lattice(Box::new(match shared.model.tetrahedra.clone() {
                Some(cells) => self.tetrahedra(scene, index, &shared, cells, &material)?,
                None => self.lattice(scene, index, &shared, &material)?,
            })),
        };
        let plane = info.fields().position(|param| param.key == STIFFNESS);
        let params = info.fields().map(|param| param.key.clone()).collect();
        let stiffness = plane.map(|plane| StiffnessFactor::new(plane, info.fields().count()));
        match &mut discretization {
            Discretization::Lattice(lattice) => {
                (lattice.fields, lattice.fibres, lattice.stiffness) = (fields, fibres, stiffness);
            }
            Discretization::Sheet(sheet) => (sheet.fields, sheet.stiffness) = (fields, stiffness),
        }
        let made = if scene.sheet.is_some() { CutMesh::sheet } else { CutMesh::new };
        let recipe = MaterialRecipe { library, id: info.id.clone(), settings: settings.clone(), dt: self.dt };
        let measured_key = |lattice: &Lattice| {
            let settings = &lattice.settings;
            format!("{} {settings:?} {material_key} {:?} {:?}", lattice.key, scene.field, scene.fibre)
        };
        self.measured_keys.push(discretization.lattice().map(measured_key).unwrap_or_default());
        let skin = Skin::new(&model, shared.tree);
        let fixed = FixedBody { source: self.source, model: &model, discretization: &discretization };
        let fixings = scene.fixed.iter().map(|entry| fixed.fixing(entry)).collect::<Result<_, _>>()?;
        let seams = self.seams(scene, &model, &discretization)?;
        self.seams.push(seams);
        Ok(Body {
            name,
            number: self.seams.len() as u32 - 1,
            cut_margins: std::collections::HashMap::default(),
            cut: cuts.then(|| Box::new(made(&model.document, &model.placement))),
            model,
            skin,
            system: System::new(Box::new(material)),
            recipe: Arc::new(recipe),
            discretization,
            samples: Arc::default(),
            layer_stiffness: 0.0,
            layer_mass: 0.0,
            params,
            tints: Default::default(),
            failed_triangles: FailedTriangles::default(),
            most_stiffening: f64::INFINITY,
            fixings,
            symmetry: None,
            frozen: None,
        })
    }
}
