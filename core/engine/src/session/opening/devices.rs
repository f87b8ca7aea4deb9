//! Opening of the devices of a scene: by their plugins, or with the hands of a recording in their place.

use super::Opening;
use super::plugins::span_of;
use crate::recording::RecordedHands;
use crate::scene::{DeviceScene, Scene};
use crate::session::shared::SharedModel;
use crate::session::{DeviceSlot, SessionError, place};
use pliant_host::{Device, DeviceInfo, ParamKind, ParamSettings, ParamValue, PluginInfo, PluginKind, Pose};
use std::sync::Arc;
use toml::Spanned;

impl Opening<'_> {
    /// Opens the device `index` of the scene.
    pub(super) fn device(
        &mut self,
        scene: &Scene,
        index: usize,
        models: &[(String, SharedModel)],
    ) -> Result<DeviceSlot, SessionError> {
        let device = &scene.device[index];
        let span = device.name.span();
        let frame = place::frame(&device.frame, self.source, span, models, self.options.mesh.is_some())?;
        let name = device.name.get_ref().clone();
        let mut hands = None;
        let (opened, facts, origin) = match (&self.options.recorded, &device.recording) {
            (Some(recorded), _) => {
                let of = |(recorded, _): &&(String, DeviceInfo)| *recorded == name;
                let known = || recorded.iter().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                let missing = || format!("no hands of device `{name}` were recorded; there are those of {}", known());
                let found = recorded.iter().find(of).ok_or_else(|| self.source.error(device.name.span(), missing()))?;
                (None, found.1, format!("the recorded device `{name}`"))
            }
            (None, Some(path)) => {
                let (recording, index) = self.recorded_hands(device, path)?;
                let (recorded, facts) = &recording.devices()[index];
                let origin = format!("device `{name}` (hands of `{recorded}` in {})", recording.path().display());
                let facts = *facts;
                hands = Some((recording, index));
                (None, facts, origin)
            }
            (None, None) => {
                let (library, info, settings) = self.plugin(PluginKind::Device, &device.plugin, &device.params)?;
                let opened = Device::open(library, &info.id, &settings, self.dt)
                    .map_err(|error| self.refused(span_of(&error, &device.params, device.name.span()), error))?;
                let facts = *opened.device_info();
                (Some(opened), facts, device_origin(&name, info, &settings))
            }
        };
        let poses = vec![Pose::default(); facts.effectors as usize];
        Ok(DeviceSlot {
            name,
            device: opened,
            facts,
            frame,
            origin,
            poses,
            recorded: hands,
            driven: false,
            counted: Vec::new(),
        })
    }

    /// The recording of a device, and the index of its hands among the recorded devices.
    fn recorded_hands(
        &mut self,
        device: &DeviceScene,
        recording: &Spanned<String>,
    ) -> Result<(Arc<RecordedHands>, usize), SessionError> {
        let path = self.source.folder().join(recording.get_ref());
        let read = match self.inputs.recordings.iter().find(|known| known.path() == path) {
            Some(known) => Arc::clone(known),
            None => {
                let read = RecordedHands::read(&path)
                    .map_err(|error| self.source.error(recording.span(), error.to_string()))?;
                self.inputs.recordings.push(Arc::new(read));
                Arc::clone(&self.inputs.recordings[self.inputs.recordings.len() - 1])
            }
        };
        if read.dt() != self.dt {
            let text = format!(
                "its hands were recorded in steps of {} s, and `[time] dt` is {} s; allowed is the same step",
                read.dt(),
                self.dt
            );
            return Err(self.source.error(recording.span(), text).into());
        }
        let devices = read.devices();
        let wanted = device.recorded.as_ref().unwrap_or(&device.name);
        let of_name = devices.iter().position(|(name, _)| name == wanted.get_ref());
        let only = || (device.recorded.is_none() && devices.len() == 1).then_some(0);
        let index = of_name.or_else(only).ok_or_else(|| {
            let known = devices.iter().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            let text = format!(
                "no hands of device `{}` in the recording; allowed for `recorded` is {known}",
                wanted.get_ref()
            );
            self.source.error(wanted.span(), text)
        })?;
        Ok((read, index))
    }
}

/// Description of a device in messages: its name, its plugin and its text parameters, such as an address.
fn device_origin(name: &str, info: &PluginInfo, settings: &ParamSettings) -> String {
    let given = settings.iter().filter_map(|(index, value)| match (&info.params[*index].kind, value) {
        (ParamKind::Text, ParamValue::Text(text)) => Some(format!(", {} {text}", info.params[*index].key)),
        _ => None,
    });
    format!("device `{name}` ({}{})", info.id, given.collect::<String>())
}
