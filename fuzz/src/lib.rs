//! What each fuzz target does with its bytes. A target must not panic, whatever they are.

use pliant_batch::Sweep;
use pliant_engine::scene;
use pliant_exoskeleton::key::Key;
use pliant_exoskeleton::wire::{TaxelLayout, read_command, read_pose};
use pliant_mesh::{GreyImage, ObjDocument, Surface, TetMesh, check};
use pliant_record::Recording;
use std::path::Path;

/// Largest number of faces to which a model is subdivided.
const MOST_FACES: usize = 10_000;

/// A model: what is read is written back byte for byte, can be looked at, and subdivided.
pub fn obj(bytes: &[u8]) {
    let Ok(document) = ObjDocument::parse(bytes.to_vec(), Path::new("fuzzed.obj")) else { return };
    let mut out = Vec::new();
    document.write(document.positions(), Some(document.normals()), &mut out).expect("a Vec takes everything");
    assert!(out == bytes, "an unedited document changed");
    let surface = Surface::from_document(&document);
    check(&surface, &document);
    let faces = document.faces_subdivided();
    if faces <= MOST_FACES {
        let fine = document.subdivided().expect("it is read again");
        assert!(fine.face_count() == faces && fine.positions().starts_with(document.positions()));
    }
}

/// A tetrahedral mesh: what is read has positive volumes and a boundary that is a model, and is read again as it is written.
pub fn tetrahedra(bytes: &[u8]) {
    let Ok(mesh) = TetMesh::parse(bytes, Path::new("fuzzed.msh")) else { return };
    assert!(
        mesh.tetrahedra.iter().all(|nodes| TetMesh::six_volumes(&mesh.points, *nodes) > 0.0),
        "an inverted tetrahedron"
    );
    let document = mesh.surface().expect("a boundary");
    assert_eq!(document.positions().len(), mesh.vertices().len());
    let mut out = Vec::new();
    mesh.write_vtk(&mesh.points, None, &mut out).expect("a Vec takes everything");
    let again = TetMesh::parse(&out, Path::new("written.vtk")).expect("it is read again");
    let is_same = again.tetrahedra == mesh.tetrahedra && again.quadratic == mesh.quadratic;
    assert!(again.points == mesh.points && is_same, "a written mesh changed");
}

/// An image: what is read has values from 0 to 1 at all texture coordinates.
pub fn image(bytes: &[u8]) {
    let Ok(image) = GreyImage::parse(bytes) else { return };
    for at in [[0.0, 0.0], [1.0, 1.0], [-1e-18, 1e18], [0.3, -7.7]] {
        assert!((0.0..=1.0).contains(&image.sample(at)), "{at:?}");
    }
}

/// A scene file.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Err(error) = scene::load_text(Path::new("fuzzed.toml"), text.to_owned(), &[]) {
        assert!(!error.to_string().is_empty());
    }
}

/// A file of a batch. Its base scenes are looked for beside it, where there are none.
pub fn sweep(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Err(error) = Sweep::parse(Path::new("no-such-folder/fuzzed.toml"), text.to_owned()) {
        assert!(!error.to_string().is_empty());
    }
}

/// A journal of a batch, as it is and with checksums that match: what is read of it is a journal, and nothing after what is damaged is read.
pub fn journal(bytes: &[u8]) {
    let mut sealed = Vec::new();
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        let json = line.get(9..).unwrap_or_default();
        sealed.extend(format!("{:08x} ", crc32(json.strip_suffix(b"\n").unwrap_or(json))).bytes());
        sealed.extend(json);
    }
    for bytes in [bytes, &sealed] {
        let (records, length) = pliant_batch::testing::parse_journal(bytes);
        let lines = bytes[..length].iter().filter(|byte| **byte == b'\n').count();
        assert_eq!(lines, records, "a record is a line");
        assert_eq!(pliant_batch::testing::parse_journal(&bytes[..length]), (records, length));
    }
}

/// A recording of a session.
pub fn recording(bytes: &[u8]) {
    if let Ok(recording) = Recording::parse(bytes, Path::new("fuzzed.rec")) {
        let shape = recording.steps.first().map(|step| step.device_forces.len());
        assert!(recording.steps.iter().all(|step| Some(step.device_forces.len()) == shape), "steps differ in shape");
    }
}

/// A datagram of the exoskeleton, as it is and with a matching checksum, so that the checks after the checksum are reached too.
pub fn datagram(bytes: &[u8]) {
    let (layout, key) = (TaxelLayout { rows: 5, columns: 6 }, Key::new(&[7; 16]));
    let mut sealed = bytes.to_vec();
    if let Some((content, checksum)) = sealed.split_last_chunk_mut::<4>() {
        *checksum = crc32(content).to_le_bytes();
    }
    for bytes in [bytes, &sealed] {
        for key in [None, Some(&key)] {
            if let Ok((header, fingers)) = read_pose(bytes, layout, key) {
                assert!(header.sender_nonce != 0 && fingers.iter().all(|f| f.position.iter().all(|x| x.is_finite())));
            }
            if let Ok((header, fingers)) = read_command(bytes, layout, key) {
                assert!(header.sender_nonce != 0 && fingers.iter().all(|f| f.force.iter().all(|x| x.is_finite())));
            }
        }
    }
}

/// A number with a unit: what is accepted is finite.
pub fn quantity(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for si in ["m", "Pa", "N s/m", "rad", "1", "no unit"] {
        if let Ok(value) = scene::parse_quantity(text, si) {
            assert!(value.is_finite(), "{text:?} is {value} {si}");
        }
    }
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}
