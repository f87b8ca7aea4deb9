//! Cargo builds the library beside these tests, where those of the whole look for it, and `plugin list` passes over it.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};

#[test]
fn the_library_is_there_under_a_name_that_users_are_not_shown() {
    let folder = std::env::current_exe().unwrap().parent().unwrap().to_path_buf();
    assert!(folder.join(format!("{DLL_PREFIX}faulty_plugins{DLL_SUFFIX}")).is_file());
    assert!(!folder.join(format!("{DLL_PREFIX}pliant_faulty{DLL_SUFFIX}")).exists());
}
