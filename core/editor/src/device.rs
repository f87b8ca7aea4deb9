//! The devices that can have the hand of an editor in the place of a pointer.

use pliant_engine::scene::{DeviceScene, parse_quantity};
use pliant_host::{Device, Library, ParamInfo, ParamKind, ParamValue, PluginInfo, PluginKind, SearchPath};
use std::path::{Path, PathBuf};

/// Plugin of devices that follow a script and not a hand.
const SCRIPTED: &str = "scripted";

/// A device plugin, as an editor offers it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceChoice {
    /// What it is called: the id of its plugin, or the name of a scene's device.
    pub name: String,
    /// What it is, a line for people.
    pub summary: String,
    /// How it is opened.
    pub request: DeviceRequest,
}

/// A device and its parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceRequest {
    /// Id of the plugin, or path of its library, `#` and the id.
    pub plugin: String,
    /// Keys of parameters and their values as text: quantities, or numbers in the unit of the parameter.
    pub settings: Vec<(String, String)>,
    /// Folder that paths are relative to.
    pub folder: PathBuf,
}

impl DeviceRequest {
    /// The device of a scene in a folder; `None` if it is moved by a script or a recording.
    pub fn of_scene(device: &DeviceScene, folder: &Path) -> Option<Self> {
        let plugin = device.plugin.get_ref().clone();
        let is_hand = plugin != SCRIPTED && device.recording.is_none();
        // What is neither text nor a number is refused when the device is opened.
        let text = |value: &toml::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let settings = device.params.iter().map(|(key, value)| (key.clone(), text(value.get_ref())));
        is_hand.then(|| Self { plugin, settings: settings.collect(), folder: folder.to_path_buf() })
    }

    /// Opens the device, which is read every `dt` (s).
    ///
    /// # Errors
    /// A sentence that names the device: there is no such plugin, a parameter or a library is not allowed, or the device is not there.
    pub fn open(&self, search: &SearchPath, dt: f64) -> Result<Device, String> {
        let named = |error: &dyn std::fmt::Display| format!("device `{}`: {error}", self.plugin);
        let (file, id) = self.plugin.split_once('#').unwrap_or((&self.plugin, &self.plugin));
        let found = search.find(file, &self.folder).map_err(|error| named(&error))?;
        let library = Library::open(&found.path).map_err(|error| named(&error))?;
        let is_it = |info: &&PluginInfo| info.kind == PluginKind::Device && info.id == id;
        let info = library.plugins().iter().find(is_it).or_else(|| library.only_plugin(PluginKind::Device));
        let info = info.ok_or_else(|| named(&"its library has no device of that name"))?;
        let settings = self.settings.iter().map(|(key, text)| {
            let is_number = |param: &&ParamInfo| param.key == *key && matches!(param.kind, ParamKind::Number { .. });
            let number = info.params.iter().find(is_number).and_then(|param| parse_quantity(text, &param.unit).ok());
            let (place, mut value) = info.setting(key, &number.map_or_else(|| text.clone(), |n| n.to_string()))?;
            let kind = &info.params[place].kind;
            if let (ParamKind::Path, ParamValue::Text(path)) = (kind, &mut value) {
                *path = self.folder.join(&*path).to_string_lossy().into_owned();
            }
            // Text parameters are checked too, because only the plugin knows whether they are paths.
            if let ParamValue::Text(text) = &value {
                search.allowed().check_parameter(text.as_ref()).map_err(|error| error.to_string())?;
            }
            Ok((place, value))
        });
        let settings: Result<Vec<_>, String> = settings.collect();
        let settings = settings.map_err(|error| named(&error))?;
        Device::open(library, &info.id, &settings, dt).map_err(|error| named(&error))
    }
}

/// The devices of every library that is found, but for those that follow a script. Opens the libraries.
pub fn device_choices(search: &SearchPath) -> Vec<DeviceChoice> {
    let libraries = search.scan().into_iter().filter_map(|found| Library::open(&found.path).ok());
    let devices = libraries.flat_map(|library| library.plugins().iter().filter(|p| p.kind == PluginKind::Device));
    let hands = devices.filter(|info| info.id != SCRIPTED);
    let choice = |info: &PluginInfo| DeviceChoice {
        name: info.id.clone(),
        summary: info.summary.clone(),
        request: DeviceRequest { plugin: info.id.clone(), ..DeviceRequest::default() },
    };
    hands.map(choice).collect()
}
