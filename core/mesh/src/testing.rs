//! What the mesh tests share: repeatable randomness, and the sample models that may or may not be on this machine.

use std::path::{Path, PathBuf};

use crate::ObjDocument;

/// SplitMix64: the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to `bound - 1`.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.next_u64() % bound
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of `from`, which must not be empty.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u64) as usize]
    }
}

/// Parses `text` as the file `test.obj`.
pub fn document(text: &str) -> ObjDocument {
    ObjDocument::parse(text.as_bytes().to_vec(), Path::new("test.obj")).unwrap()
}

/// A document without some of its faces.
pub fn without(whole: &ObjDocument, faces: &[usize]) -> ObjDocument {
    let mut face = 0;
    let text = String::from_utf8(whole.bytes().to_vec()).unwrap();
    let keep = |line: &&str| {
        face += usize::from(line.starts_with("f "));
        !(line.starts_with("f ") && faces.contains(&(face - 1)))
    };
    document(&text.lines().filter(keep).collect::<Vec<_>>().join("\n"))
}

/// The sample models beside the checkout; none where there are none.
#[allow(clippy::print_stderr, reason = "a skipped trial should be seen")]
pub fn shared_models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/meshes");
    let Ok(entries) = folder.read_dir() else {
        eprintln!("skipped: no sample models in {}", folder.display());
        return Vec::new();
    };
    let mut models: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    models.retain(|path| path.extension().is_some_and(|ext| ext == "obj"));
    models.sort();
    models
}
