//! Keys of an `[[edit]]` that only some kinds read, and their defaults.

/// Name of a key that only some edit kinds read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyName {
    /// `limit`: largest force, N.
    Limit,
    /// `radius` of the soft region, m.
    Radius,
    /// `falloff`, a [`Falloff`](super::Falloff).
    Falloff,
    /// `strength`, in the unit of the edit kind.
    Strength,
    /// `param`, a parameter of the body's material.
    Param,
    /// `depth` of what is painted.
    Depth,
    /// `sheet-layers`: how many layers of a sheet are cut.
    SheetLayers,
    /// `split`: whether the parts of what is cut become bodies of their own.
    Split,
}

impl KeyName {
    /// Spelling in scene files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Radius => "radius",
            Self::Falloff => "falloff",
            Self::Strength => "strength",
            Self::Param => "param",
            Self::Depth => "depth",
            Self::SheetLayers => "sheet-layers",
            Self::Split => "split",
        }
    }
}

/// A key that a kind of edit reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Name of the key.
    pub name: KeyName,
    /// The default, as a scene would write it, or a description of it.
    pub default: &'static str,
    /// One sentence on what it does.
    pub summary: &'static str,
}

/// What the `strength` of a kind measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// SI unit, as in [`parse_quantity`](crate::scene::parse_quantity); empty for a factor.
    pub unit: &'static str,
    /// Default, in that unit.
    pub default: f64,
    /// Least and greatest value; `None` for all above 0.
    pub range: Option<[f64; 2]>,
}

/// Default `radius`, in radii of the tool.
pub const DEFAULT_RADIUS: f64 = 3.0;

/// The key `radius` of edit kinds with a soft region.
pub(super) const RADIUS: Key = Key {
    name: KeyName::Radius,
    default: "three radii of the tool",
    summary: "Radius of what it acts on, 1.5 edges of a cell at least.",
};

/// The key `falloff` of edit kinds with a soft region.
pub(super) const FALLOFF: Key = Key {
    name: KeyName::Falloff,
    default: "smooth",
    summary: "How its weight falls from the centre to the radius: smooth, sphere, root, sharp, linear or constant.",
};
