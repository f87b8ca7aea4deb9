//! Declaration of parameters, and the values an instance was given.
//!
//! The host checks a scene against the declarations before any code of the plugin runs, so a plugin only has to check what a range
//! cannot express, such as combinations.

use crate::abi;
use core::ffi::CStr;
use core::ops::RangeInclusive;
use std::ptr::null;

/// Declaration of one parameter. Keys are kebab-case, units are SI text (`"Pa"`, `"kg/m^3"`, `"1"`).
#[repr(transparent)]
pub struct Param(pub(crate) abi::Param);

#[allow(unsafe_code, reason = "raw pointers make the type `!Sync`")]
// SAFETY: the constructors take `'static` strings only, and nothing writes through the pointers.
unsafe impl Sync for Param {}

impl Param {
    /// A declaration without a range, default or choices.
    const fn base(kind: u32, key: &'static CStr, unit: &'static CStr, summary: &'static CStr) -> abi::Param {
        let (key, unit, summary) = (key.as_ptr(), unit.as_ptr(), summary.as_ptr());
        abi::Param { kind, key, unit, summary, min: 0.0, max: 0.0, fallback: 0.0, choices: null(), flags: 0 }
    }

    /// A number in `range`, in `unit`; `default` where the scene does not give it.
    pub const fn number(
        key: &'static CStr,
        unit: &'static CStr,
        range: RangeInclusive<f64>,
        default: f64,
        summary: &'static CStr,
    ) -> Self {
        let base = Self::base(abi::PARAM_NUMBER, key, unit, summary);
        Self(abi::Param { min: *range.start(), max: *range.end(), fallback: default, ..base })
    }

    /// Marks the parameter as a field: it may vary per element and is read with [`crate::Elements::field`]. For number parameters of materials only.
    pub const fn field(self) -> Self {
        Self(abi::Param { flags: self.0.flags | abi::PARAM_FIELD, ..self.0 })
    }

    /// One of `choices`, written `c"one|two|three"`; the first is the default.
    pub const fn choice(key: &'static CStr, choices: &'static CStr, summary: &'static CStr) -> Self {
        let base = Self::base(abi::PARAM_CHOICE, key, c"1", summary);
        Self(abi::Param { choices: choices.as_ptr(), ..base })
    }

    /// A string; empty where the scene does not give it.
    pub const fn text(key: &'static CStr, summary: &'static CStr) -> Self {
        Self(Self::base(abi::PARAM_TEXT, key, c"1", summary))
    }

    /// A path, made absolute by the host; empty where the scene does not give it.
    pub const fn path(key: &'static CStr, summary: &'static CStr) -> Self {
        Self(Self::base(abi::PARAM_PATH, key, c"1", summary))
    }

    /// Rows of numbers under the named `columns`, written `c"time|x|y|z"`; no rows where the scene does not give it.
    pub const fn table(key: &'static CStr, columns: &'static CStr, summary: &'static CStr) -> Self {
        let base = Self::base(abi::PARAM_TABLE, key, c"1", summary);
        Self(abi::Param { choices: columns.as_ptr(), ..base })
    }

    /// Whether this is the parameter `key`.
    fn has_key(&self, key: &str) -> bool {
        #[allow(unsafe_code, reason = "reads back a pointer the constructor took from a CStr")]
        // SAFETY: every constructor stores the pointer of a `&'static CStr`.
        let own = unsafe { CStr::from_ptr(self.0.key) };
        own.to_bytes() == key.as_bytes()
    }
}

/// Value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number in the parameter's unit, or the index of a choice.
    Number(f64),
    /// A string or a path.
    Text(String),
    /// A table; see [`Table`].
    Table(Table),
}

/// A table of numbers, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Number of columns.
    pub columns: usize,
    /// Values, rows x columns, row-major.
    pub values: Vec<f64>,
}

impl Table {
    /// The rows in order, each of `columns` numbers.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.max(1))
    }
}

/// The parameter values of one instance, by key.
///
/// # Panics
/// Every getter panics on a key that is not declared, and on a value with another representation than it reads (number, string or table): this is
/// a bug in the plugin. A choice is stored as a number, a path as a string.
pub struct Params<'a> {
    declared: &'static [Param],
    values: &'a [Value],
}

impl<'a> Params<'a> {
    /// Values of an instance, in the order of `declared`. Tests use it to give parameters to a plugin that is linked in.
    ///
    /// # Panics
    /// If there is not one value for each declared parameter.
    pub fn new(declared: &'static [Param], values: &'a [Value]) -> Self {
        assert_eq!(declared.len(), values.len(), "one value for each declared parameter");
        Self { declared, values }
    }

    /// The value of `key`.
    fn value(&self, key: &str) -> &'a Value {
        let index = position(self.declared, key).unwrap_or_else(|| panic!("parameter `{key}` is not declared"));
        &self.values[index]
    }

    /// A number, in the unit it was declared with.
    pub fn number(&self, key: &str) -> f64 {
        match self.value(key) {
            Value::Number(value) => *value,
            Value::Text(_) | Value::Table(_) => panic!("parameter `{key}` is not a number"),
        }
    }

    /// Index of the choice among those declared.
    pub fn choice(&self, key: &str) -> usize {
        self.number(key) as usize
    }

    /// A string or path; `None` where it is empty.
    pub fn text(&self, key: &str) -> Option<&'a str> {
        match self.value(key) {
            Value::Text(text) => Some(text.as_str()).filter(|t| !t.is_empty()),
            Value::Number(_) | Value::Table(_) => panic!("parameter `{key}` is not a string"),
        }
    }

    /// A table; `None` where it has no rows.
    pub fn table(&self, key: &str) -> Option<&'a Table> {
        match self.value(key) {
            Value::Table(table) => Some(table).filter(|t| !t.values.is_empty()),
            Value::Number(_) | Value::Text(_) => panic!("parameter `{key}` is not a table"),
        }
    }
}

/// The default of each declared parameter, in their order.
pub fn defaults(declared: &[Param]) -> Vec<Value> {
    declared
        .iter()
        .map(|p| match p.0.kind {
            abi::PARAM_NUMBER | abi::PARAM_CHOICE => Value::Number(p.0.fallback),
            abi::PARAM_TABLE => Value::Table(Table::default()),
            _ => Value::Text(String::new()),
        })
        .collect()
}

/// Index of `key` among the declared parameters that may vary per element, or `None`.
pub(crate) fn field_position(declared: &[Param], key: &str) -> Option<usize> {
    let mut fields = declared.iter().filter(|p| p.0.flags & abi::PARAM_FIELD != 0);
    fields.position(|p| p.has_key(key))
}

/// Index of `key` among the declared parameters, or `None`.
pub fn position(declared: &[Param], key: &str) -> Option<usize> {
    declared.iter().position(|p| p.has_key(key))
}
