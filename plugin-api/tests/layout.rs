//! The two descriptions of the border, `src/abi` and `include/pliant.h`, have one layout: that of `tests/layout.txt`.
//!
//! After a change that only appends fields (a new minor), mint again with `PLIANT_MINT=1 cargo test -p pliant-plugin-api`
//! and say in the changelog what was appended. Any other difference breaks every plugin there is and needs a new major.

use pliant_plugin_api::abi::*;
use std::fmt::Write as _;
use std::mem::{align_of, offset_of, size_of};
use std::path::Path;
use std::process::Command;

macro_rules! layout {
    ($out:ident, $($name:ty = $c:literal { $($field:ident),+ $(,)? })+) => {$(
        writeln!($out, "{} size {} align {}", $c, size_of::<$name>(), align_of::<$name>()).unwrap();
        $(writeln!($out, "{}.{} {}", $c, stringify!($field), offset_of!($name, $field)).unwrap();)+
    )+};
}

macro_rules! constants {
    ($out:ident, $($name:ident)+) => {$(writeln!($out, "PLIANT_{} value {}", stringify!($name), $name).unwrap();)+};
}

fn rust_layout() -> String {
    let mut out = String::new();
    constants! { out, FLAG_REAL_TIME FLAG_DETERMINISTIC FLAG_WHOLE_LISTS }
    layout! { out,
        Host = "pliant_host" { size, abi_major, abi_minor, data, report }
        Param = "pliant_param" { kind, key, unit, summary, min, max, fallback, choices, flags }
        Descriptor = "pliant_descriptor" { size, kind, flags, id, name, version, summary, params, param_count, param_size }
        Limits = "pliant_limits" { size, dt }
        Plugin = "pliant_plugin" { size, descriptor, data, destroy, set_number, set_text, set_table, activate, deactivate, extension }
        Library = "pliant_library" { size, abi_major, abi_minor, init, descriptor, create }
        ElementRequest = "pliant_element_request" { size, kind, families, flags, rest_stride, history_stride }
        Batch = "pliant_batch" { size, kind, corners, begin, end, count, node_begin, node_end, nodes, elements, family, measure, material, rest, x, v, rest_data, history, time, dt, rest_stride, history_stride, field_count, fields }
        Blocks = "pliant_blocks" { size, values, slots, slot_begin, slot_end }
        Material = "pliant_material" { size, elements, rest, mass, energy, forces, tangent, product, advance }
        Coupled = "pliant_coupled" { size, strain, compliance }
        Normals = "pliant_normals" { size, energy, forces, tilt }
        SingleBlocks = "pliant_single_blocks" { size, values, slots, slot_begin, slot_end }
        Single = "pliant_single" { size, tangent }
        Failure = "pliant_failure" { size, failed }
        Directions = "pliant_directions" { size, rest }
        Sources = "pliant_sources" { size, source }
        Surface = "pliant_surface" { size, points, point_count, triangles, triangle_count }
        Level = "pliant_level" { size, level, cells_per_axis, edge, origin, surface_cells, inside_cells, nodes }
        Cell = "pliant_cell" { size, id, parent, children, index, state, reference, centre, edge, point_begin, point_end }
        Ball = "pliant_ball" { centre, radius }
        RegionRequest = "pliant_region_request" { size, level, families, balls, ball_count, cells, cell_count }
        Region = "pliant_region" { size, node_capacity, node_count, node_id, node_rest, node_measure, node_border, cell_capacity, cell_count, cell_id, cell_corners, cell_points, cell_state, link_capacity, link_count, link_nodes, link_family, link_measure }
        Grid = "pliant_grid" { size, build, level, cell, locate, points, region, weights, place, pull_back }
        ContactRequest = "pliant_contact_request" { size, flags, history_stride, reach }
        ContactBatch = "pliant_contact_batch" { size, begin, end, count, gap, gap_rate, slip, slip_rate, area, history, history_stride, time, dt }
        Traction = "pliant_traction" { size, normal, normal_by_gap, normal_by_gap_rate, tangential, tangential_by_slip, tangential_by_slip_rate }
        ContactLaw = "pliant_contact_law" { size, request, tractions, advance }
        DeviceInfo = "pliant_device_info" { size, effectors, buttons, driven_axes, taxel_rows, taxel_columns, rate, peak_force, continuous_force, stiffness, damping, resolution, workspace, taxel_pitch, taxel_force, peak_torque }
        Pose = "pliant_pose" { size, time_ns, flags, buttons, position, orientation, velocity }
        Output = "pliant_output" { size, force, torque, taxels, valid_until_ns }
        Device = "pliant_device" { size, describe, read, write, stop }
        Rendered = "pliant_rendered" { size, rendered }
        Counters = "pliant_counters" { size, counter }
        Probe = "pliant_probe" { size, probe }
    }
    out
}

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn rust_matches_the_golden() {
    let path = folder().join("tests/layout.txt");
    if std::env::var_os("PLIANT_MINT").is_some() {
        std::fs::write(&path, rust_layout()).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap();
    assert_eq!(golden, rust_layout(), "the Rust side of the border moved; see the head of this file");
}

/// A C file that compiles only if the header has the layout of `golden`.
fn c_assertions(golden: &str) -> String {
    let mut c = String::from("#include \"pliant.h\"\n");
    for line in golden.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            [name, "size", size, "align", align] => {
                writeln!(c, "_Static_assert(sizeof({name}) == {size}, \"{line}\");").unwrap();
                writeln!(c, "_Static_assert(_Alignof({name}) == {align}, \"{line}\");").unwrap();
            }
            [name, "value", value] => {
                writeln!(c, "_Static_assert({name} == {value}, \"{line}\");").unwrap();
            }
            [place, offset] => {
                let (name, field) = place.split_once('.').unwrap();
                writeln!(c, "_Static_assert(offsetof({name}, {field}) == {offset}, \"{line}\");").unwrap();
            }
            _ => panic!("golden line not understood: {line}"),
        }
    }
    c
}

fn compiles(c: &str) -> Option<bool> {
    let file = std::env::temp_dir().join(format!("pliant-layout-{}-{}.c", std::process::id(), c.len()));
    std::fs::write(&file, c).unwrap();
    let status = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I"])
        .arg(folder().join("include"))
        .arg(&file)
        .output();
    let _ = std::fs::remove_file(&file);
    status.ok().map(|o| o.status.success())
}

#[test]
fn header_matches_the_golden() {
    let golden = std::fs::read_to_string(folder().join("tests/layout.txt")).unwrap();
    let Some(good) = compiles(&c_assertions(&golden)) else {
        eprintln!("skipped: no C compiler named `cc`");
        return;
    };
    assert!(good, "include/pliant.h does not have the layout of tests/layout.txt");
    for (right, wrong) in [("pliant_batch.nodes 56", "pliant_batch.nodes 64"), ("LISTS value 4", "LISTS value 8")] {
        let broken = golden.replace(right, wrong);
        assert_ne!(broken, golden, "the broken golden must differ");
        assert_eq!(compiles(&c_assertions(&broken)), Some(false), "{wrong} must not compile");
    }
}
