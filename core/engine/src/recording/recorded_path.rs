//! Paths in the header of a recording, which is JSON: a text, or on Unix the bytes of a path that is not UTF-8.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _, ser::Error as _};
use std::path::{Path, PathBuf};

/// A path as it is written.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Text(String),
    Bytes(Vec<u8>),
}

impl Written {
    fn of(path: &Path) -> Option<Self> {
        match path.to_str() {
            Some(text) => Some(Self::Text(text.into())),
            None => bytes_of(path).map(Self::Bytes),
        }
    }

    fn path(self) -> Option<PathBuf> {
        match self {
            Self::Text(text) => Some(text.into()),
            Self::Bytes(bytes) => path_of(bytes),
        }
    }
}

/// The bytes of a path.
#[cfg(unix)]
fn bytes_of(path: &Path) -> Option<Vec<u8>> {
    use std::os::unix::ffi::OsStrExt;
    Some(path.as_os_str().as_bytes().to_vec())
}

/// The path with these bytes.
#[cfg(unix)]
fn path_of(bytes: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    Some(std::ffi::OsString::from_vec(bytes).into())
}

/// Paths have no bytes on this system.
#[cfg(not(unix))]
fn bytes_of(_path: &Path) -> Option<Vec<u8>> {
    None
}

/// Paths have no bytes on this system.
#[cfg(not(unix))]
fn path_of(_bytes: Vec<u8>) -> Option<PathBuf> {
    None
}

pub(super) fn serialize<S: Serializer>(path: &Path, to: S) -> Result<S::Ok, S::Error> {
    let written = Written::of(path);
    let no_text = || S::Error::custom(format!("{}: no Unicode text; allowed is a path that is one", path.display()));
    written.ok_or_else(no_text)?.serialize(to)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<PathBuf, D::Error> {
    let no_bytes = || D::Error::custom("a path of bytes; allowed is a text on this system");
    Written::deserialize(from)?.path().ok_or_else(no_bytes)
}

/// The same of a path that may be absent.
pub(super) mod optional {
    use super::{Deserialize, Deserializer, PathBuf, Serialize, Serializer};

    /// A path with the form of the module above.
    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Present(#[serde(with = "super")] PathBuf);

    pub(crate) fn serialize<S: Serializer>(path: &Option<PathBuf>, to: S) -> Result<S::Ok, S::Error> {
        path.clone().map(Present).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<PathBuf>, D::Error> {
        Ok(Option::<Present>::deserialize(from)?.map(|Present(path)| path))
    }
}
