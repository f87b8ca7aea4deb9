//! Shared libraries made from C while a test runs.

use crate::{Bench, root};
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::PathBuf;
use std::process::Command;

fn compiler() -> String {
    std::env::var("CC").unwrap_or_else(|_| "cc".into())
}

/// The file name of a library.
pub fn file_name(stem: &str) -> String {
    format!("{DLL_PREFIX}{stem}{DLL_SUFFIX}")
}

impl Bench {
    /// Builds the library `folder/stem` in it from a text that may include `pliant.h`.
    ///
    /// # Panics
    /// If there is no C compiler (`$CC`, or `cc`), or it refuses the text.
    pub fn compile(&self, folder: &str, stem: &str, text: &str) -> PathBuf {
        let source = self.write(&format!("{folder}/{stem}.c"), text);
        let library = self.path(&format!("{folder}/{}", file_name(stem)));
        let include = root().join("plugin-api/include");
        let mut command = Command::new(compiler());
        command.args(["-shared", "-fPIC", "-std=c11", "-Wall", "-Wextra", "-Werror", "-I"]).arg(include);
        let told = command.arg(&source).arg("-o").arg(&library).output();
        let told = told.unwrap_or_else(|e| panic!("the C compiler `{}`: {e}", compiler()));
        assert!(told.status.success(), "{}\n{}", source.display(), String::from_utf8_lossy(&told.stderr));
        library
    }
}
