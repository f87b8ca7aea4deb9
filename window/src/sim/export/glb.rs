//! Binary glTF 2.0: one file with all bodies that move, their materials and textures. Lengths are in metres.

use crate::strings;
use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Target, View};
use gltf::json::image::MimeType;
use gltf::json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::{Checked::Valid, USize64};
use gltf::json::{Accessor, Buffer, Image, Index, Material, Mesh, Node, Root, Scene, Texture, serialize, texture};
use pliant_editor::surface::ViewSurface;
use pliant_engine::body::{ABSENT, Body, CAP};
use pliant_engine::session::Session;
use pliant_live::BodyTopology;
use pliant_mesh::materials::{MaterialUse, find_materials_in};
use pliant_mesh::read::{IMAGE_LIMIT, read_file};
use pliant_record::AtomicFile;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Roughness of all surfaces, for MTL files say nothing of it.
const ROUGHNESS: f32 = 0.8;
/// Colour of faces that a cut has made, as the window shows them: red, green, blue, 0 to 1.
const CUT_COLOUR: [f32; 3] = [0.78, 0.30, 0.26];

/// Writes the bodies of a session that move. Gives a sentence for each material or texture that cannot be read.
///
/// # Errors
/// What the file system says, with the path, and a file of more than 4 GiB.
pub(super) fn write_glb(
    session: &Session,
    cap_material: &str,
    materials: Option<&Path>,
    path: &Path,
) -> io::Result<Vec<String>> {
    let mut file = GlbFile::default();
    let buffer = file.root.push(Buffer {
        byte_length: USize64(0),
        name: None,
        uri: None,
        extensions: None,
        extras: Default::default(),
    });
    let bodies = session.bodies.iter().map(|body| file.body(body, cap_material, materials)).collect();
    let scene = file.root.push(Scene { nodes: bodies, name: None, extensions: None, extras: Default::default() });
    file.root.scene = Some(scene);
    file.root.asset.generator = Some(format!("pliant {}", env!("CARGO_PKG_VERSION")));
    file.root.buffers[buffer.value()].byte_length = USize64::from(file.bytes.len());
    let text = serialize::to_string(&file.root).map_err(io::Error::other)?;
    // Header, head of each chunk, and both chunks filled up to four bytes.
    let length = 12 + 8 + text.len().next_multiple_of(4) + 8 + file.bytes.len();
    let too_long = || io::Error::other(strings::glb_too_large(path, length as u64));
    let length = u32::try_from(length).map_err(|_| too_long())?;
    let header = Header { magic: *b"glTF", version: 2, length };
    let glb = Glb { header, json: Cow::Owned(text.into_bytes()), bin: Some(Cow::Owned(file.bytes)) };
    let mut out = AtomicFile::create_and_clean(path)?;
    {
        let mut buffered = BufWriter::new(&mut out);
        glb.to_writer(&mut buffered).map_err(|error| io::Error::other(format!("{}: {error}", path.display())))?;
        buffered.flush()?;
    }
    out.finish()?;
    Ok(file.problems)
}

/// A file that is being put together.
#[derive(Default)]
struct GlbFile {
    root: Root,
    /// The binary chunk, a multiple of four bytes.
    bytes: Vec<u8>,
    problems: Vec<String>,
}

impl GlbFile {
    /// Adds a body as a node with a mesh: one primitive for each of its materials, all with the same vertices.
    fn body(&mut self, body: &Body, cap_material: &str, folder: Option<&Path>) -> Index<Node> {
        let model = &body.model;
        let origin = model.surface.bounds().centre();
        let positions = body.skin.x.iter().map(|x| (x - origin).map(|c| c as f32).into()).collect();
        let triangles = Arc::new((0..model.surface.triangles.len() as u32).map(|t| body.look(t)).collect::<Vec<_>>());
        let topology =
            BodyTopology { name: body.name.clone(), triangles: Arc::clone(&triangles), origin, positions, moves: true };
        let surface = ViewSurface::new(&topology);
        let mut corners: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for (look, corner) in triangles.iter().zip(surface.corners()) {
            let Some(look) = look else { continue };
            corners.entry(look.material).or_default().push(*corner);
        }
        let beside = model.document.name().parent().unwrap_or(Path::new(""));
        let (uses, warnings) = find_materials_in(&model.document, folder.unwrap_or(beside));
        self.problems.extend(warnings.iter().map(ToString::to_string));
        let is_sheet = body.discretization.sheet().is_some();
        let attributes = self.attributes(&surface);
        let mut images = HashMap::new();
        let primitives = corners.into_iter().map(|(material, corners)| {
            let material = match material {
                ABSENT => None,
                CAP => Some(self.material(&cap(cap_material), is_sheet, &mut images)),
                index => uses.get(index as usize).map(|used| self.material(used, is_sheet, &mut images)),
            };
            Primitive {
                attributes: attributes.clone(),
                indices: Some(self.indices(&corners)),
                material,
                mode: Valid(Mode::Triangles),
                targets: None,
                extensions: None,
                extras: Default::default(),
            }
        });
        let primitives = primitives.collect();
        let name = Some(body.name.clone());
        let mesh = Mesh { primitives, name: name.clone(), weights: None, extensions: None, extras: Default::default() };
        let mesh = Some(self.root.push(mesh));
        let translation = Some(origin.map(|c| c as f32).into());
        self.root.push(Node { mesh, name, translation, ..Node::default() })
    }

    /// Adds positions, normals and texture coordinates of the drawn vertices.
    fn attributes(
        &mut self,
        surface: &ViewSurface,
    ) -> BTreeMap<gltf::json::validation::Checked<Semantic>, Index<Accessor>> {
        let count = surface.drawn().len();
        let positions: Vec<[f32; 3]> = (0..count).map(|drawn| surface.position(drawn)).collect();
        let unit = |normal: &[f32; 3]| if *normal == [0.0; 3] { [0.0, 1.0, 0.0] } else { *normal };
        let normals: Vec<[f32; 3]> = surface.normals().iter().map(unit).collect();
        // The first row of an image is its top one here, and its bottom one in OBJ files.
        let texture: Vec<[f32; 2]> = surface.drawn().iter().map(|v| [v.texture[0], 1.0 - v.texture[1]]).collect();
        let fold = |start: f32, of: fn(f32, f32) -> f32| {
            positions.iter().fold([start; 3], |all, p| [0, 1, 2].map(|axis| of(all[axis], p[axis])))
        };
        let bounds = [fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max)];
        let places = self.accessor(bytemuck::cast_slice(&positions), count, Type::Vec3, Some(bounds));
        let normals = self.accessor(bytemuck::cast_slice(&normals), count, Type::Vec3, None);
        let texture = self.accessor(bytemuck::cast_slice(&texture), count, Type::Vec2, None);
        [(Semantic::Positions, places), (Semantic::Normals, normals), (Semantic::TexCoords(0), texture)]
            .into_iter()
            .map(|(semantic, accessor)| (Valid(semantic), accessor))
            .collect()
    }

    /// Adds the corners of triangles.
    fn indices(&mut self, corners: &[[u32; 3]]) -> Index<Accessor> {
        let view = self.view(bytemuck::cast_slice(corners), Some(Target::ElementArrayBuffer));
        self.root.push(accessor(view, 3 * corners.len(), ComponentType::U32, Type::Scalar, None))
    }

    /// Adds floats of the vertices.
    fn accessor(&mut self, bytes: &[u8], count: usize, kind: Type, bounds: Option<[[f32; 3]; 2]>) -> Index<Accessor> {
        let view = self.view(bytes, Some(Target::ArrayBuffer));
        self.root.push(accessor(view, count, ComponentType::F32, kind, bounds))
    }

    /// Adds bytes to the binary chunk.
    fn view(&mut self, bytes: &[u8], target: Option<Target>) -> Index<View> {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(offset)),
            byte_stride: None,
            target: target.map(Valid),
            name: None,
            extensions: None,
            extras: Default::default(),
        })
    }

    /// Adds a material; a texture that several have is added once.
    fn material(
        &mut self,
        used: &MaterialUse,
        is_sheet: bool,
        images: &mut HashMap<PathBuf, Option<Index<Texture>>>,
    ) -> Index<Material> {
        let texture = used.diffuse_texture.as_ref().and_then(|path| {
            if let Some(known) = images.get(path) {
                return *known;
            }
            let added = match self.texture(path) {
                Ok(texture) => Some(texture),
                Err(why) => {
                    self.problems.push(strings::texture_problem(path, &why));
                    None
                }
            };
            images.insert(path.clone(), added);
            added
        });
        let [red, green, blue] = used.diffuse.filter(|_| texture.is_none()).map_or([1.0; 3], |c| c.map(linear));
        self.root.push(Material {
            name: Some(used.name.clone()),
            double_sided: is_sheet,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor([red, green, blue, 1.0]),
                base_color_texture: texture.map(|index| texture::Info {
                    index,
                    tex_coord: 0,
                    extensions: None,
                    extras: Default::default(),
                }),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(ROUGHNESS),
                ..PbrMetallicRoughness::default()
            },
            ..Material::default()
        })
    }

    /// Adds the bytes of an image as they are.
    fn texture(&mut self, path: &Path) -> Result<Index<Texture>, String> {
        let bytes = read_file(path, IMAGE_LIMIT).map_err(|error| error.to_string())?;
        let kind = match image::guess_format(&bytes) {
            Ok(image::ImageFormat::Png) => "image/png",
            Ok(image::ImageFormat::Jpeg) => "image/jpeg",
            _ => return Err(strings::NO_IMAGE.into()),
        };
        let view = self.view(&bytes, None);
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let source = self.root.push(Image {
            buffer_view: Some(view),
            mime_type: Some(MimeType(kind.into())),
            name: name.clone(),
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        Ok(self.root.push(Texture { source, name, sampler: None, extensions: None, extras: Default::default() }))
    }
}

/// The material of faces that a cut has made.
fn cap(name: &str) -> MaterialUse {
    MaterialUse { name: name.into(), found: true, diffuse: Some(CUT_COLOUR), diffuse_texture: None }
}

/// The linear value of a colour as screens have it (IEC 61966-2-1, 0 to 1).
fn linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn accessor(
    view: Index<View>,
    count: usize,
    component: ComponentType,
    kind: Type,
    bounds: Option<[[f32; 3]; 2]>,
) -> Accessor {
    let [min, max] = bounds.map_or([None, None], |bounds| bounds.map(|c| Some(serde_json::Value::from(c.to_vec()))));
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        component_type: Valid(GenericComponentType(component)),
        type_: Valid(kind),
        min,
        max,
        name: None,
        normalized: false,
        sparse: None,
        extensions: None,
        extras: Default::default(),
    }
}
