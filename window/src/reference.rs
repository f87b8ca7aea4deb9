//! A reference image: a picture that stands behind the model, to sculpt after.

use crate::materials::{MAX_EDGE, read_image};
use crate::strings;
use crate::view::Camera;
use eframe::egui;
use image::RgbaImage;
use image::imageops::FilterType;
use nalgebra::Vector3;
use pliant_record::AtomicFile;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Where the image stands, always on the far side of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReferencePlane {
    /// Seen from +z (y up) or -y (z up).
    Front,
    /// Seen from +x.
    Side,
    /// Seen from above.
    Top,
    /// Turns with the viewer.
    Behind,
}

impl ReferencePlane {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Front, Self::Side, Self::Top, Self::Behind];
}

/// How an image is shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceSettings {
    /// Absolute path of the PNG or JPEG.
    pub path: PathBuf,
    /// Whether it is shown.
    pub visible: bool,
    /// Where it stands.
    pub plane: ReferencePlane,
    /// 0 to 1.
    pub opacity: f32,
    /// Height of the image in the scene, mm.
    pub height: f64,
    /// To the right and up in the plane from the middle of the model, mm.
    pub offset: [f64; 2],
}

impl ReferenceSettings {
    /// An image beside a model whose longest edge is `size` (m): as high as the model is long.
    pub fn new(path: &Path, size: f64) -> Self {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let (plane, offset) = (ReferencePlane::Front, [0.0; 2]);
        Self { path, visible: true, plane, opacity: 0.6, height: 1e3 * size, offset }
    }
}

/// An image that has been read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceImage {
    /// How it is shown.
    pub settings: ReferenceSettings,
    /// Its pixels, top row first; at most [`MAX_EDGE`] along an edge.
    pub pixels: Arc<RgbaImage>,
}

/// A picture in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceQuad {
    /// Lower left, lower right, upper left and upper right corner, m.
    pub corners: [[f32; 3]; 4],
    /// 0 to 1.
    pub opacity: f32,
}

/// Gap between model and image, in radii of the model.
const GAP: f64 = 0.05;

impl ReferenceImage {
    /// Reads the image that the settings name.
    ///
    /// # Errors
    /// A sentence that names the file and what is wrong with it.
    pub fn read(settings: ReferenceSettings) -> Result<Self, String> {
        let path = &settings.path;
        let image = read_image(path).map_err(|why| strings::reference_problem(path, &why))?;
        let image = if image.width().max(image.height()) > MAX_EDGE {
            image.resize(MAX_EDGE, MAX_EDGE, FilterType::Triangle)
        } else {
            image
        };
        Ok(Self { settings, pixels: Arc::new(image.into_rgba8()) })
    }

    /// The image behind a model within the box `bounds` (m), for a viewer; `None` where it is hidden.
    pub fn quad(&self, camera: &Camera, bounds: [Vector3<f64>; 2]) -> Option<ReferenceQuad> {
        let ReferenceSettings { plane, opacity, height, offset, visible, .. } = self.settings;
        // Right and up in the picture, in axes with y up.
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let [right, up] = match plane {
            ReferencePlane::Front => [x, y],
            ReferencePlane::Side => [-z, y],
            ReferencePlane::Top => [x, -z],
            ReferencePlane::Behind => [camera.axes()[0], camera.axes()[1]],
        };
        let [right, up] = match plane {
            ReferencePlane::Behind => [right, up],
            _ => [camera.to_scene(right), camera.to_scene(up)],
        };
        let towards = right.cross(&up);
        let (centre, half) = (0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[1] - bounds[0]));
        // Half the depth of the box along the line of sight.
        let depth = half.dot(&towards.abs()) + GAP * half.norm();
        let half_height = 0.5e-3 * height;
        let half_width = half_height * f64::from(self.pixels.width()) / f64::from(self.pixels.height().max(1));
        let middle = centre - depth * towards + 1e-3 * (offset[0] * right + offset[1] * up);
        let corner = |across: f64, along: f64| {
            (middle + across * half_width * right + along * half_height * up).map(|c| c as f32).into()
        };
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)];
        visible.then_some(ReferenceQuad { corners, opacity })
    }
}

/// Reading of an image on a thread of its own: a large one takes longer than a frame.
pub struct ReferenceLoad {
    receiver: Receiver<Result<ReferenceImage, String>>,
    /// Of the image, for errors.
    path: PathBuf,
}

/// Asks for a frame when it goes, also where the thread that has it panics.
struct FrameAtEnd(egui::Context);

impl Drop for FrameAtEnd {
    fn drop(&mut self) {
        self.0.request_repaint();
    }
}

impl ReferenceLoad {
    /// Begins to read. A frame is asked for when it is done.
    pub fn start(settings: ReferenceSettings, context: egui::Context) -> Self {
        let path = settings.path.clone();
        Self::of_work(path, context, move || ReferenceImage::read(settings))
    }

    fn of_work(
        path: PathBuf,
        context: egui::Context,
        work: impl FnOnce() -> Result<ReferenceImage, String> + Send + 'static,
    ) -> Self {
        let (sender, receiver) = channel();
        let end = FrameAtEnd(context);
        let read = move || {
            // The sender goes before the frame is asked for.
            let (_end, sender) = (end, sender);
            // A window that has gone needs none.
            let _ = sender.send(work());
        };
        if let Err(error) = std::thread::Builder::new().name("reference".into()).spawn(read) {
            let (sender, receiver) = channel();
            // The receiver is here.
            let _ = sender.send(Err(strings::reference_problem(&path, &strings::no_reader(&error))));
            return Self { receiver, path };
        }
        Self { receiver, path }
    }

    /// The image, or a sentence why it cannot be read, once it is known.
    pub fn take(&self) -> Option<Result<ReferenceImage, String>> {
        match self.receiver.try_recv() {
            Ok(read) => Some(read),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err(strings::reference_problem(&self.path, &strings::READER_FAILED)))
            }
        }
    }
}

/// Whether a file is taken for an image, by the ending of its name.
pub fn is_image(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ["png", "jpg", "jpeg"].contains(&ending.as_str())
}

/// Name of the file with the images of all models, beside their autosaves.
const FILE: &str = "references.json";

/// The images that were last shown with models, by the absolute path of the model.
fn read_all(folder: &Path) -> io::Result<BTreeMap<PathBuf, ReferenceSettings>> {
    let path = folder.join(FILE);
    let wrong = |error: &dyn std::fmt::Display| io::Error::other(format!("{}: {error}", path.display()));
    match std::fs::read(&path) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| wrong(&strings::to_mend(&error))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(BTreeMap::new()),
        Err(error) => Err(wrong(&error)),
    }
}

/// The image that was last shown with a model; `None` where there was none.
///
/// # Errors
/// A file that cannot be read or is damaged, with its path, line and column.
pub fn remembered(folder: &Path, model: &Path) -> io::Result<Option<ReferenceSettings>> {
    Ok(read_all(folder)?.remove(&std::path::absolute(model)?))
}

/// Remembers the image of a model for the next time, or that it has none.
///
/// # Errors
/// That of the file system, with the path. A damaged file is left as it is.
pub fn remember(folder: &Path, model: &Path, settings: Option<&ReferenceSettings>) -> io::Result<()> {
    let (mut all, model) = (read_all(folder)?, std::path::absolute(model)?);
    match settings {
        Some(settings) => _ = all.insert(model, settings.clone()),
        None => _ = all.remove(&model),
    }
    let mut file = AtomicFile::create_and_clean(&folder.join(FILE))?;
    file.write_all(&serde_json::to_vec_pretty(&all)?)?;
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::UpAxis;

    fn image(plane: ReferencePlane) -> ReferenceImage {
        let settings = ReferenceSettings {
            plane,
            height: 100.0,
            offset: [10.0, -20.0],
            ..ReferenceSettings::new(Path::new("a.png"), 1.0)
        };
        ReferenceImage { settings, pixels: Arc::new(RgbaImage::new(40, 20)) }
    }

    /// On the far side of the box, of the right size, and upright as the viewer from there sees it.
    #[test]
    fn an_image_stands_behind_the_model_and_faces_the_viewer() {
        let bounds = [Vector3::new(-0.1, -0.2, -0.3), Vector3::new(0.3, 0.2, 0.1)];
        let centre = Vector3::new(0.1, 0.0, -0.1);
        let quarter = std::f64::consts::FRAC_PI_2;
        for up in [UpAxis::Y, UpAxis::Z] {
            for (plane, yaw, pitch) in [
                (ReferencePlane::Front, 0.0, 0.0),
                (ReferencePlane::Side, quarter, 0.0),
                (ReferencePlane::Top, 0.0, quarter),
                (ReferencePlane::Behind, 0.7, 0.4),
            ] {
                let camera = Camera { up, yaw, pitch, ..Camera::default() };
                let quad = image(plane).quad(&camera, bounds).expect("it is shown");
                let [low_left, low_right, up_left, _] = quad.corners.map(|c| Vector3::from(c.map(f64::from)) - centre);
                let [right, above, back] = camera.axes();
                let near = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 1e-6;
                assert!(
                    near(low_right - low_left, 0.2 * right) && near(up_left - low_left, 0.1 * above),
                    "{plane:?} {up:?}"
                );
                let middle = 0.5 * (low_right + up_left);
                assert!(
                    (middle.dot(&right) - 0.01).abs() < 1e-6 && (middle.dot(&above) + 0.02).abs() < 1e-6,
                    "{plane:?}"
                );
                let corners = (0..8).map(|c| Vector3::from_fn(|axis, _| bounds[c >> axis & 1][axis]) - centre);
                let farthest = corners.map(|corner| corner.dot(&back)).fold(f64::INFINITY, f64::min);
                assert!(middle.dot(&back) < farthest && middle.dot(&back) > 1.3 * farthest, "{plane:?}");
            }
        }
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("broken.png");
        let said = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            ReferenceImage::read(ReferenceSettings::new(&path, 0.1)).expect_err("it is broken")
        };
        let mut png = Vec::new();
        RgbaImage::new(9, 5).write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
        for text in [said(b"no image"), said(&png[..png.len() / 2]), said(b"")] {
            assert!(text.contains("broken.png") && text.contains("allowed are PNG and JPEG"), "{text}");
        }
        let gone =
            ReferenceImage::read(ReferenceSettings::new(Path::new("gone.png"), 0.1)).expect_err("it is not there");
        assert!(gone.contains("gone.png") && gone.contains("No such file"), "{gone}");
        std::fs::write(&path, &png).unwrap();
        assert_eq!(ReferenceImage::read(ReferenceSettings::new(&path, 0.1)).unwrap().pixels.dimensions(), (9, 5));
    }

    #[test]
    fn the_image_of_each_model_is_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let states = folder.path().join("states");
        let of = |name| ReferenceSettings { height: 12.5, ..ReferenceSettings::new(Path::new(name), 0.1) };
        remember(&states, Path::new("a.obj"), Some(&of("a.png"))).unwrap();
        remember(&states, Path::new("b.obj"), Some(&of("b.png"))).unwrap();
        assert_eq!(remembered(&states, Path::new("a.obj")).unwrap(), Some(of("a.png")));
        remember(&states, Path::new("a.obj"), None).unwrap();
        assert_eq!(remembered(&states, Path::new("a.obj")).unwrap(), None);
        assert_eq!(remembered(&states, Path::new("b.obj")).unwrap(), Some(of("b.png")));
    }

    #[test]
    fn a_damaged_file_is_named_and_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(FILE);
        std::fs::write(&file, "{\n\"a").unwrap();
        let settings = ReferenceSettings::new(Path::new("a.png"), 0.1);
        let read = remembered(folder.path(), Path::new("a.obj")).map(|_| ());
        for said in [read, remember(folder.path(), Path::new("a.obj"), Some(&settings))] {
            let said = said.expect_err("it is damaged").to_string();
            assert!(said.contains(FILE) && said.contains("line 2") && said.contains("remove it"), "{said}");
        }
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "{\n\"a");
    }

    #[test]
    fn a_thread_that_panics_is_an_error() {
        let load = ReferenceLoad::of_work("a.png".into(), egui::Context::default(), || panic!("of the test"));
        let read = std::iter::repeat_with(|| load.take()).inspect(|_| std::thread::yield_now()).flatten().next();
        let said = read.expect("it never ends").expect_err("it panicked");
        assert!(said.contains("a.png") && said.contains("error in the program"), "{said}");
    }
}
