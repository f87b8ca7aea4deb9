//! Checks of surfaces, with a severity that depends on their use.
//!
//! A surface embedded in a grid is only displayed and touched, so no finding is an error for it. A material on the triangles divides by areas and edge lengths, so
//! some findings are errors for it.

use std::fmt;
use std::iter::zip;

use super::edges::Side;
use super::{MeshError, ObjDocument, Surface};

/// A kind of defect with its locations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Kind of the defect.
    pub kind: Kind,
    /// Number of locations.
    pub count: usize,
    /// The first locations, at most [`Finding::PLACES`].
    pub places: Vec<Place>,
}

/// Kinds of defects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A triangle with an area of 1e-9 of its longest edge squared, or less.
    ZeroArea,
    /// A triangle with the same three vertices as an earlier one, in any order.
    Duplicate,
    /// An edge whose two vertices coincide.
    ZeroEdge,
    /// A non-manifold edge, with more than two triangles.
    NonManifold,
    /// An edge with the same direction in its two triangles: one of them has the opposite orientation.
    Orientation,
    /// Two adjacent triangles folded onto each other, with an angle below one degree.
    Folded,
    /// A border edge, with one triangle.
    Border,
    /// A vertex without faces.
    UnusedVertex,
}

/// Location of a defect, with numbers from 1 as in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A face and its line.
    Face {
        /// From 1, in the order of the `f` lines.
        number: usize,
        /// Line of the file, from 1.
        line: u32,
    },
    /// An edge and the line of a face on it.
    Edge {
        /// Its vertices, from 1.
        vertices: [usize; 2],
        /// Line of the file, from 1.
        line: u32,
    },
    /// A vertex and its line.
    Vertex {
        /// From 1, in the order of the `v` lines.
        number: usize,
        /// Line of the file, from 1.
        line: u32,
    },
}

/// Use of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// It is embedded in a grid.
    Embedded,
    /// Its triangles and edges are elements of a material.
    MeshElements,
}

/// Severity of a defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Harmless; reported for information.
    Note,
    /// Allowed; the result may be unintended.
    Warning,
    /// The model is refused.
    Error,
}

impl Finding {
    /// Largest number of locations in one finding.
    pub const PLACES: usize = 5;

    /// Severity for a surface with this use.
    pub fn severity(&self, used: Use) -> Severity {
        match (self.kind, used) {
            (Kind::ZeroArea | Kind::Duplicate | Kind::ZeroEdge, Use::MeshElements) => Severity::Error,
            (Kind::Border, _) => Severity::Note,
            _ => Severity::Warning,
        }
    }
}

/// All defects of `surface`, which was made from `document`, in the order of [`Kind`]; empty if there are none.
pub fn check(surface: &Surface, document: &ObjDocument) -> Vec<Finding> {
    let mut report = Report { surface, document, findings: Vec::new() };
    report.triangles();
    report.duplicates();
    report.edges();
    report.unused();
    report.findings.sort_by_key(|finding| finding.kind);
    report.findings
}

/// Refuses a surface whose triangles cannot be the elements of a material.
///
/// # Errors
/// [`MeshError::Refused`] with every finding that is an error for [`Use::MeshElements`].
pub fn require_for_mesh_elements(findings: &[Finding]) -> Result<(), MeshError> {
    let refused = |finding: &&Finding| finding.severity(Use::MeshElements) == Severity::Error;
    let refused: Vec<Finding> = findings.iter().filter(refused).cloned().collect();
    if refused.is_empty() { Ok(()) } else { Err(MeshError::Refused(refused)) }
}

const SMALL_AREA: f64 = 1e-9; // of the longest edge squared
const SMALL_EDGE: f64 = 1e-12; // of the longest edge of the box
/// Cosine of the angle between the normals of triangles folded onto each other, 179 degrees.
pub(crate) const FOLDED: f64 = -0.999_847_695;

struct Report<'a> {
    surface: &'a Surface,
    document: &'a ObjDocument,
    findings: Vec<Finding>,
}

impl Report<'_> {
    fn add(&mut self, kind: Kind, place: impl FnOnce(&Self) -> Place) {
        let known = self.findings.iter().position(|finding| finding.kind == kind);
        let at = known.unwrap_or_else(|| {
            self.findings.push(Finding { kind, count: 0, places: Vec::new() });
            self.findings.len() - 1
        });
        self.findings[at].count += 1;
        if self.findings[at].places.len() < Finding::PLACES {
            let place = place(self);
            self.findings[at].places.push(place);
        }
    }

    fn triangles(&mut self) {
        for (index, (triangle, area)) in zip(&self.surface.triangles, self.surface.areas()).enumerate() {
            let [a, b, c] = triangle.map(|vertex| self.surface.point(vertex));
            let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
            if area <= SMALL_AREA * longest {
                self.add(Kind::ZeroArea, |report| report.face(index));
            }
        }
    }

    fn duplicates(&mut self) {
        let sorted = |(index, triangle): (usize, &[u32; 3])| {
            let mut key = *triangle;
            key.sort_unstable();
            (key, index)
        };
        let mut keys: Vec<_> = self.surface.triangles.iter().enumerate().map(sorted).collect();
        keys.sort_unstable();
        let mut again: Vec<_> = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).collect();
        again.sort_unstable();
        for index in again {
            self.add(Kind::Duplicate, |report| report.face(index));
        }
    }

    fn edges(&mut self) {
        let small = SMALL_EDGE * self.surface.bounds().longest_edge();
        for (vertices, sides) in self.surface.edges().iter() {
            let place = |report: &Self| Place::Edge {
                vertices: vertices.map(|vertex| vertex as usize + 1),
                line: report.line(sides[0].triangle as usize),
            };
            let [a, b] = vertices.map(|vertex| self.surface.point(vertex));
            if (b - a).norm() <= small {
                self.add(Kind::ZeroEdge, place);
            }
            match sides {
                [_] => self.add(Kind::Border, place),
                [one, other] => {
                    if one.upward == other.upward {
                        self.add(Kind::Orientation, place);
                    }
                    if self.folded(one, other) {
                        self.add(Kind::Folded, place);
                    }
                }
                _ => self.add(Kind::NonManifold, place),
            }
        }
    }

    fn unused(&mut self) {
        let mut used = vec![false; self.surface.points.len()];
        self.surface.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
        self.document.welds().iter().for_each(|[vertex, _]| used[*vertex as usize] = true);
        for (index, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
            self.add(Kind::UnusedVertex, |report| Place::Vertex {
                number: index + 1,
                line: report.document.line_of_vertex(index).unwrap_or(0),
            });
        }
    }

    fn folded(&self, one: &Side, other: &Side) -> bool {
        let normal = |side: &Side| self.surface.cross(&self.surface.triangles[side.triangle as usize]);
        let (a, b) = (normal(one), normal(other));
        let cosine = a.dot(&b) / (a.norm() * b.norm()); // not a number without an area, and then not folded
        if one.upward == other.upward { -cosine < FOLDED } else { cosine < FOLDED }
    }

    fn face(&self, triangle: usize) -> Place {
        let number = self.surface.face_of.get(triangle).map_or(0, |&face| face as usize + 1);
        Place::Face { number, line: self.line(triangle) }
    }

    fn line(&self, triangle: usize) -> u32 {
        let face = self.surface.face_of.get(triangle).and_then(|&face| self.document.face(face as usize));
        face.map_or(0, |face| face.line)
    }
}

impl Kind {
    /// Description of the defect in the plural, and what is allowed instead.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::ZeroArea => ("triangles without area", "an area above 1e-9 of the longest edge squared"),
            Self::Duplicate => ("duplicate triangles", "one triangle on the same three vertices"),
            Self::ZeroEdge => ("edges of no length", "vertices of a face apart from each other"),
            Self::NonManifold => ("edges of more than two triangles", "one or two triangles on an edge"),
            Self::Orientation => ("edges with one side turned over", "faces that all turn the same way"),
            Self::Folded => ("edges folded flat", "less than 179 degrees between the two sides"),
            Self::Border => ("open edges", "any number on a sheet, none on a solid"),
            Self::UnusedVertex => ("vertices no face uses", "any number; they do not take part"),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let (what, allowed) = self.kind.words();
        write!(out, "{what}: {}, at ", self.count)?;
        for (index, place) in self.places.iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(out, "{comma}{place}")?;
        }
        let more = if self.count > self.places.len() { ", ..." } else { "" };
        write!(out, "{more}; allowed: {allowed}")
    }
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Face { number, line } => write!(out, "face {number} (line {line})"),
            Self::Edge { vertices: [a, b], line } => write!(out, "edge {a}-{b} (line {line})"),
            Self::Vertex { number, line } => write!(out, "vertex {number} (line {line})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::document;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

    #[track_caller]
    fn findings(text: &str) -> Vec<Finding> {
        let document = document(text);
        check(&Surface::from_document(&document), &document)
    }

    /// The one finding of `kind` beside the border every sheet has.
    #[track_caller]
    fn only(text: &str, kind: Kind) -> Finding {
        let mut findings = findings(text);
        findings.retain(|finding| finding.kind != Kind::Border);
        assert_eq!(findings.iter().map(|finding| finding.kind).collect::<Vec<_>>(), [kind]);
        findings.remove(0)
    }

    fn refused(finding: Finding) -> bool {
        assert_eq!(finding.severity(Use::Embedded), Severity::Warning, "embedding stops at nothing");
        require_for_mesh_elements(&[finding]).is_err()
    }

    #[test]
    fn a_sheet_has_only_a_border() {
        let findings = findings(SQUARE);
        assert_eq!(findings.len(), 1);
        assert_eq!((findings[0].kind, findings[0].count, findings[0].places.len()), (Kind::Border, 4, 4));
        assert_eq!(findings[0].severity(Use::MeshElements), Severity::Note);
        require_for_mesh_elements(&findings).unwrap();
    }

    #[test]
    fn zero_area() {
        let sliver = only(&format!("{SQUARE}v 0.5 0 0\nf 1 5 2\n"), Kind::ZeroArea);
        assert_eq!(sliver.places, [Place::Face { number: 3, line: 8 }]);
        let message = require_for_mesh_elements(std::slice::from_ref(&sliver)).unwrap_err().to_string();
        assert!(message.contains("face 3 (line 8)") && message.contains("allowed: an area above 1e-9"), "{message}");
        assert!(refused(sliver));
        let thin = findings(&format!("{SQUARE}v 0.5 -1e-8 0\nf 1 5 2\n"));
        assert!(thin.iter().all(|finding| finding.kind == Kind::Border), "thin is not nothing");
    }

    #[test]
    fn duplicate() {
        let found = findings(&format!("{SQUARE}f 3 1 2\nf 4 3 1\n"));
        assert_eq!(found[0].kind, Kind::Duplicate);
        assert_eq!(found[0].places, [7, 8].map(|line| Place::Face { number: line as usize - 4, line }));
        assert!(refused(found[0].clone()));
    }

    #[test]
    fn zero_edge() {
        let found = findings(&format!("{SQUARE}v 1 0 0\nf 1 5 2\n"));
        assert_eq!(found.iter().map(|finding| finding.kind).collect::<Vec<_>>()[..2], [Kind::ZeroArea, Kind::ZeroEdge]);
        assert_eq!(found[1].places, [Place::Edge { vertices: [2, 5], line: 8 }]);
        assert!(refused(found[1].clone()));
    }

    #[test]
    fn non_manifold() {
        let found = only(&format!("{SQUARE}v 0 0 1\nf 1 3 5\n"), Kind::NonManifold);
        assert_eq!(found.places, [Place::Edge { vertices: [1, 3], line: 5 }]);
        assert!(!refused(found));
    }

    #[test]
    fn orientation() {
        let found = only(&SQUARE.replace("f 1 3 4", "f 1 4 3"), Kind::Orientation);
        assert_eq!(found.count, 1);
        assert!(!refused(found));
    }

    #[test]
    fn folded() {
        let found = only(&SQUARE.replace("v 0 1 0", "v 1 0.1 0.0001"), Kind::Folded);
        assert_eq!(found.places, [Place::Edge { vertices: [1, 3], line: 5 }]);
        assert!(!refused(found));
        let turned = findings(&SQUARE.replace("v 0 1 0", "v 1 0.1 0.0001").replace("f 1 3 4", "f 1 4 3"));
        assert!(turned.iter().any(|finding| finding.kind == Kind::Folded), "also when one side is turned over");
    }

    #[test]
    fn unused_vertices_are_counted_and_the_first_named() {
        let found = only(
            &format!("{}{SQUARE}", "# head\n").replace("f 1", &format!("{}f 1", "v 2 2 2\n".repeat(6))),
            Kind::UnusedVertex,
        );
        assert_eq!((found.count, found.places.len()), (12, Finding::PLACES));
        assert_eq!(found.places[0], Place::Vertex { number: 5, line: 6 });
        assert!(found.to_string().contains("vertex 9 (line 10), ...; allowed"));
        assert!(!refused(found));
    }
}
