//! Errors of tetrahedral meshes, with the line and the remedy.

use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Error of reading a tetrahedral mesh.
#[derive(Debug, Error)]
pub enum TetMeshError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// Path of the file.
        file: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A line of the file is invalid. In a binary file bytes that end a line are counted as well.
    #[error("{}:{line}: {problem}", file.display())]
    Line {
        /// The file, as named by the caller.
        file: PathBuf,
        /// Line, from 1; the last line if something is missing in the whole file.
        line: u32,
        /// What is wrong with the line, and what is allowed there.
        problem: TetMeshProblem,
    },
    /// The boundary is too large for an OBJ document.
    #[error("{}: the boundary: {error}", file.display())]
    Boundary {
        /// The file, as named by the caller.
        file: PathBuf,
        /// Why it is no document.
        error: crate::ObjError,
    },
}

/// Problem of a line. `entity` is what the line is about, `found` the text found, truncated to 40 characters.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "each message reads its fields out")]
pub enum TetMeshProblem {
    /// The file is of no known format.
    #[error(
        "the file begins with `{found}`; allowed: a Gmsh file (`$MeshFormat`), a legacy VTK file (`# vtk DataFile Version`) or one in XML (`<VTKFile`)"
    )]
    Format { found: String },
    /// A `.vtu` is no XML that is read.
    #[error("the XML cannot be read: {problem}; allowed: a `.vtu` of VTK, in UTF-8 and without a document type")]
    Xml { problem: String },
    /// A version of the format that is not read.
    #[error("{format} version {found}; allowed: {allowed}")]
    Version { format: &'static str, found: String, allowed: &'static str },
    /// The VTK file holds no unstructured grid.
    #[error("the data set is `{found}`; allowed: UNSTRUCTURED_GRID")]
    DataSet { found: String },
    /// The file ends where something is expected.
    #[error("the file ends where {entity} is expected; is it cut short?")]
    Ends { entity: String },
    /// A word is not a number as it is expected.
    #[error("{entity}: `{found}`; allowed: {allowed}")]
    Word { entity: String, found: String, allowed: &'static str },
    /// A section is missing.
    #[error("the file has no {section}")]
    NoSection { section: &'static str },
    /// A section that is there twice.
    #[error("the section {section} is there twice; allowed: once")]
    Twice { section: String },
    /// Two nodes with one number.
    #[error("node {number} is there twice; allowed: each number once")]
    NodeTwice { number: u64 },
    /// A cell names a node that is not there.
    #[error("{cell} {number} has node {node}, which is not there; allowed: {allowed}")]
    NoNode { cell: &'static str, number: u64, node: u64, allowed: String },
    /// A cell names a node twice.
    #[error("tetrahedron {number} has node {node} twice; allowed: {allowed}")]
    NodeRepeated { number: u64, node: u64, allowed: &'static str },
    /// A cell with a volume that is no tetrahedron of four or ten nodes.
    #[error("element {number} is a {kind}; allowed: tetrahedra of 4 or of 10 nodes; {remedy}")]
    Cell { number: u64, kind: String, remedy: &'static str },
    /// A kind of element that the format does not define.
    #[error("element {number} has type {found}; allowed: a type that the format defines")]
    Kind { number: u64, found: i64 },
    /// A file whose cells are all of other kinds; `others` counts them by kind.
    #[error("the file has no tetrahedra, but {others}; allowed: one at least (with Gmsh: `gmsh -3`)")]
    NoTetrahedra { others: String },
    /// A tetrahedron without volume.
    #[error(
        "tetrahedron {number} is flat: six times its volume is {share:.1e} times the cube of its longest edge; allowed: {least:.0e} or more; mend the mesh (with \
         Gmsh: `gmsh -3 -optimize`)"
    )]
    Flat { number: u64, share: f64, least: f64 },
    /// Tetrahedra of four nodes beside those of ten: the middles of their common edges would not be held together.
    #[error(
        "tetrahedron {linear} has 4 nodes and tetrahedron {quadratic} has 10; allowed: all with 4 or all with 10 (with Gmsh: `gmsh -3 -order 1` or `-order 2`)"
    )]
    Mixed { linear: u64, quadratic: u64 },
    /// Two tetrahedra that disagree about the middle of their common edge.
    #[error(
        "tetrahedra {first} and {second} have nodes {} and {} in the middle of their common edge from node {} to {}; allowed: one node for both; mend the mesh (with \
         Gmsh: `Coherence Mesh`)", nodes[0], nodes[1], edge[0], edge[1]
    )]
    Middles { first: u64, second: u64, nodes: [u64; 2], edge: [u64; 2] },
    /// A node that is a corner of one tetrahedron and in the middle of an edge of another one.
    #[error(
        "node {node} is in the middle of an edge of tetrahedron {first} and a corner of tetrahedron {second}; allowed: one of both; mend the mesh, whose elements do \
         not fit together"
    )]
    CornerAndMiddle { node: u64, first: u64, second: u64 },
    /// A node in the middles of two edges.
    #[error(
        "node {node} is in the middle of the edges from node {} to {} of tetrahedron {first} and from {} to {} of tetrahedron {second}; allowed: a node of its own \
         for each edge; is the order of the nodes that of the format?", edges[0][0], edges[0][1], edges[1][0], edges[1][1]
    )]
    TwoEdges { node: u64, edges: [[u64; 2]; 2], first: u64, second: u64 },
    /// A tetrahedron of ten nodes that is folded over, or nearly so.
    #[error(
        "tetrahedron {number} of 10 nodes is folded over {place}: its Jacobian determinant is {share:.1e} times the cube of its longest edge; allowed: {least:.0e} or more; \
         move its nodes towards the middles of its edges (with Gmsh: `gmsh -3 -order 2 -optimize_ho`)"
    )]
    Folded { number: u64, place: String, share: f64, least: f64 },
    /// Two tetrahedra on one side of their common face.
    #[error(
        "tetrahedra {first} and {second} are on the same side of their common face: they overlap, so one of them is inverted; mend the mesh"
    )]
    Overlap { first: u64, second: u64 },
    /// A face of more than two tetrahedra.
    #[error("tetrahedra {first}, {second} and {third} have a face in common; allowed: at most two at a face")]
    CommonFace { first: u64, second: u64, third: u64 },
    /// More nodes or tetrahedra than there are numbers.
    #[error("the file has {found} {entity}; allowed: at most {most}")]
    TooMany { entity: &'static str, found: usize, most: usize },
}
