//! Keys of an `[[edit]]` that only some kinds read, and their defaults.

/// A key of the palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyName {
    /// `limit`, N
    Limit,
    /// `radius`, m
    Radius,
    /// `falloff`, a [`Falloff`](super::Falloff)
    Falloff,
    /// `strength`, in the unit of the kind
    Strength,
}

impl KeyName {
    /// As scenes write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Radius => "radius",
            Self::Falloff => "falloff",
            Self::Strength => "strength",
        }
    }
}

/// A key that a kind of edit reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Name of the key.
    pub name: KeyName,
    /// The default, as a scene could write it or in words.
    pub default: &'static str,
    /// One sentence on what it does.
    pub summary: &'static str,
}

/// What the `strength` of a kind measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// SI unit, as in [`parse_quantity`](crate::scene::parse_quantity).
    pub unit: &'static str,
    /// In that unit.
    pub default: f64,
}

/// Radii of the tool in the default `radius`.
pub(crate) const DEFAULT_RADIUS: f64 = 3.0;

/// `radius` of every kind with a soft region.
pub(super) const RADIUS: Key = Key {
    name: KeyName::Radius,
    default: "three radii of the tool",
    summary: "Radius of what it acts on, 1.5 edges of a cell at least.",
};

/// `falloff` of every kind with a soft region.
pub(super) const FALLOFF: Key = Key {
    name: KeyName::Falloff,
    default: "smooth",
    summary: "How its weight falls from the centre to the radius: smooth, sphere, root, sharp, linear or constant.",
};
