//! `final.obj`: the model of each body as the run has left it.

use super::{FileNames, Output, OutputFolder, OutputKind};
use crate::atomic::error_at;
use crate::model::write_model_to;
use pliant_engine::body::{Body, Model};
use pliant_engine::session::{Session, Warning};
use std::io::{self, Write};

/// Models at the end: `final.obj`, or with several models `final-NAME.obj`.
pub(super) static MODELS: OutputKind = OutputKind {
    names: FileNames::Many { folder: "", start: "final", end: ".obj" },
    replaces: |session, _| model_files(session).map(|(name, _)| name).collect(),
    begin: |_| Ok(Some(Box::new(Models))),
};

/// Writes models at the end.
struct Models;

impl Output for Models {
    fn finish(self: Box<Self>, session: &Session, folder: &OutputFolder) -> io::Result<Option<Warning>> {
        for (name, source) in model_files(session) {
            let mut file = folder.create(&name)?;
            match source {
                ModelSource::Body(body) => write_model_to(body, &session.plan().cap_material, &mut file)
                    .map_err(|error| error_at(&folder.final_path(&name), error))?,
                ModelSource::Standing(model) => file.write_all(model.document.bytes())?,
            }
            file.finish()?;
        }
        Ok(None)
    }
}

/// Content of the file of a model.
enum ModelSource<'a> {
    /// A body with its deformed surface.
    Body(&'a Body),
    /// A model that is not simulated.
    Standing(&'a Model),
}

/// Whether the session has a single model.
pub(super) fn has_one_model(session: &Session) -> bool {
    session.bodies.len() + session.standing.len() == 1
}

/// The file name of a model, without an ending.
fn stem(session: &Session, name: &str) -> String {
    if has_one_model(session) { "final".to_owned() } else { format!("final-{name}") }
}

/// The file name of each body, without an ending, and the body.
pub(super) fn body_files(session: &Session) -> impl Iterator<Item = (String, &Body)> {
    session.bodies.iter().map(|body| (stem(session, &body.name), body))
}

/// The file name of each model and its content.
fn model_files(session: &Session) -> impl Iterator<Item = (String, ModelSource<'_>)> {
    let bodies = body_files(session).map(|(stem, body)| (stem, ModelSource::Body(body)));
    let standing = session.standing.iter();
    let standing = standing.map(|(name, model)| (stem(session, name), ModelSource::Standing(model)));
    bodies.chain(standing).map(|(stem, source)| (format!("{stem}.obj"), source))
}
