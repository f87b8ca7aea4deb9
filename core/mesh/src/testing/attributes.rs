//! A shape as OBJ text, with whatever else such a file may hold.

use super::Random;
use super::shape::Shape;
use crate::geometry::Vec3;
use std::fmt::Write;

/// Attributes a file has or has not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Attributes {
    /// `vt`, a chart for each of six directions, so that there are seams.
    pub texcoords: bool,
    /// `vn`, one for each vertex.
    pub normals: bool,
    /// `o`, `g` and `s` by part, and `usemtl` by part and height.
    pub groups: bool,
    /// Comments, blank lines, colours, odd spacing and several ways to write a number.
    pub decorations: bool,
    /// Carriage returns at line ends.
    pub windows: bool,
    /// Indices count backwards from the last vertex.
    pub relative: bool,
}

impl Attributes {
    /// Each by the throw of a coin.
    pub fn random(random: &mut Random) -> Self {
        let mut coin = || random.below(2) == 0;
        Self {
            texcoords: coin(),
            normals: coin(),
            groups: coin(),
            decorations: coin(),
            windows: coin(),
            relative: coin(),
        }
    }
}

/// The text of an OBJ file.
pub(super) fn write(shape: &Shape, with: Attributes, random: &mut Random) -> String {
    let mut file = File { with, text: String::new() };
    if with.decorations {
        file.text.push_str("# exported by a test\n#\ttabs, \u{e9}\u{df}\u{4e2d}, trailing blanks   \n\n");
    }
    if with.groups {
        file.text.push_str("mtllib model.mtl\n");
    }
    for point in &shape.points {
        file.vertex(*point, random);
    }
    let normals = if with.normals { normals(shape) } else { Vec::new() };
    normals.iter().for_each(|n| file.line(&format!("vn {:.4} {:.4} {:.4}", n.x, n.y, n.z)));
    file.faces(shape, random);
    if with.windows { file.text.replace('\n', "\r\n") } else { file.text }
}

struct File {
    with: Attributes,
    text: String,
}

impl File {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn vertex(&mut self, point: Vec3, random: &mut Random) {
        let [x, y, z] = point.into();
        if !self.with.decorations {
            return self.line(&format!("v {x:.6} {y:.6} {z:.6}"));
        }
        let colour = "0.8 0.7 0.6";
        match random.below(8) {
            0 => self.line(&format!("v  {x:e} {y}\t{z:+.9} {colour}")),
            1 => self.line(&format!("  v {x:.6} {y:.6} {z:.6} {colour} # {}", random.below(1000))),
            2 => self.line(&format!("\n# a comment\nv {x:.3} {y:.6} {z} {colour}   ")),
            _ => self.line(&format!("v {x:.6} {y:.6} {z:.6} {colour}")),
        }
    }

    fn faces(&mut self, shape: &Shape, random: &mut Random) {
        let (mut texcoords, mut now) = (0, (u32::MAX, false));
        for (face, part) in shape.faces.iter().zip(&shape.part) {
            let height = face.iter().map(|v| shape.points[*v as usize][1]).sum::<f64>();
            let next = (*part, height > 0.0);
            if self.with.groups && next != now {
                if next.0 != now.0 {
                    self.line(&format!("o part {part}\ng part{part} all\ns {}", ["off", "1", "2"][*part as usize % 3]));
                }
                self.line(if next.1 { "usemtl upper" } else { "usemtl lower side" });
                now = next;
            }
            if self.with.texcoords {
                for [u, v] in chart(shape, face) {
                    self.line(&format!("vt {u:.5} {v:.5}"));
                }
            }
            let index = |at: u32, count: usize| {
                if self.with.relative { i64::from(at) - count as i64 } else { i64::from(at) + 1 }
            };
            let mut line = "f".to_owned();
            for (i, v) in face.iter().enumerate() {
                let vertex = index(*v, shape.points.len());
                let texcoord = index((texcoords + i) as u32, texcoords + face.len());
                _ = match (self.with.texcoords, self.with.normals) {
                    (false, false) => write!(line, " {vertex}"),
                    (true, false) => write!(line, " {vertex}/{texcoord}"),
                    (false, true) => write!(line, " {vertex}//{vertex}"),
                    (true, true) => write!(line, " {vertex}/{texcoord}/{vertex}"),
                };
            }
            texcoords += if self.with.texcoords { face.len() } else { 0 };
            if self.with.decorations && random.below(16) == 0 {
                line.push_str("  # a face\n");
            }
            self.line(&line);
        }
    }
}

/// Twice the area of a polygon times its normal (Newell's method).
fn newell(shape: &Shape, face: &[u32]) -> Vec3 {
    let point = |i: usize| shape.points[face[i % face.len()] as usize];
    let mut sum = Vec3::zeros();
    for (p, q) in (0..face.len()).map(|i| (point(i), point(i + 1))) {
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            sum[a] += (p[b] - q[b]) * (p[c] + q[c]);
        }
    }
    sum
}

/// Texture coordinates of a face, seen along the axis it faces most, in the tile of that direction.
fn chart(shape: &Shape, face: &[u32]) -> Vec<[f64; 2]> {
    let normal = newell(shape, face);
    let axis = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).expect("three axes");
    let reach = shape.points.iter().flatten().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let tile = [f64::from(u32::from(normal[axis] < 0.0)) / 2.0, axis as f64 / 3.0];
    let inside = |p: Vec3, a: usize| 0.05 + 0.9 * (0.5 + 0.5 * p[(axis + a) % 3] / reach);
    let places = face.iter().map(|v| shape.points[*v as usize]);
    places.map(|p| [tile[0] + inside(p, 1) / 2.0, tile[1] + inside(p, 2) / 3.0]).collect()
}

/// Unit normals at the vertices: those of the faces, weighted by area.
fn normals(shape: &Shape) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); shape.points.len()];
    for face in &shape.faces {
        let normal = newell(shape, face);
        face.iter().for_each(|v| sums[*v as usize] += normal);
    }
    sums.iter().map(|sum| sum.try_normalize(0.0).unwrap_or_else(Vec3::z)).collect()
}
