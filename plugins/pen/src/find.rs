//! Finding pens among the input devices of the system, without opening any.

use crate::event::BTN_TOOL_PEN;
use std::path::{Path, PathBuf};

/// An input device that can tell a pen near it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FoundPen {
    /// Its file, as `/dev/input/event5`.
    pub path: PathBuf,
    /// Its name, as the driver gives it.
    pub name: String,
}

/// Folder in which the system describes its input devices.
pub(crate) const CLASS: &str = "/sys/class/input";
/// Folder of the files of input devices.
pub(crate) const FILES: &str = "/dev/input";

/// The pens that `class` describes, whose files are in `files`, in the order of their numbers.
pub(crate) fn pens(class: &Path, files: &Path) -> Vec<FoundPen> {
    let entries = std::fs::read_dir(class).into_iter().flatten().flatten();
    let mut found: Vec<(u32, FoundPen)> = entries
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let number = name.strip_prefix("event")?.parse().ok()?;
            let text = |file: &str| std::fs::read_to_string(entry.path().join("device").join(file)).ok();
            has_bit(&text("capabilities/key")?, BTN_TOOL_PEN).then_some(())?;
            let title = text("name").unwrap_or_default().trim().to_owned();
            Some((number, FoundPen { path: files.join(name), name: title }))
        })
        .collect();
    found.sort_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, pen)| pen).collect()
}

/// Whether a bit is set in a mask as the kernel writes it: words in hexadecimal, the highest first.
fn has_bit(mask: &str, bit: u16) -> bool {
    let bits = usize::BITS as usize;
    let word = mask.split_whitespace().rev().nth(bit as usize / bits);
    let word = word.and_then(|word| usize::from_str_radix(word, 16).ok()).unwrap_or_default();
    word >> (bit as usize % bits) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pen_is_found_by_what_it_can_do() {
        let folder = tempfile::tempdir().unwrap();
        let describe = |event: &str, name: &str, keys: &str| {
            let device = folder.path().join(event).join("device");
            std::fs::create_dir_all(device.join("capabilities")).unwrap();
            std::fs::write(device.join("name"), format!("{name}\n")).unwrap();
            std::fs::write(device.join("capabilities/key"), format!("{keys}\n")).unwrap();
        };
        // What a keyboard, a mouse and two tablets say on a machine of 64 bits.
        describe("event0", "AT Keyboard", "402000000 3803078f800d001 feffffdfffefffff fffffffffffffffe");
        describe("event3", "Mouse", "1f0000 0 0 0 0");
        describe("event12", "Wacom Intuos S Pen", "1c03 0 0 0 0 0");
        describe("event4", "Wacom Bamboo Pen", "1c43 0 0 0 0 0");
        std::fs::create_dir_all(folder.path().join("mouse0")).unwrap();
        let found = pens(folder.path(), Path::new("/dev/input"));
        let names: Vec<_> = found.iter().map(|pen| (pen.path.to_str().unwrap(), pen.name.as_str())).collect();
        if cfg!(target_pointer_width = "64") {
            assert_eq!(
                names,
                [("/dev/input/event4", "Wacom Bamboo Pen"), ("/dev/input/event12", "Wacom Intuos S Pen")]
            );
        }
        assert_eq!(pens(Path::new("/nowhere"), Path::new("/dev/input")), []);
    }
}
