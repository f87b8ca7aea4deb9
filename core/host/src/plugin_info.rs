//! Descriptions of plugins and their parameters, copied out of the descriptors of a library.

use pliant_plugin_api::abi;
use std::ffi::{CStr, c_char};

/// Largest number of parameters of one plugin.
const MAX_PARAMS: usize = 1000;

/// The kinds of plugins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PluginKind {
    /// Provides the cells and nodes in which a surface is embedded.
    Grid,
    /// Provides energies and forces.
    Material,
    /// Provides poses of hands and renders forces.
    Device,
    /// Provides tractions between tools and bodies.
    ContactLaw,
}

impl PluginKind {
    /// Name in messages, listings and scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Material => "material",
            Self::Device => "device",
            Self::ContactLaw => "contact-law",
        }
    }

    /// The kind with a [`PluginKind::name`]; `None` for an unknown one.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Grid, Self::Material, Self::Device, Self::ContactLaw].into_iter().find(|kind| kind.name() == name)
    }
}

/// Description of one plugin of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct PluginInfo {
    /// Id in kebab-case, with a reversed domain before it for plugins of third parties.
    pub id: String,
    /// Kind of the plugin.
    pub kind: PluginKind,
    /// Name for people.
    pub name: String,
    /// Version of the plugin.
    pub version: String,
    /// Description, one line.
    pub summary: String,
    /// Whether it follows the real-time rules of the interface: no allocation, lock or I/O in a step or servo loop.
    pub real_time: bool,
    /// Whether equal inputs give equal bytes on one binary.
    pub deterministic: bool,
    /// Whether a material wants all elements of a kind in each call, and one call at a time.
    pub whole_lists: bool,
    /// Declared parameters in order.
    pub params: Vec<ParamInfo>,
}

/// A declared parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamInfo {
    /// Key in kebab-case.
    pub key: String,
    /// SI unit as text, `1` without one.
    pub unit: String,
    /// Description, one line.
    pub summary: String,
    /// Type, range and default.
    pub kind: ParamKind,
    /// Whether it may differ from element to element.
    pub is_field: bool,
}

/// Type, range and default of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParamKind {
    /// A number in the unit of the parameter.
    Number {
        /// Least allowed value.
        min: f64,
        /// Greatest allowed value.
        max: f64,
        /// Value if the scene gives none.
        default: f64,
    },
    /// One of several choices.
    Choice {
        /// The choices as scenes write them.
        choices: Vec<String>,
        /// Index of the choice if the scene gives none.
        default: usize,
    },
    /// Any text without a NUL character.
    Text,
    /// Path of a file.
    Path,
    /// Rows of numbers.
    Table {
        /// Names of the columns.
        columns: Vec<String>,
    },
}

/// A value for a parameter, checked by [`ParamInfo::check`].
#[derive(Clone, Debug, PartialEq)]
pub enum ParamValue {
    /// A number in the parameter's unit.
    Number(f64),
    /// A choice, text or absolute path.
    Text(String),
    /// Rows of numbers, row-major.
    Table {
        /// Number of columns.
        columns: usize,
        /// The numbers (rows x columns), row by row.
        values: Vec<f64>,
    },
}

impl PluginInfo {
    /// Parameters that may differ from element to element, in the order of their planes.
    pub fn fields(&self) -> impl Iterator<Item = &ParamInfo> {
        self.params.iter().filter(|param| param.is_field)
    }

    /// Place and value of a parameter that is given as text, a number in the parameter's own unit.
    ///
    /// # Errors
    /// Returns a message with the key and what is allowed.
    pub fn setting(&self, key: &str, text: &str) -> Result<(usize, ParamValue), String> {
        let known = || self.params.iter().map(|p| p.key.as_str()).collect::<Vec<_>>().join(", ");
        let index = self.params.iter().position(|p| p.key == key);
        let index = index.ok_or_else(|| format!("`{}` has no parameter `{key}`; allowed is {}", self.id, known()))?;
        let param = &self.params[index];
        let value = match param.kind {
            ParamKind::Number { .. } => text.parse().map(ParamValue::Number).map_err(|_| param.allowed()),
            ParamKind::Table { .. } => Err("nothing here: tables are for scenes".into()),
            ParamKind::Choice { .. } | ParamKind::Text | ParamKind::Path => Ok(ParamValue::Text(text.to_owned())),
        };
        let value = value.map_err(|allowed| format!("`{key}` is `{text}`; allowed is {allowed}"))?;
        param.check(&value).map_err(|reason| format!("`{key}`: {reason}"))?;
        Ok((index, value))
    }
}

impl ParamInfo {
    /// Checks that `value` has the type and range of the parameter.
    ///
    /// # Errors
    /// Returns a message with the value and what is allowed.
    pub fn check(&self, value: &ParamValue) -> Result<(), String> {
        match (&self.kind, value) {
            (ParamKind::Number { min, max, .. }, ParamValue::Number(v)) => {
                if (*min..=*max).contains(v) {
                    return Ok(());
                }
                let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
                let [shown, min, max] = [*v, *min, *max].map(readable);
                Err(format!("{shown}{unit} is out of range; allowed is {min} to {max}{unit}"))
            }
            (ParamKind::Choice { choices, .. }, ParamValue::Text(text)) => {
                let known = choices.contains(text);
                if known { Ok(()) } else { Err(format!("`{text}` is not a choice; allowed is {}", choices.join(", "))) }
            }
            (ParamKind::Text | ParamKind::Path, ParamValue::Text(text)) => {
                if text.contains('\0') {
                    Err("a text cannot hold a NUL character".into())
                } else {
                    Ok(())
                }
            }
            (ParamKind::Table { columns }, ParamValue::Table { columns: given, values }) => {
                if *given != columns.len() {
                    return Err(format!(
                        "rows of {given} numbers; allowed is {}: {}",
                        columns.len(),
                        columns.join(", ")
                    ));
                }
                match values.iter().position(|v| !v.is_finite()) {
                    Some(at) => Err(format!("row {} holds {}; allowed is a finite number", at / given + 1, values[at])),
                    None => Ok(()),
                }
            }
            (
                ParamKind::Number { .. }
                | ParamKind::Choice { .. }
                | ParamKind::Text
                | ParamKind::Path
                | ParamKind::Table { .. },
                _,
            ) => Err(format!("wrong type; allowed is {}", self.allowed())),
        }
    }

    /// Type and range in words, for messages.
    pub fn allowed(&self) -> String {
        match &self.kind {
            ParamKind::Number { min, max, .. } => {
                format!("a number from {} to {} in {}", readable(*min), readable(*max), self.unit)
            }
            ParamKind::Choice { choices, .. } => format!("one of {}", choices.join(", ")),
            ParamKind::Text => "a text".into(),
            ParamKind::Path => "a file".into(),
            ParamKind::Table { columns } => format!("rows of [{}]", columns.join(", ")),
        }
    }
}

/// A number for people: with an exponent where it would be long.
fn readable(v: f64) -> String {
    let is_long = v.abs() >= 1e9 || (v != 0.0 && v.abs() < 1e-6);
    if is_long { format!("{v:e}") } else { v.to_string() }
}

/// Copies the C string `ptr`; errors call it `what`.
///
/// # Safety
/// `ptr` is null or a C string that lives for the call.
#[allow(unsafe_code, reason = "reads the C strings of a descriptor")]
unsafe fn text(ptr: *const c_char, what: &str) -> Result<String, String> {
    if ptr.is_null() {
        return Err(format!("{what} is null"));
    }
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(ptr) }.to_str().map_err(|_| format!("{what} is not UTF-8"))?;
    Ok(text.to_owned())
}

impl PluginInfo {
    /// Copies a descriptor; the error says what is wrong with it.
    ///
    /// # Safety
    /// `raw` is a descriptor of a loaded library.
    #[allow(unsafe_code, reason = "reads a descriptor")]
    pub(crate) unsafe fn read(raw: &abi::Descriptor) -> Result<Self, String> {
        if raw.size < size_of::<abi::Descriptor>() {
            return Err(format!("descriptor of {} bytes, at least {} needed", raw.size, size_of::<abi::Descriptor>()));
        }
        let kind = match raw.kind {
            abi::KIND_GRID => PluginKind::Grid,
            abi::KIND_MATERIAL => PluginKind::Material,
            abi::KIND_DEVICE => PluginKind::Device,
            abi::KIND_CONTACT_LAW => PluginKind::ContactLaw,
            other => return Err(format!("unknown plugin kind {other}")),
        };
        if raw.param_count > 0 && (raw.params.is_null() || raw.param_size < abi::Param::MIN_SIZE) {
            return Err(format!("{} parameters of {} bytes each", raw.param_count, raw.param_size));
        }
        if raw.param_count > MAX_PARAMS {
            return Err(format!("{} parameters; allowed is at most {MAX_PARAMS}", raw.param_count));
        }
        // SAFETY: the header: strings live as long as the library, parameters of `param_size` bytes follow each other.
        unsafe {
            let param = |i: usize| abi::Param::read(raw.params.byte_add(i * raw.param_size), raw.param_size);
            Ok(Self {
                id: text(raw.id, "id")?,
                kind,
                name: text(raw.name, "name")?,
                version: text(raw.version, "version")?,
                summary: text(raw.summary, "summary")?,
                real_time: raw.flags & abi::FLAG_REAL_TIME != 0,
                deterministic: raw.flags & abi::FLAG_DETERMINISTIC != 0,
                whole_lists: kind == PluginKind::Material && raw.flags & abi::FLAG_WHOLE_LISTS != 0,
                params: (0..raw.param_count).map(|i| ParamInfo::read(&param(i))).collect::<Result<_, _>>()?,
            })
        }
    }
}

impl ParamInfo {
    /// Copies the declaration of a parameter; the error says what is wrong with it.
    ///
    /// # Safety
    /// `raw` is a parameter of a loaded library.
    #[allow(unsafe_code, reason = "reads a descriptor")]
    unsafe fn read(raw: &abi::Param) -> Result<Self, String> {
        // SAFETY: strings of a parameter live as long as the library.
        let (key, unit, summary) = unsafe {
            (
                text(raw.key, "parameter key")?,
                text(raw.unit, "parameter unit")?,
                text(raw.summary, "parameter summary")?,
            )
        };
        // SAFETY: as above.
        let list =
            || unsafe { text(raw.choices, "choices") }.map(|t| t.split('|').map(str::to_owned).collect::<Vec<_>>());
        let kind = match raw.kind {
            abi::PARAM_NUMBER => {
                let (min, max, default) = (raw.min, raw.max, raw.fallback);
                if !(min <= default && default <= max) {
                    return Err(format!("parameter `{key}`: default {default} outside {min} to {max}"));
                }
                ParamKind::Number { min, max, default }
            }
            abi::PARAM_CHOICE => {
                let (choices, default) = (list()?, raw.fallback as usize);
                if default >= choices.len() {
                    return Err(format!("parameter `{key}`: default {default} of {} choices", choices.len()));
                }
                ParamKind::Choice { choices, default }
            }
            abi::PARAM_TEXT => ParamKind::Text,
            abi::PARAM_PATH => ParamKind::Path,
            abi::PARAM_TABLE => ParamKind::Table { columns: list()? },
            other => return Err(format!("parameter `{key}`: unknown kind {other}")),
        };
        let is_field = raw.flags & abi::PARAM_FIELD != 0;
        if is_field && !matches!(kind, ParamKind::Number { .. }) {
            return Err(format!("parameter `{key}`: a field that is no number"));
        }
        Ok(Self { key, unit, summary, kind, is_field })
    }
}
