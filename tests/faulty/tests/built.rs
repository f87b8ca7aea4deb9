//! The file name of the library: `pliant-tests` finds it beside the test binaries, and `pliant plugin list`, which looks for names with
//! `pliant_`, does not show it.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};

#[test]
fn the_library_has_a_name_that_plugin_list_skips() {
    let folder = std::env::current_exe().unwrap().parent().unwrap().to_path_buf();
    assert!(folder.join(format!("{DLL_PREFIX}faulty_plugins{DLL_SUFFIX}")).is_file());
    assert!(!folder.join(format!("{DLL_PREFIX}pliant_faulty{DLL_SUFFIX}")).exists());
}
