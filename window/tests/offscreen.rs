//! The renderer without a window: pictures that it draws into memory, checked against what geometry says they must show.

#![allow(unsafe_code, reason = "a context of OpenGL is made by hand")]

use eframe::glow::{self, HasContext};
use glutin::api::egl::context::PossiblyCurrentContext;
use glutin::api::egl::device::Device;
use glutin::api::egl::display::Display;
use glutin::config::{ConfigSurfaceTypes, ConfigTemplateBuilder};
use glutin::context::{ContextApi, ContextAttributesBuilder, Version};
use glutin::prelude::*;
use image::{Rgba, RgbaImage};
use nalgebra::Point3;
use pliant_editor::surface::ViewSurface;
use pliant_engine::body::Model;
use pliant_live::BodyTopology;
use pliant_mesh::{ObjDocument, Placement, generate};
use pliant_window::gl::{Channels, GlRenderer, PixelArea, Scene, Shading, SurfaceRenderer, Wireframe};
use pliant_window::materials::{MaterialLook, SurfaceMaterials};
use pliant_window::picture::{CUT, Patch, Upload};
use pliant_window::reference::ReferenceQuad;
use pliant_window::view::{Camera, Eye, Projection};
use std::sync::Arc;

/// Pixels along an edge of the picture.
const SIZE: i32 = 256;
const AREA: PixelArea = PixelArea { left: 0, bottom: 0, width: SIZE, height: SIZE };

/// A context without a window, and a target to draw into.
struct Offscreen {
    renderer: GlRenderer,
    gl: Arc<glow::Context>,
    _context: PossiblyCurrentContext,
}

impl Offscreen {
    fn new() -> Self {
        let devices = Device::query_devices().expect("EGL lists its devices: install libegl1 and libgl1-mesa-dri");
        // Mesa's own device is the last one; it draws without a graphics card.
        let device = devices.last().expect("a device");
        // SAFETY: no native display is given; all handles outlive the context.
        let (context, gl) = unsafe {
            let display = Display::with_device(&device, None).expect("a display");
            let template = ConfigTemplateBuilder::default().with_surface_type(ConfigSurfaceTypes::empty()).build();
            let config = display.find_configs(template).expect("configurations").next().expect("one of them");
            let version = ContextApi::OpenGl(Some(Version::new(3, 3)));
            let attributes = ContextAttributesBuilder::new().with_context_api(version).build(None);
            let context = display.create_context(&config, &attributes).expect("OpenGL 3.3");
            let context = context.make_current_surfaceless().expect("a context without a surface");
            let gl = glow::Context::from_loader_function_cstr(|name| display.get_proc_address(name));
            let gl = Arc::new(gl);
            let target = gl.create_framebuffer().unwrap();
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(target));
            for (format, place) in
                [(glow::RGBA8, glow::COLOR_ATTACHMENT0), (glow::DEPTH_COMPONENT24, glow::DEPTH_ATTACHMENT)]
            {
                let buffer = gl.create_renderbuffer().unwrap();
                gl.bind_renderbuffer(glow::RENDERBUFFER, Some(buffer));
                gl.renderbuffer_storage(glow::RENDERBUFFER, format, SIZE, SIZE);
                gl.framebuffer_renderbuffer(glow::FRAMEBUFFER, place, glow::RENDERBUFFER, Some(buffer));
            }
            assert_eq!(gl.check_framebuffer_status(glow::FRAMEBUFFER), glow::FRAMEBUFFER_COMPLETE);
            (context, gl)
        };
        let renderer = GlRenderer::new(Arc::clone(&gl)).expect("a renderer");
        Self { renderer, gl, _context: context }
    }

    /// Draws a scene; gives the colours of its pixels, top row first, and none of the errors of OpenGL.
    fn draw(&mut self, scene: &Scene) -> Vec<[u8; 3]> {
        self.renderer.draw(scene, AREA);
        let pixels = self.renderer.read_back(AREA);
        // SAFETY: the context is current.
        assert_eq!(unsafe { self.gl.get_error() }, glow::NO_ERROR);
        pixels.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }
}

fn surface(document: ObjDocument) -> ViewSurface {
    let model = Model::new(document, Placement::default());
    let origin = model.surface.bounds().centre();
    let looks = (0..model.surface.triangles.len() as u32).map(|t| model.look(t, None)).collect();
    let positions = model.surface.points.iter().map(|p| (p - origin).map(|c| c as f32).into()).collect();
    ViewSurface::new(&BodyTopology { name: "body".into(), triangles: Arc::new(looks), origin, positions, moves: true })
}

/// A ball of radius 1 m seen from 4 m by an orthographic camera that sees 1.5 m in each direction.
fn camera() -> Camera {
    let field_of_view = 2.0 * (1.5_f64 / 4.0).atan();
    let target = Point3::origin();
    let projection = Projection::Orthographic;
    Camera {
        target,
        distance: 4.0,
        yaw: 0.0,
        pitch: 0.0,
        projection,
        field_of_view,
        scene_radius: 1.0,
        ..Camera::default()
    }
}

fn scene(camera: &Camera) -> Scene {
    Scene {
        view: camera.view_matrix(Eye::Both),
        projection: camera.projection_matrix(1.0, Eye::Both),
        origins: vec![[0.0; 3]],
        shading: Shading::Studio,
        wireframe: Wireframe::Off,
        file_colours: true,
        opacity: 1.0,
        mark_backs: true,
        full_displacement: 1.0,
        // A colour that no material has.
        background: [[0.0, 1.0, 0.0]; 2],
        channels: Channels::All,
        lines: Vec::new(),
        reference: None,
    }
}

fn is_background(pixel: &[u8; 3]) -> bool {
    *pixel == [0, 255, 0]
}

#[test]
fn a_ball_covers_a_disc_and_is_lit_from_above() {
    let mut offscreen = Offscreen::new();
    let ball = surface(generate::sphere(32, 1.0).unwrap());
    offscreen.renderer.upload(&Upload::whole(0, &ball));
    let camera = camera();
    for shading in Shading::ALL {
        let pixels = offscreen.draw(&Scene { shading, ..scene(&camera) });
        let covered = pixels.iter().filter(|pixel| !is_background(pixel)).count() as f64;
        let radius = f64::from(SIZE) / 3.0;
        let disc = std::f64::consts::PI * radius * radius;
        // A pixel is drawn if its middle is inside: off by at most half a pixel along the edge, and the ball is a polyhedron.
        assert!((covered - disc).abs() < 0.5 * std::f64::consts::TAU * radius, "{shading:?}: {covered} of {disc}");
        let at = |x: f64, y: f64| {
            let pixel = |share: f64| (f64::from(SIZE) * (0.5 + share / 3.0)) as usize;
            pixels[pixel(-y) * SIZE as usize + pixel(x)].iter().map(|c| u32::from(*c)).sum::<u32>()
        };
        assert!(at(-0.4, 0.55) > at(0.4, -0.7), "{shading:?}: light comes from the upper left");
    }
}

#[test]
fn facets_edges_and_opacity_change_what_they_should() {
    let mut offscreen = Offscreen::new();
    let ball = surface(generate::sphere(8, 1.0).unwrap());
    let mut upload = Upload::whole(0, &ball);
    upload.edges = Some(ball.edges());
    offscreen.renderer.upload(&upload);
    let camera = camera();
    let smooth = offscreen.draw(&scene(&camera));
    let facets = offscreen.draw(&Scene { shading: Shading::Facets, ..scene(&camera) });
    let tones = |pixels: &[[u8; 3]]| pixels.iter().collect::<std::collections::BTreeSet<_>>().len();
    assert!(tones(&facets) * 2 < tones(&smooth), "{} tones of facets, {} smooth", tones(&facets), tones(&smooth));
    let wired = offscreen.draw(&Scene { wireframe: Wireframe::Over, ..scene(&camera) });
    let darker = wired.iter().zip(&smooth).filter(|(a, b)| u32::from(a[0]) + 20 < u32::from(b[0])).count();
    // 2 * 8 quads along a meridian of a quarter sphere or so: lines cover a few percent of the picture.
    assert!(darker > 500 && darker < smooth.len() / 3, "{darker}");
    let alone = offscreen.draw(&Scene { wireframe: Wireframe::Only, ..scene(&camera) });
    let open = alone.iter().filter(|pixel| is_background(pixel)).count();
    let behind = smooth.iter().filter(|pixel| is_background(pixel)).count();
    assert!(open > behind, "the inside is seen through a wireframe");
    let glass = offscreen.draw(&Scene { opacity: 0.3, ..scene(&camera) });
    let middle = glass[(SIZE * SIZE / 2 + SIZE / 2) as usize];
    assert!(middle[1] > 100 && !is_background(&middle), "the background shines through: {middle:?}");
}

/// A red-cyan picture has the left eye's picture in its red and the right eye's in the rest: what is nearer than the target is apart in it.
#[test]
fn an_anaglyph_has_a_picture_for_each_eye() {
    let mut offscreen = Offscreen::new();
    let ball = surface(generate::sphere(16, 0.3).unwrap());
    offscreen.renderer.upload(&Upload::whole(0, &ball));
    let camera = Camera { projection: Projection::Perspective, ..camera() };
    let centre = |pixels: &[[u8; 3]], channel: usize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for (place, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| pixel[channel] > 20) {
            (sum, count) = (sum + (place % SIZE as usize) as f64, count + f64::from(pixel[channel] > 20));
        }
        sum / count
    };
    let mut apart = |z: f64| {
        let draw = |offscreen: &mut Offscreen, eye, channels| {
            let (view, projection) = (camera.view_matrix(eye), camera.projection_matrix(1.0, eye));
            let origins = vec![[0.0, 0.0, z]];
            let background = [[0.0; 3]; 2];
            offscreen.draw(&Scene { view, projection, channels, origins, background, ..scene(&camera) })
        };
        draw(&mut offscreen, Eye::Left, Channels::Red);
        let both = draw(&mut offscreen, Eye::Right, Channels::GreenAndBlue);
        let alone = draw(&mut offscreen, Eye::Left, Channels::All);
        assert!((centre(&both, 0) - centre(&alone, 0)).abs() < 0.01, "red is what the left eye sees");
        centre(&both, 0) - centre(&both, 1)
    };
    assert!(apart(0.0).abs() < 1.0, "at the target the pictures meet");
    // The left eye sees what is near further to the right.
    assert!(apart(1.0) > 1.0 && apart(-2.0) < -1.0);
}

/// A square whose image has another colour in each quarter, above a stripe of one colour.
#[test]
fn textures_lie_as_the_file_says_and_materials_have_their_colour() {
    let mut offscreen = Offscreen::new();
    let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1.4 0\nv 1 -1.4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        usemtl picture\nf 1/1 2/2 3/3 4/4\nusemtl stripe\nf 5 6 2 1\n";
    let square = surface(ObjDocument::parse(text.into(), std::path::Path::new("square.obj")).unwrap());
    let quarters = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]];
    let image = RgbaImage::from_fn(64, 64, |x, y| {
        let [r, g, b] = quarters[usize::from(x >= 32) + 2 * usize::from(y >= 32)];
        Rgba([r, g, b, 255])
    });
    let looks = vec![Some(MaterialLook::Texture(0)), Some(MaterialLook::Colour([0.9, 0.1, 0.9]))];
    let materials = Some(Arc::new(SurfaceMaterials { looks, images: vec![image] }));
    offscreen.renderer.upload(&Upload { materials, ..Upload::whole(0, &square) });
    let camera = camera();
    let view = Scene { background: [[0.0; 3]; 2], origins: vec![square.origin.into()], ..scene(&camera) };
    let at = |pixels: &[[u8; 3]], x: f64, y: f64| {
        let pixel = |share: f64| (f64::from(SIZE) * (0.5 + share / 3.0)) as usize;
        pixels[pixel(-y) * SIZE as usize + pixel(x)].map(|c| c > 110)
    };
    for shading in [Shading::Studio, Shading::Facets] {
        let pixels = offscreen.draw(&Scene { shading, ..view.clone() });
        for (place, [x, y]) in [[-0.5, 0.5], [0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]].into_iter().enumerate() {
            assert_eq!(at(&pixels, x, y), quarters[place].map(|c| c > 110), "{shading:?}: quarter {place}");
        }
        assert_eq!(at(&pixels, 0.0, -1.2), [true, false, true], "{shading:?}: the stripe");
    }
    let plain = offscreen.draw(&Scene { file_colours: false, ..view });
    assert_eq!(at(&plain, -0.5, 0.5), at(&plain, 0.5, -0.5), "without the colours of the file all is of one colour");
}

#[test]
fn patches_change_places_and_looks_and_the_inside_is_marked() {
    let mut offscreen = Offscreen::new();
    let ball = surface(generate::sphere(16, 1.0).unwrap());
    let whole = Upload::whole(0, &ball);
    offscreen.renderer.upload(&whole);
    let camera = camera();
    let before = offscreen.draw(&scene(&camera));
    // All vertices are brought to half the size, in one patch that leaves the rest as it is.
    let mut places = whole.places.clone();
    for place in places.iter_mut().flat_map(|patch| &mut patch.items) {
        place.position = place.position.map(|c| 0.5 * c);
    }
    let count = |pixels: &[[u8; 3]]| pixels.iter().filter(|pixel| !is_background(pixel)).count() as f64;
    let patch = Upload { vertices: whole.vertices, triangles: whole.triangles, places, ..Upload::default() };
    offscreen.renderer.upload(&patch);
    let smaller = offscreen.draw(&scene(&camera));
    let ratio = count(&smaller) / count(&before);
    assert!((ratio - 0.25).abs() < 0.01, "{ratio}");
    // Faces of a cut are red.
    let mut cut = whole.clone();
    cut.looks.iter_mut().flat_map(|patch| &mut patch.items).for_each(|look| look.material = CUT);
    offscreen.renderer.upload(&cut);
    let red = offscreen.draw(&scene(&camera))[(SIZE * SIZE / 2 + SIZE / 2) as usize];
    assert!(u32::from(red[0]) > 2 * u32::from(red[2]), "{red:?}");
    // Turned inside out, what is seen is the blue back.
    let corners = ball.corners().iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let turned = Upload { corners: vec![Patch { first: 0, items: corners }], ..whole };
    offscreen.renderer.upload(&turned);
    let blue = offscreen.draw(&scene(&camera))[(SIZE * SIZE / 2 + SIZE / 2) as usize];
    assert!(blue[2] > blue[0], "{blue:?}");
    let plain = offscreen.draw(&Scene { mark_backs: false, ..scene(&camera) })[(SIZE * SIZE / 2 + SIZE / 2) as usize];
    assert!(plain[2] <= plain[0], "a sheet has two good sides: {plain:?}");
    offscreen.renderer.clear();
    assert_eq!(count(&offscreen.draw(&scene(&camera))), 0.0);
}

/// A sheet has two good sides: seen from behind it has the tones that its mirror image has from the front, with smooth shading and with facets.
#[test]
fn the_back_of_a_sheet_is_lit_as_its_front() {
    let mut offscreen = Offscreen::new();
    // A roof with faces to the left and to the right, its upper side towards the viewer or away.
    let roof = |faces: &str| {
        let text = format!("v -1 -1 0\nv 0 -1 0.7\nv 1 -1 0\nv 1 1 0\nv 0 1 0.7\nv -1 1 0\n{faces}");
        surface(ObjDocument::parse(text.into(), std::path::Path::new("roof.obj")).unwrap())
    };
    let [front, back] = ["f 1 2 5 6\nf 2 3 4 5\n", "f 6 5 2 1\nf 5 4 3 2\n"].map(roof);
    for shading in Shading::ALL {
        let [seen, behind] = [&front, &back].map(|sheet| {
            offscreen.renderer.clear();
            offscreen.renderer.upload(&Upload::whole(0, sheet));
            offscreen.draw(&Scene { shading, mark_backs: false, ..scene(&camera()) })
        });
        let apart = |a: &[u8; 3], b: &[u8; 3]| (0..3).map(|c| a[c].abs_diff(b[c])).max();
        let most = seen.iter().zip(&behind).filter_map(|(a, b)| apart(a, b)).max();
        assert!(most.is_some_and(|most| most <= 2), "{shading:?}: {most:?} of 255");
        assert!(seen.iter().filter(|pixel| !is_background(pixel)).count() > 10_000);
    }
}

/// An image of four colours behind a ball: it stands upright, the ball hides its middle, and half an opacity lets the background through.
#[test]
fn a_reference_image_stands_upright_behind_the_model() {
    let mut offscreen = Offscreen::new();
    let ball = surface(generate::sphere(24, 1.0).unwrap());
    offscreen.renderer.upload(&Upload::whole(0, &ball));
    let colours = [[255, 0, 0], [0, 0, 255], [255, 255, 255], [0, 0, 0]];
    // Red and blue above, white and black below.
    let image = RgbaImage::from_fn(64, 64, |x, y| {
        let [r, g, b] = colours[usize::from(x >= 32) + 2 * usize::from(y >= 32)];
        Rgba([r, g, b, 255])
    });
    offscreen.renderer.upload_reference(&image).unwrap();
    // The picture sees 1.5 m to each side; the image has 1.2 m.
    let corners = [[-1.2, -1.2, -1.1], [1.2, -1.2, -1.1], [-1.2, 1.2, -1.1], [1.2, 1.2, -1.1]];
    for (opacity, background) in [(1.0_f32, 0.0_f32), (0.5, 0.5)] {
        let reference = Some(ReferenceQuad { corners, opacity });
        let pixels = offscreen.draw(&Scene { reference, ..scene(&camera()) });
        // m, from the middle, to the right and up
        let at = |x: f64, y: f64| {
            let pixel = |c: f64| ((c / 1.5 + 1.0) * 0.5 * f64::from(SIZE)) as usize;
            pixels[(SIZE as usize - 1 - pixel(y)) * SIZE as usize + pixel(x)]
        };
        for ([x, y], colour) in [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].into_iter().zip(colours) {
            // The background is green.
            let expected = [0, 1, 2].map(|c| {
                let green = if c == 1 { 255.0 } else { 0.0 };
                f32::from(colour[c]) * opacity + green * background
            });
            let found = at(x, y).map(f32::from);
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < 4.0, "at {x}, {y} with {opacity}: {found:?}, and not {expected:?}");
        }
        assert_eq!(at(1.4, 0.0), [0, 255, 0], "nothing beside the image");
        let [r, g, b] = at(-0.2, 0.2);
        assert!(r.abs_diff(g) < 40 && g.abs_diff(b) < 40, "the ball, and no red: {r} {g} {b}");
    }
}
