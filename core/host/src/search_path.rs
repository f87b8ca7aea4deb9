//! The search path of plugins.
//!
//! The order is: folders given to the program, `$PLIANT_PLUGIN_PATH`, the folder of the executable (in a build tree its `deps/` first, which is
//! always up to date; the copies beside the executable are updated by `cargo build` alone), the per-user data folder. File names follow from
//! the name of a plugin; no library is opened during the search.
//!
//! Folders of the environment and the per-user folder are left out if other users can write to them, and relative folders of the environment
//! always, as they depend on the current folder. [`SearchPath::warnings`] names what was left out.

use crate::error::HostError;
use crate::trust::{AllowedFolders, writable_by_others};
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX, EXE_SUFFIX};
use std::path::{Path, PathBuf};

/// The folders that are searched for plugins.
#[derive(Clone, Debug)]
pub struct SearchPath {
    /// The folders in order.
    folders: Vec<SearchedFolder>,
    /// Folders in which scenes may name libraries by path.
    allowed: AllowedFolders,
    /// Folders that are not searched, a message each.
    warnings: Vec<String>,
}

/// A folder that is searched.
#[derive(Clone, Debug)]
struct SearchedFolder {
    /// Where the folder is.
    path: PathBuf,
    /// Why it is searched.
    origin: Origin,
}

/// Why a folder is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// Given with `--plugin-path`.
    Given,
    /// Given with the argument `plugin_path`, by a program that uses the engine as a library.
    Argument,
    /// Listed in `$PLIANT_PLUGIN_PATH`.
    Environment,
    /// The folder of the package that uses the engine as a library.
    Package,
    /// The folder of the executable, or `deps/` in it.
    Executable,
    /// The per-user data folder.
    User,
}

impl Origin {
    /// Whether a folder must not be writable by other users. Folders of other origins are named by the user or come with the program.
    fn is_checked(self) -> bool {
        matches!(self, Self::Environment | Self::User)
    }

    /// Name in messages.
    fn name(self) -> &'static str {
        match self {
            Self::Given => "--plugin-path",
            Self::Argument => "plugin_path",
            Self::Package => "inside the package",
            Self::Environment => "$PLIANT_PLUGIN_PATH",
            Self::Executable => "beside the program",
            Self::User => "the user's data folder",
        }
    }
}

/// A library file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundLibrary {
    /// Name of the plugin in a scene, from the file name.
    pub name: String,
    /// Absolute path of the file, links followed.
    pub path: PathBuf,
}

impl SearchPath {
    /// The folders `given`, then the default ones.
    pub fn new(given: &[PathBuf]) -> Self {
        let executable = std::env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_path_buf));
        let deps = executable.as_ref().map(|folder| folder.join("deps"));
        let own = deps.into_iter().chain(executable).map(|path| SearchedFolder { path, origin: Origin::Executable });
        Self::around(given.iter().map(|path| SearchedFolder { path: path.clone(), origin: Origin::Given }), own)
    }

    /// The folders `given`, then the default ones with `package` instead of the folder of the executable: for a package that contains plugins
    /// and is loaded by another program.
    pub fn in_package(given: &[PathBuf], package: &Path) -> Self {
        let own = std::iter::once(SearchedFolder { path: package.to_path_buf(), origin: Origin::Package });
        Self::around(given.iter().map(|path| SearchedFolder { path: path.clone(), origin: Origin::Argument }), own)
    }

    /// The folders `given`, those of the environment, the program's `own`, and the user's.
    fn around(given: impl Iterator<Item = SearchedFolder>, own: impl Iterator<Item = SearchedFolder>) -> Self {
        let mut folders: Vec<_> = given.collect();
        if let Some(list) = std::env::var_os("PLIANT_PLUGIN_PATH") {
            let listed = std::env::split_paths(&list).filter(|f| !f.as_os_str().is_empty());
            folders.extend(listed.map(|path| SearchedFolder { path, origin: Origin::Environment }));
        }
        folders.extend(own);
        if let Some(folder) = user_data_folder() {
            folders.push(SearchedFolder { path: folder.join("pliant").join("plugins"), origin: Origin::User });
        }
        Self::checked(folders)
    }

    /// Those of the folders that are safe to search.
    fn checked(all: Vec<SearchedFolder>) -> Self {
        let (mut folders, mut warnings) = (Vec::new(), Vec::new());
        for SearchedFolder { path, origin } in all {
            let relative =
                || (origin == Origin::Environment && path.is_relative()).then(|| "it is relative".to_owned());
            let others = || writable_by_others(&path).filter(|_| origin.is_checked());
            match relative().or_else(others) {
                None => folders.push(SearchedFolder { path, origin }),
                Some(reason) => {
                    let (folder, origin) = (path.display(), origin.name());
                    warnings.push(format!(
                        "plugins in {folder} ({origin}) are not used: {reason}; allowed is an absolute path that no other user can \
                         write to"
                    ));
                }
            }
        }
        Self { folders, allowed: AllowedFolders::default(), warnings }
    }

    /// The same search path, with folders in which scenes may name libraries by path.
    #[must_use]
    pub fn allow(self, allowed: AllowedFolders) -> Self {
        Self { allowed, ..self }
    }

    /// A message for each folder that is not searched because others could put plugins into it.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Folders in which scenes may name libraries by path.
    pub fn allowed(&self) -> &AllowedFolders {
        &self.allowed
    }

    /// Finds the library file of the plugin that a scene calls `name`; a name with a separator is a path, relative to `base`.
    ///
    /// # Errors
    /// [`HostError::NotFound`], with every folder that was searched; [`HostError::NotAllowed`] for a path outside of the folders in which
    /// scenes may name libraries.
    pub fn find(&self, name: &str, base: &Path) -> Result<FoundLibrary, HostError> {
        let found = self.find_trusted(name, base)?;
        if is_path(name) {
            self.allowed.check(&found.path)?;
        }
        Ok(found)
    }

    /// Finds the library file of the plugin that the user calls `name`, as on the command line; a path may be in any folder.
    ///
    /// # Errors
    /// [`HostError::NotFound`], with every folder that was searched.
    pub fn find_trusted(&self, name: &str, base: &Path) -> Result<FoundLibrary, HostError> {
        if is_path(name) {
            let path = base.join(name);
            return match path.canonicalize() {
                Ok(path) => Ok(FoundLibrary { name: name_of(&path), path }),
                Err(error) => Err(HostError::NotFound {
                    name: name.to_owned(),
                    files: path.display().to_string(),
                    places: format!("  {}: {error}", base.display()),
                }),
            };
        }
        let files = file_names(name);
        for SearchedFolder { path: folder, origin } in &self.folders {
            for file in &files {
                if let Some(path) = real_file(&folder.join(file)) {
                    check_file(&path, *origin)?;
                    return Ok(FoundLibrary { name: name.to_owned(), path });
                }
            }
        }
        let place = |SearchedFolder { path: folder, origin }: &SearchedFolder| {
            let there = |file: &&String| folder.join(file).symlink_metadata().is_ok();
            let state = match files.iter().find(there) {
                Some(file) => format!(": {file} is a folder or a link to nothing"),
                None if folder.is_dir() => String::new(),
                None => ": no such folder".into(),
            };
            format!("  {} ({}){state}", folder.display(), origin.name())
        };
        Err(HostError::NotFound {
            name: name.to_owned(),
            files: files.join(" or "),
            places: self.folders.iter().map(place).collect::<Vec<_>>().join("\n"),
        })
    }

    /// Finds the program that emulates the hardware of device `name`, `pliant-twin-NAME`, in the same folders.
    ///
    /// # Errors
    /// [`HostError::NotFound`], with every folder that was searched.
    pub fn find_twin(&self, name: &str) -> Result<PathBuf, HostError> {
        let file = format!("pliant-twin-{name}{EXE_SUFFIX}");
        let is_name = !name.contains(['/', '\\', '.']);
        let in_folder = |folder: &SearchedFolder| Some((real_file(&folder.path.join(&file))?, folder.origin));
        if let Some((path, origin)) = self.folders.iter().find_map(in_folder).filter(|_| is_name) {
            check_file(&path, origin)?;
            return Ok(path);
        }
        let places =
            self.folders.iter().map(|folder| format!("  {} ({})", folder.path.display(), folder.origin.name()));
        Err(HostError::NotFound { name: name.to_owned(), files: file, places: places.collect::<Vec<_>>().join("\n") })
    }

    /// Lists every library file that may contain plugins, sorted by name, the first found of each name. Folders and broken links with the name
    /// of a library are listed too if no file has that name. Beside the program, where a build puts other libraries too, names must begin with
    /// `pliant_`; in other folders any name is listed. A library that other users can change is left out.
    pub fn scan(&self) -> Vec<FoundLibrary> {
        let (mut all, mut broken): (Vec<FoundLibrary>, Vec<FoundLibrary>) = (Vec::new(), Vec::new());
        for SearchedFolder { path: folder, origin } in &self.folders {
            let Ok(entries) = folder.read_dir() else { continue };
            let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
            paths.sort();
            for path in paths {
                let file = path.file_name().and_then(|f| f.to_str()).unwrap_or_default();
                let is_named = file.starts_with(&format!("{DLL_PREFIX}pliant_"));
                if !file.ends_with(DLL_SUFFIX) || (matches!(origin, Origin::Executable | Origin::Package) && !is_named)
                {
                    continue;
                }
                let name = name_of(&path);
                match real_file(&path) {
                    Some(path) if check_file(&path, *origin).is_err() => {}
                    Some(path) if all.iter().all(|f| f.name != name) => all.push(FoundLibrary { name, path }),
                    Some(_) => {}
                    None => broken.push(FoundLibrary { name, path }),
                }
            }
        }
        for found in broken {
            if all.iter().all(|f| f.name != found.name) {
                all.push(found);
            }
        }
        all.sort_by(|a, b| a.name.cmp(&b.name));
        all
    }
}

/// Whether the name of a plugin is a path. A colon follows a drive, or precedes a stream, on Windows.
fn is_path(name: &str) -> bool {
    name.contains(['/', '\\', ':'])
}

/// Checks that no other user can change a library that was found in a folder of this origin.
fn check_file(path: &Path, origin: Origin) -> Result<(), HostError> {
    let reason = writable_by_others(path).filter(|_| origin.is_checked());
    reason.map_or(Ok(()), |reason| Err(HostError::Unsafe { path: path.into(), reason }))
}

/// The file that a path leads to; `None` for a broken link or a folder.
fn real_file(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok().filter(|p| p.is_file())
}

/// Names of the files that may contain plugin `name`.
fn file_names(name: &str) -> Vec<String> {
    let stem = name.replace('-', "_");
    let mut files = vec![format!("{DLL_PREFIX}pliant_{stem}{DLL_SUFFIX}"), format!("{DLL_PREFIX}{stem}{DLL_SUFFIX}")];
    for plain in [format!("{stem}{DLL_SUFFIX}"), format!("{name}{DLL_SUFFIX}")] {
        if !files.contains(&plain) {
            files.push(plain);
        }
    }
    files
}

/// Name in scenes of the library at `path`.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let stem = stem.strip_prefix(DLL_PREFIX).unwrap_or(stem);
    stem.strip_prefix("pliant_").unwrap_or(stem).replace('_', "-")
}

/// The per-user data folder of the system, from the environment.
fn user_data_folder() -> Option<PathBuf> {
    let set = |key: &str| std::env::var_os(key).map(PathBuf::from).filter(|p| p.is_absolute());
    if cfg!(windows) {
        set("APPDATA")
    } else if cfg!(target_os = "macos") {
        set("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        set("XDG_DATA_HOME").or_else(|| set("HOME").map(|home| home.join(".local/share")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_files_go_both_ways() {
        for name in ["mass-spring", "cloth", "neo-hookean"] {
            for file in file_names(name) {
                assert_eq!(name_of(Path::new(&file)), name);
            }
        }
    }

    #[test]
    fn a_missing_plugin_names_every_folder() {
        let search =
            SearchPath::checked(vec![SearchedFolder { path: "/nowhere/at/all".into(), origin: Origin::Given }]);
        let text = search.find("mass-spring", Path::new(".")).unwrap_err().to_string();
        for part in ["mass-spring", "pliant_mass_spring", "/nowhere/at/all", "--plugin-path", "no such folder"] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
