//! Colours and textures of a model's materials, as its MTL files give them.

use crate::strings;
use eframe::egui;
use image::{DynamicImage, ImageReader, Limits, RgbaImage, imageops};
use pliant_engine::body::Model;
use pliant_mesh::ObjDocument;
use pliant_mesh::materials::find_materials_in;
use pliant_mesh::read::{IMAGE_LIMIT, read_file};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

/// Look of the materials of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMaterials {
    /// For each material of the document, its colour; `None` where no library gives one.
    pub looks: Vec<Option<MaterialLook>>,
    /// The textures, all of one size, with the top row first.
    pub images: Vec<RgbaImage>,
}

/// Look of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialLook {
    /// One colour: red, green, blue, 0 to 1.
    Colour([f32; 3]),
    /// A texture, as an index into the images. The colour of the material does not count, for many programs write black beside a texture.
    Texture(usize),
}

/// Most memory that decoding an image may take, bytes.
const DECODING_LIMIT: u64 = 1 << 30;
/// Largest edge of a texture, pixels.
pub(crate) const MAX_EDGE: u32 = 2048;
/// Most memory for the textures of a body, bytes.
const MAX_BYTES: usize = 1 << 28;

impl SurfaceMaterials {
    /// Reads the materials of a document whose `mtllib` files are in `folder`. Each sentence of the list says what cannot be read.
    pub fn read(document: &ObjDocument, folder: &Path) -> (Self, Vec<String>) {
        let (uses, warnings) = find_materials_in(document, folder);
        let mut problems: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let (mut images, mut known) = (Vec::new(), HashMap::<PathBuf, Option<usize>>::new());
        let mut texture = |path: &PathBuf| {
            *known.entry(path.clone()).or_insert_with(|| match read_image(path) {
                Ok(image) => {
                    images.push(image);
                    Some(images.len() - 1)
                }
                Err(why) => {
                    problems.push(strings::texture_problem(path, &why));
                    None
                }
            })
        };
        let look = |material: &pliant_mesh::materials::MaterialUse| {
            let texture = material.diffuse_texture.as_ref().and_then(&mut texture).map(MaterialLook::Texture);
            texture.or(material.diffuse.map(MaterialLook::Colour))
        };
        let looks = uses.iter().map(look).collect();
        (Self { looks, images: to_one_size(images) }, problems)
    }
}

/// Reads a PNG or JPEG image.
pub(crate) fn read_image(path: &Path) -> Result<DynamicImage, String> {
    let bytes = read_file(path, IMAGE_LIMIT).map_err(|error| error.to_string())?;
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(DECODING_LIMIT);
    reader.limits(limits);
    reader.decode().map_err(|error| strings::image_problem(&error))
}

/// Scales images to the size of the largest one, which is made smaller where all together would take too much memory.
fn to_one_size(images: Vec<DynamicImage>) -> Vec<RgbaImage> {
    let edge = |of: fn(&DynamicImage) -> u32| images.iter().map(of).max().unwrap_or(1).clamp(1, MAX_EDGE);
    let (mut width, mut height) = (edge(DynamicImage::width), edge(DynamicImage::height));
    while images.len() * width as usize * height as usize * 4 > MAX_BYTES && width.min(height) > 1 {
        (width, height) = (width / 2, height / 2);
    }
    let scale = |image: DynamicImage| {
        if (image.width(), image.height()) == (width, height) {
            return image.into_rgba8();
        }
        imageops::resize(&image.into_rgba8(), width, height, imageops::FilterType::Triangle)
    };
    images.into_iter().map(scale).collect()
}

/// Reading of the materials of all bodies on a thread of its own: a large image takes longer than a frame.
pub struct MaterialLoad(Receiver<Vec<(SurfaceMaterials, Vec<String>)>>);

impl MaterialLoad {
    /// Begins to read the materials of models, whose `mtllib` files are in `folder` or, for `None`, beside each model. A frame is asked for when they are
    /// there. Without a thread none are read.
    pub fn start(models: Vec<Arc<Model>>, folder: Option<PathBuf>, context: egui::Context) -> Self {
        let (sender, receiver) = channel();
        let read = move || {
            let of_model = |model: &Arc<Model>| {
                let beside = model.document.name().parent().unwrap_or(Path::new(""));
                SurfaceMaterials::read(&model.document, folder.as_deref().unwrap_or(beside))
            };
            // A window that has gone needs none.
            let _ = sender.send(models.iter().map(of_model).collect());
            context.request_repaint();
        };
        let _ = std::thread::Builder::new().name("materials".into()).spawn(read);
        Self(receiver)
    }

    /// The materials of each body with what cannot be read of them, once they are there.
    pub fn take(&self) -> Option<Vec<(SurfaceMaterials, Vec<String>)>> {
        self.0.try_recv().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A library of three materials: a PNG, a JPEG of another size, and one whose image is not there.
    #[test]
    fn textures_get_one_size_and_what_is_missing_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str, width, height, colour| {
            let image = image::RgbImage::from_pixel(width, height, image::Rgb(colour));
            image.save(folder.path().join(name)).unwrap();
        };
        save("red.png", 8, 4, [255, 0, 0]);
        save("blue.jpg", 4, 16, [0, 0, 255]);
        let library = "newmtl a\nKd 0 0 0\nmap_Kd red.png\nnewmtl b\nmap_Kd blue.jpg\nnewmtl c\nKd 0 1 0\nmap_Kd gone.png\nnewmtl d\nmap_Kd red.png\n";
        std::fs::write(folder.path().join("m.mtl"), library).unwrap();
        let face = |name: &str| format!("usemtl {name}\nf 1 2 3\n");
        let faces: String = ["a", "b", "c", "d"].map(face).concat();
        let text = format!("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
        let document = ObjDocument::parse(text.into(), Path::new("copy.obj")).unwrap();
        let (materials, problems) = SurfaceMaterials::read(&document, folder.path());
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert!(problems[0].contains("gone.png"), "{problems:?}");
        let texture = |index| Some(MaterialLook::Texture(index));
        let green = Some(MaterialLook::Colour([0.0, 1.0, 0.0]));
        assert_eq!(materials.looks, [texture(0), texture(1), green, texture(0)]);
        assert!(materials.images.iter().all(|image| image.dimensions() == (8, 16)));
        assert_eq!(materials.images[0].get_pixel(3, 7).0, [255, 0, 0, 255]);
        let [r, _, b, _] = materials.images[1].get_pixel(3, 7).0;
        assert!(b > 240 && r < 20, "JPEG is nearly blue");
    }
}
