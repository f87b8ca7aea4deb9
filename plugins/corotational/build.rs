//! Compiles the C++ of this plugin with the system's compiler; a warning is an error.

fn main() {
    let include = "../../plugin-api/include";
    for file in ["src/corotational.cpp", "src/element.hpp", "src/matrix.hpp"] {
        println!("cargo::rerun-if-changed={file}");
    }
    println!("cargo::rerun-if-changed={include}/pliant.h");
    // Contraction into fused multiply-adds would make results depend on the processor.
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").include(include).file("src/corotational.cpp");
    build.warnings(true).extra_warnings(true).warnings_into_errors(true);
    build.flag_if_supported("-ffp-contract=off").flag_if_supported("-fvisibility=hidden").opt_level(3);
    build.compile("pliant_corotational_cpp");
}
