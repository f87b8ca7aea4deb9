//! The program is there and says who it is. Cargo builds it beside these tests, where those of the whole look for it.

use std::process::Command;

#[test]
fn the_program_says_its_version() {
    let told = Command::new(env!("CARGO_BIN_EXE_pliant")).arg("--version").output().unwrap();
    assert!(told.status.success());
    assert_eq!(String::from_utf8_lossy(&told.stdout).trim(), concat!("pliant ", env!("CARGO_PKG_VERSION")));
}
