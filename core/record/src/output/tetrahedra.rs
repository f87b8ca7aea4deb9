//! `final.vtk`: the tetrahedral mesh of each body that was opened from one, as the run has left it.

use super::models::body_files;
use super::{FileNames, Output, OutputFolder, OutputKind};
use crate::atomic::error_at;
use crate::model::write_tetrahedra_to;
use pliant_engine::body::Body;
use pliant_engine::session::{Session, Warning};
use std::io;

/// Tetrahedral meshes at the end: `final.vtk`, or with several models `final-NAME.vtk`.
pub(super) static TETRAHEDRA: OutputKind = OutputKind {
    names: FileNames::Many { folder: "", start: "final", end: ".vtk" },
    replaces: |session, _| tetrahedra_files(session).map(|(name, _)| name).collect(),
    begin: |_| Ok(Some(Box::new(Tetrahedra))),
};

/// Writes tetrahedral meshes at the end.
struct Tetrahedra;

impl Output for Tetrahedra {
    fn finish(self: Box<Self>, session: &Session, folder: &OutputFolder) -> io::Result<Option<Warning>> {
        for (name, body) in tetrahedra_files(session) {
            let mut file = folder.create(&name)?;
            write_tetrahedra_to(body, &mut file).map_err(|error| error_at(&folder.final_path(&name), error))?;
            file.finish()?;
        }
        Ok(None)
    }
}

/// The file name of each tetrahedral mesh, and its body.
fn tetrahedra_files(session: &Session) -> impl Iterator<Item = (String, &Body)> {
    let bodies = body_files(session).filter(|(_, body)| body.model.tetrahedra.is_some());
    bodies.map(|(stem, body)| (format!("{stem}.vtk"), body))
}
