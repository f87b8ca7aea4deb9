//! `final-part-1.obj` and on: the parts that cuts have left of each model, as files of their own.

use super::models::body_files;
use super::{FileNames, Output, OutputFolder, OutputKind};
use crate::atomic::error_at;
use crate::model::{ModelShape, NO_ROW, WrittenModel};
use pliant_engine::body::Body;
use pliant_engine::scene::PartsScene;
use pliant_engine::session::{Session, Warning, WarningCode};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{ObjDocument, Surface};
use std::io;
use std::path::Path;

/// What stands between the name of a model and the number of its part.
const PART: &str = "-part-";

/// Parts of models that are in several, if the scene asks for them.
pub(super) static PARTS: OutputKind = OutputKind {
    names: FileNames::Many { folder: "", start: "final", end: ".obj" },
    replaces: |_, folder| part_names(folder).collect(),
    begin: |request| {
        let parts = &request.scene.output.parts;
        let place = || request.source.error(parts.span(), "").place();
        Ok(match parts.get_ref() {
            PartsScene::Together => None,
            PartsScene::Files => Some(Box::new(Parts { asked_at: place() })),
        })
    },
};

/// Writes parts at the end.
struct Parts {
    /// Where in the scene they are asked for.
    asked_at: String,
}

impl Output for Parts {
    fn finish(self: Box<Self>, session: &Session, folder: &OutputFolder) -> io::Result<Option<Warning>> {
        let mut is_split = false;
        for (stem, body) in body_files(session) {
            let shown = folder.final_path(&format!("{stem}.obj"));
            let parts =
                ModelParts::of(body, &session.plan().cap_material, &shown).map_err(|error| error_at(&shown, error))?;
            for part in (0..parts.count()).filter(|_| parts.count() > 1) {
                is_split = true;
                let mut file = folder.create(&format!("{stem}{PART}{}.obj", part + 1))?;
                parts.write(part, &mut file)?;
                file.finish()?;
            }
        }
        let message = "`parts = \"files\"`, and every model is in one part: there are no files of parts; cut through a model, or leave it out";
        let warning = || Warning { code: WarningCode::OnePart, place: self.asked_at, message: message.into() };
        Ok((!is_split).then(warning))
    }
}

/// Names of files of parts in a folder, from a run before.
fn part_names(folder: &Path) -> impl Iterator<Item = String> {
    let names =
        std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| name.starts_with("final") && name.contains(PART))
}

/// A model in connected parts: faces of a part share vertices or are stitched, faces of two parts are not.
struct ModelParts {
    /// The whole model, as its own file has it.
    document: ObjDocument,
    /// Part of each face (f), counted in the order of their first faces.
    part_of: Vec<u32>,
}

impl ModelParts {
    /// The parts of a body as it is now. Faces that a cut has made get the material `cap_material`; `name` is the file of the whole.
    ///
    /// # Errors
    /// Those of [`ModelShape::write`].
    fn of(body: &Body, cap_material: &str, name: &Path) -> io::Result<Self> {
        let WrittenModel { bytes, row_of } = ModelShape::of(body).written(cap_material)?;
        let mut document = ObjDocument::parse(bytes, name).map_err(io::Error::other)?;
        let welds = body.model.document.welds().iter().map(|pair| pair.map(|vertex| row_of[vertex as usize]));
        document.weld(&welds.filter(|pair| !pair.contains(&NO_ROW)).collect::<Vec<_>>());
        let mut surface = Surface::from_document(&document);
        // Vertices that the file does not have follow its rows: a stitch may hold two faces together by such a vertex.
        let rows = surface.points.len();
        surface.points.resize(rows + row_of.len(), Vec3::zeros());
        let row = |vertex: u32| match row_of[vertex as usize] {
            NO_ROW => rows as u32 + vertex,
            row => row,
        };
        let joined: Vec<_> = body.joined_vertices().into_iter().map(|pair| pair.map(row)).collect();
        let mut part_of = vec![0; document.face_count()];
        let shells = surface.joined_shells(&joined, |_| false);
        surface.face_of.iter().zip(shells).for_each(|(face, part)| part_of[*face as usize] = part);
        Ok(Self { document, part_of })
    }

    /// Number of parts, at least 1.
    fn count(&self) -> u32 {
        self.part_of.iter().max().map_or(1, |last| last + 1)
    }

    /// Writes a part by its number.
    ///
    /// # Errors
    /// What `out` says.
    fn write(&self, part: u32, out: &mut impl io::Write) -> io::Result<()> {
        let is_kept: Vec<bool> = self.part_of.iter().map(|of| *of == part).collect();
        self.document.write_faces(&is_kept, out)
    }
}
