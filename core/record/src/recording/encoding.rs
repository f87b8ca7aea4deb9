//! Encoding of poses, devices, timeouts and commands as little-endian bytes. `pliant_engine::recording` decodes them.

use pliant_engine::recording::format::command_code;
use pliant_engine::session::{SessionCommand, Stage, StepTimeout};
use pliant_host::{DeviceInfo, Pose};

/// Appends numbers, 8 bytes each.
pub(super) fn put_numbers(out: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
}

/// Appends a pose: time, flags, buttons, position, orientation, velocity.
pub(super) fn put_pose(out: &mut Vec<u8>, pose: &Pose) {
    out.extend_from_slice(&pose.time_ns.to_le_bytes());
    out.extend_from_slice(&pose.flags.to_le_bytes());
    out.extend_from_slice(&pose.buttons.to_le_bytes());
    put_numbers(out, &pose.position);
    put_numbers(out, &pose.orientation);
    put_numbers(out, &pose.velocity);
}

/// Appends a device: its counts, limits, workspace and peak torque (N m), then its name up to the end of the block.
pub(super) fn put_device(out: &mut Vec<u8>, name: &str, info: &DeviceInfo) {
    let counts = [info.effectors, info.buttons, info.driven_axes, info.taxel_rows, info.taxel_columns];
    counts.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
    put_numbers(out, &limits(info));
    put_numbers(out, &info.workspace);
    put_numbers(out, &[info.peak_torque]);
    out.extend_from_slice(name.as_bytes());
}

/// The limits of a device except workspace and peak torque, in the order of the file.
fn limits(f: &DeviceInfo) -> [f64; 8] {
    [f.rate, f.peak_force, f.continuous_force, f.stiffness, f.damping, f.resolution, f.taxel_pitch, f.taxel_force]
}

/// Appends a timeout: step, body and stage, then its reason up to the end of the block.
pub(super) fn put_timeout(out: &mut Vec<u8>, timeout: &StepTimeout) {
    out.extend_from_slice(&timeout.step.to_le_bytes());
    out.extend_from_slice(&timeout.body.to_le_bytes());
    out.push(match timeout.stage {
        Stage::Region => 0,
        Stage::Step => 1,
        Stage::Interrupted => 2,
    });
    out.extend_from_slice(timeout.why.as_bytes());
}

/// Appends a command: its kind, then its numbers, then a name up to the end of the block.
pub(super) fn put_command(out: &mut Vec<u8>, command: &SessionCommand) {
    match command {
        SessionCommand::Undo => out.push(command_code::UNDO),
        SessionCommand::Redo => out.push(command_code::REDO),
        SessionCommand::ResizeTools { radius, coupling } => {
            out.push(command_code::RESIZE_TOOLS);
            put_numbers(out, &[*radius, *coupling]);
        }
        SessionCommand::SetStiffness { factor } => {
            out.push(command_code::SET_STIFFNESS);
            put_numbers(out, &[*factor]);
        }
        SessionCommand::AddLayer { name } => {
            out.push(command_code::ADD_LAYER);
            out.extend_from_slice(name.as_bytes());
        }
        SessionCommand::RenameLayer { layer, name } => {
            out.push(command_code::RENAME_LAYER);
            out.extend_from_slice(&layer.to_le_bytes());
            out.extend_from_slice(name.as_bytes());
        }
        SessionCommand::RecordLayer { layer: None } => out.extend_from_slice(&[command_code::RECORD_LAYER, 0]),
        SessionCommand::RecordLayer { layer: Some(layer) } => {
            out.extend_from_slice(&[command_code::RECORD_LAYER, 1]);
            out.extend_from_slice(&layer.to_le_bytes());
        }
        SessionCommand::SetLayerStrength { layer, strength } => {
            out.push(command_code::SET_LAYER_STRENGTH);
            out.extend_from_slice(&layer.to_le_bytes());
            put_numbers(out, &[*strength]);
        }
        SessionCommand::MergeLayer { layer } => {
            out.push(command_code::MERGE_LAYER);
            out.extend_from_slice(&layer.to_le_bytes());
        }
        SessionCommand::DeleteLayer { layer } => {
            out.push(command_code::DELETE_LAYER);
            out.extend_from_slice(&layer.to_le_bytes());
        }
        SessionCommand::SplitBody { body, triangle } => {
            out.push(command_code::SPLIT_BODY);
            out.extend_from_slice(&body.to_le_bytes());
            out.push(u8::from(triangle.is_some()));
            out.extend_from_slice(&triangle.unwrap_or(0).to_le_bytes());
        }
        SessionCommand::SetBrush { strength, falloff } => {
            out.extend_from_slice(&[command_code::SET_BRUSH, *falloff as u8]);
            put_numbers(out, &[*strength]);
        }
        SessionCommand::SetSymmetry { axes, centre } => {
            let bits = (0..3).filter(|i| axes[*i]).fold(0, |bits, i| bits | 1_u8 << i);
            out.extend_from_slice(&[command_code::SET_SYMMETRY, bits]);
            put_numbers(out, centre.as_slice());
        }
    }
}
