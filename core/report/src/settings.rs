//! Values that replace those of a scene, by path, as `--set` does.

use std::collections::BTreeMap;

/// Values by path, as a catalogue states them.
pub(crate) type Settings = BTreeMap<String, toml::Value>;

/// A path and the text of its value, as a scene takes them.
pub(crate) type Setting = (String, String);

/// The settings of several lists, in order.
pub(crate) fn merge<'a>(lists: impl IntoIterator<Item = &'a Settings>) -> Vec<Setting> {
    lists.into_iter().flatten().map(|(path, value)| (path.clone(), value.to_string())).collect()
}

/// A setting of `path` to a value.
pub(crate) fn setting(path: &str, value: impl ToString) -> Setting {
    (path.to_owned(), value.to_string())
}
