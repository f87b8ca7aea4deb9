//! What a file holds besides its tetrahedra, and what was changed of it.

use std::fmt;

/// A fact about a file that its user should know. None prevents the mesh from being used.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// Tetrahedra whose nodes were listed the other way around; two nodes of each were exchanged.
    Reoriented {
        /// Number of those tetrahedra.
        count: usize,
        /// Number of all tetrahedra.
        of: usize,
        /// Number of the first in the file.
        first: u64,
    },
    /// Nodes that no tetrahedron has, which are left out.
    UnusedNodes {
        /// Number of nodes that are left out.
        count: usize,
        /// Number of the first in the file.
        first: u64,
    },
    /// Nodes at one place: parts of the mesh that touch there are not connected.
    CoincidentNodes {
        /// Number of nodes at the place of another one.
        count: usize,
        /// Numbers of the first two in the file.
        first: [u64; 2],
    },
    /// Tetrahedra that are nearly flat: they are stiff and need short steps.
    Slivers {
        /// Number of tetrahedra that are nearly flat.
        count: usize,
        /// Number of the worst in the file.
        worst: u64,
        /// Six times its volume over the cube of its longest edge; 0.7 for a regular one.
        share: f64,
    },
    /// Edges of the boundary with other than two of its triangles.
    NonManifold {
        /// Number of edges.
        edges: usize,
        /// Numbers of the nodes of the first in the file.
        first: [u64; 2],
    },
    /// The mesh is in several parts, connected by no node.
    Parts {
        /// Number of connected parts, 2 or more.
        count: usize,
    },
    /// Cells without volume that are left out.
    LeftOut {
        /// Name of their kind.
        kind: &'static str,
        /// Number of cells of this kind that are left out.
        count: usize,
    },
    /// Sections of the file that are not read.
    Sections(Vec<String>),
}

impl Note {
    /// Whether it may change what a user expects of a computation, rather than being of interest.
    pub fn is_doubtful(&self) -> bool {
        match self {
            Self::Reoriented { .. }
            | Self::CoincidentNodes { .. }
            | Self::Slivers { .. }
            | Self::NonManifold { .. } => true,
            Self::UnusedNodes { .. } | Self::Parts { .. } | Self::LeftOut { .. } | Self::Sections(_) => false,
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reoriented { count, of, first } => write!(
                f,
                "{count} of {of} tetrahedra list their nodes the other way around, the first is {first}; two nodes of each are exchanged"
            ),
            Self::UnusedNodes { count, first } => {
                write!(f, "{count} nodes are of no tetrahedron, the first is {first}; they are left out")
            }
            Self::CoincidentNodes { count, first: [a, b] } => write!(
                f,
                "{count} nodes are at the place of another one, as {a} and {b}; tetrahedra that only touch there are not connected: merge the nodes if they \
                 should be (with Gmsh: `Coherence Mesh`)"
            ),
            Self::Slivers { count, worst, share } => write!(
                f,
                "{count} tetrahedra are nearly flat, the worst is {worst}: six times its volume is {share:.1e} times the cube of its longest edge (0.7 for a regular \
                 one); they need short steps"
            ),
            Self::NonManifold { edges, first: [a, b] } => write!(
                f,
                "{edges} edges of the boundary have more than two of its triangles, as that of nodes {a} and {b}: parts of the body touch along an edge"
            ),
            Self::Parts { count } => write!(f, "the mesh is in {count} parts that share no node"),
            Self::LeftOut { kind, count } => write!(f, "{count} cells of kind {kind} are left out"),
            Self::Sections(names) => write!(f, "not read: {}", names.join(", ")),
        }
    }
}
