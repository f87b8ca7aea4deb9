//! Plugins of a scene that is being opened: found, allowed, with checked parameters.

use super::Opening;
use crate::scene::{PluginScene, settings};
use crate::session::{Loaded, SessionError};
use pliant_host::{ContactLaw, HostError, Library, ParamKind, ParamSettings, ParamValue, PluginInfo, PluginKind};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;

/// Parameters of a plugin as a scene gives them, by key.
pub(super) type Given = BTreeMap<String, Spanned<toml::Value>>;

impl Opening<'_> {
    /// Finds a plugin, checks its parameters and records its file.
    pub(in crate::session) fn plugin(
        &mut self,
        kind: PluginKind,
        name: &Spanned<String>,
        given: &Given,
    ) -> Result<(&'static Library, &'static PluginInfo, ParamSettings), SessionError> {
        let (file, id, id_given) = match name.get_ref().split_once('#') {
            Some((file, id)) => (file, id, true),
            None => (name.get_ref().as_str(), name.get_ref().as_str(), false),
        };
        let search = &self.options.search;
        let found = search.find(file, self.source.folder()).map_err(|error| self.refused(name.span(), error))?;
        let library = Library::open(&found.path)?;
        let id = if id.contains(['/', '\\']) { found.name.as_str() } else { id };
        let only = || if id_given { None } else { library.only_plugin(kind) };
        let info = library.plugin(kind, id).or_else(|error| only().ok_or(error))?;
        let settings = settings(self.source, info, given)?;
        self.check_libraries(info, &settings, given)?;
        let path = library.path().display().to_string();
        if !self.inputs.loaded.iter().any(|l| l.path == path && l.id == info.id) {
            let (kind, id, version) = (kind.name(), info.id.clone(), info.version.clone());
            self.inputs.loaded.push(Loaded { kind, id, version, path });
        }
        Ok((library, info, settings))
    }

    /// Checks that no parameter names a library that the caller does not allow.
    fn check_libraries(&self, info: &PluginInfo, settings: &ParamSettings, given: &Given) -> Result<(), SessionError> {
        for (index, value) in settings {
            let param = &info.params[*index];
            // Text parameters are checked too, because only the plugin knows whether they are paths.
            let (ParamKind::Path | ParamKind::Text, ParamValue::Text(text)) = (&param.kind, value) else { continue };
            let span = given.get(&param.key).map_or(0..0, Spanned::span);
            let allowed = self.options.search.allowed().check_parameter(text.as_ref());
            allowed.map_err(|error| self.refused(span, error))?;
        }
        Ok(())
    }

    /// Opens the contact law of a tool.
    pub(super) fn contact_law(&mut self, scene: &PluginScene) -> Result<Arc<ContactLaw>, SessionError> {
        let at_plugin = |error| {
            if let SessionError::Host(error @ HostError::NoSuchPlugin { .. }) = error {
                return SessionError::Scene(self.source.error(scene.plugin.span(), error.to_string()));
            }
            error
        };
        let found = self.plugin(PluginKind::ContactLaw, &scene.plugin, &scene.params);
        let (library, info, settings) = found.map_err(at_plugin)?;
        let law = ContactLaw::open(library, &info.id, &settings, self.dt);
        law.map(Arc::new).map_err(|error| self.refused(span_of(&error, &scene.params, scene.plugin.span()), error))
    }

    /// The error of a plugin that refuses a parameter, at the span of the scene.
    pub(in crate::session) fn refused(&self, span: Range<usize>, error: HostError) -> SessionError {
        if error.is_refusal() { self.source.error(span, error.to_string()).into() } else { error.into() }
    }
}

/// Span of the scene for a plugin's error: that of the first parameter it names, or of the plugin.
pub(super) fn span_of(error: &HostError, given: &Given, plugin: Range<usize>) -> Range<usize> {
    let text = error.to_string();
    let named = given.iter().filter_map(|(key, value)| Some((text.find(&format!("`{key}`"))?, value.span())));
    named.min_by_key(|(at, _)| *at).map_or(plugin, |(_, span)| span)
}
