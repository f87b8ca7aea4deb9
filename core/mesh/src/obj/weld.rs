//! Welding of a document: vertices of borders that lie at one place become one vertex of its faces.
//!
//! Programs write a vertex twice where texture coordinates, normals or patches of a model end, and once for each face in triangle soups. Such a model looks whole and
//! falls apart. The text of the file stays as it is: only what faces mean by their vertices changes, and rows of vertices that no face means any more follow the others.

use std::borrow::Cow;
use std::collections::HashMap;

use super::ObjDocument;
use crate::check::FOLDED;
use crate::geometry::{Vec3, place_bits};
use crate::{DisjointSets, Side, Surface};

/// Comment in a file that a program of this engine has written after a cut through a surface without an inside: its slits look like borders that are to be welded.
pub const CUT_BORDERS: &str = "# borders that lie together are cuts";
/// Place of a vertex that is on no border.
const NO_PLACE: u32 = u32::MAX;
/// Number of a box of the grid of places from which on neighbours are no longer distinguished in double precision, 2^52.
const FARTHEST: f64 = 4_503_599_627_370_496.0;

impl ObjDocument {
    /// Pairs of vertices of borders of `surface`, the surface of this document, at most `distance` (units of its points) apart, in ascending order, each with the one that [`Self::weld`] puts in its place, the first of the file.
    ///
    /// Only borders that continue each other have pairs: an edge of one triangle along an edge of another, which may be turned over. Edges where three and more lie together have
    /// none, nor have the two sides of a leaf that is modelled twice, once for each side, nor what would give a face the same vertex twice.
    pub fn coincident_borders(&self, surface: &Surface, distance: f64) -> Vec<[u32; 2]> {
        let edges = surface.edges();
        let mut is_border = vec![false; surface.points.len()];
        for (vertices, _) in edges.iter().filter(|(_, sides)| sides.len() == 1) {
            vertices.iter().for_each(|v| is_border[*v as usize] = true);
        }
        let places = places(&surface.points, &is_border, distance);
        // Sides by the places they lead between, lower and higher: those of borders, and how many there are with all others.
        let mut together: HashMap<[u32; 2], (Vec<Side>, usize)> = HashMap::new();
        for (vertices, sides) in edges.iter() {
            let [a, b] = vertices.map(|v| places[v as usize]);
            if a == b || a == NO_PLACE || b == NO_PLACE {
                continue;
            }
            let (borders, count) = together.entry([a.min(b), a.max(b)]).or_default();
            *count += sides.len();
            borders.extend(sides.iter().filter(|_| sides.len() == 1));
        }
        let mut sets = DisjointSets::new(surface.points.len());
        let mut joined: Vec<_> =
            together.into_values().filter(|(borders, count)| borders.len() == 2 && *count == 2).collect();
        joined.sort_unstable_by_key(|(borders, _)| borders[0].triangle);
        for (borders, _) in joined {
            let [[a, b], [c, d]] = [borders[0], borders[1]].map(|side| surface.ends(side));
            let normals =
                [borders[0], borders[1]].map(|side| surface.cross(&surface.triangles[side.triangle as usize]));
            // Both run along the edge the other way, or one is turned over.
            let is_turned = places[a as usize] == places[c as usize];
            let ([c, d], sense) = if is_turned { ([d, c], -1.0) } else { ([c, d], 1.0) };
            let is_folded = sense * normals[0].dot(&normals[1]) < FOLDED * normals[0].norm() * normals[1].norm();
            if !is_folded {
                sets.unite(a, d);
                sets.unite(b, c);
            }
        }
        // What a face would have twice stays apart.
        let mut is_apart = vec![false; surface.points.len()];
        for face in self.faces() {
            let mut of_face: Vec<u32> = face.corners.iter().map(|corner| sets.find(corner.v)).collect();
            of_face.sort_unstable();
            of_face.windows(2).filter(|pair| pair[0] == pair[1]).for_each(|pair| is_apart[pair[0] as usize] = true);
        }
        let pairs = (0..surface.points.len() as u32).map(|v| [v, sets.find(v)]);
        pairs.filter(|[v, first]| v != first && !is_apart[*first as usize]).collect()
    }

    /// Puts the second vertex of each pair in the place of the first in all faces. The text stays; [`Self::write`] moves rows of replaced vertices as those in their place.
    ///
    /// # Panics
    /// If a vertex is not there.
    pub fn weld(&mut self, pairs: &[[u32; 2]]) {
        let mut of: Vec<u32> = (0..self.positions().len() as u32).collect();
        pairs.iter().for_each(|[vertex, place]| of[*vertex as usize] = *place);
        self.parsed.corners.iter_mut().for_each(|corner| corner.v = of[corner.v as usize]);
        self.welds.extend_from_slice(pairs);
        self.welds.sort_unstable();
    }

    /// Replaced vertices, each with the one in its place.
    pub fn welds(&self) -> &[[u32; 2]] {
        &self.welds
    }

    /// Whether the file says by [`CUT_BORDERS`] that borders which lie together are cuts.
    pub fn has_cut_borders(&self) -> bool {
        let lines = self.bytes.split(|byte| *byte == b'\n' || *byte == b'\r');
        lines.into_iter().any(|line| line == CUT_BORDERS.as_bytes())
    }

    /// The vertex that faces mean in the place of `vertex`: itself, if it is not replaced.
    pub fn in_place_of(&self, vertex: u32) -> u32 {
        match self.welds.binary_search_by_key(&vertex, |[replaced, _]| *replaced) {
            Ok(found) => self.welds[found][1],
            Err(_) => vertex,
        }
    }

    /// Positions (n x 3, file units) with those of replaced vertices moved as the ones in their place.
    pub(super) fn with_welds<'a>(&self, positions: &'a [Vec3]) -> Cow<'a, [Vec3]> {
        let own = self.positions();
        if self.welds.is_empty() || positions.len() != own.len() {
            return Cow::Borrowed(positions);
        }
        let mut moved = positions.to_vec();
        for &[vertex, place] in &self.welds {
            let [vertex, place] = [vertex, place].map(|v| v as usize);
            moved[vertex] = match positions[place] == own[place] {
                true => own[vertex],
                false if own[vertex] == own[place] => positions[place],
                false => own[vertex] + (positions[place] - own[place]),
            };
        }
        Cow::Owned(moved)
    }
}

/// Numbers of places of the vertices for which `is_border` holds: the first vertex of those that lie together; [`NO_PLACE`] for others.
fn places(points: &[Vec3], is_border: &[bool], distance: f64) -> Vec<u32> {
    let of_borders = || (0..points.len() as u32).filter(|v| is_border[*v as usize]);
    let at = |v: u32| points[v as usize];
    let mut sets = DisjointSets::new(points.len());
    if distance > 0.0 {
        // What is that near lies in the same or a neighbouring box of a grid.
        let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for v in of_borders() {
            let [x, y, z]: [i64; 3] = (at(v) / distance).map(|c| c.floor().clamp(-FARTHEST, FARTHEST) as i64).into();
            let around = (0..27).map(|i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]);
            for other in around.filter_map(|key| boxes.get(&key)).flatten() {
                if (at(*other) - at(v)).norm() <= distance {
                    sets.unite(v, *other);
                }
            }
            boxes.entry([x, y, z]).or_default().push(v);
        }
    } else {
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        of_borders().for_each(|v| sets.unite(v, *known.entry(place_bits(at(v))).or_insert(v)));
    }
    let mut places = vec![NO_PLACE; points.len()];
    of_borders().for_each(|v| places[v as usize] = sets.find(v));
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Kind, check};
    use crate::testing::{Apart, Random, apart, document, models};

    fn welded(text: &str, distance: f64) -> ObjDocument {
        let mut document = document(text);
        let pairs = document.coincident_borders(&Surface::from_document(&document), distance);
        document.weld(&pairs);
        document
    }

    fn kinds(document: &ObjDocument) -> Vec<(Kind, usize)> {
        check(&Surface::from_document(document), document).iter().map(|finding| (finding.kind, finding.count)).collect()
    }

    /// Models of every kind that are manifolds, in pieces: each face on its own, patches of seven faces, and random patches.
    fn in_pieces() -> Vec<(String, ObjDocument, Apart)> {
        let mut found = Vec::new();
        for seed in 0..3 {
            for model in models(4, seed).into_iter().filter(|model| model.genus.is_some()) {
                let whole = model.document();
                let random = std::cell::RefCell::new(Random(seed));
                let patches: Vec<usize> = whole.faces().map(|_| random.borrow_mut().below(5) as usize).collect();
                let ways: [&dyn Fn(usize) -> usize; 3] = [&|face| face, &|face| face / 7, &|face| patches[face]];
                for (way, patch_of) in ways.iter().enumerate() {
                    found.push((format!("{} {seed} {way}", model.name), whole.clone(), apart(&whole, patch_of)));
                }
            }
        }
        assert!(found.len() > 60, "{}", found.len());
        found
    }

    #[test]
    fn models_in_pieces_are_those_that_they_were() {
        for (name, whole, Apart { text, copy_of }) in in_pieces() {
            let document = welded(&text, 0.0);
            let as_file = self::document(&text);
            assert!(kinds(&as_file).iter().any(|(kind, _)| *kind == Kind::Border), "{name}");
            let own = |vertex: u32| copy_of[vertex as usize];
            for [vertex, place] in document.welds() {
                assert_eq!(own(*vertex), own(*place), "{name}: of two vertices of the whole");
            }
            let [now, then] = [&document, &whole].map(Surface::from_document);
            assert_eq!(now.edges().len(), then.edges().len(), "{name}");
            assert_eq!(now.shells(), then.shells(), "{name}");
            // A vertex that no face of the whole uses is not in the pieces.
            let used = |kinds: Vec<(Kind, usize)>| {
                kinds.into_iter().filter(|(kind, _)| *kind != Kind::UnusedVertex).collect::<Vec<_>>()
            };
            assert_eq!(used(kinds(&document)), used(kinds(&whole)), "{name}");
        }
    }

    #[test]
    fn the_file_stays_and_pieces_move_together() {
        for (name, _, Apart { text, copy_of }) in in_pieces() {
            let document = welded(&text, 0.0);
            let written = |positions: &[Vec3]| {
                let mut bytes = Vec::new();
                document.write(positions, None, &mut bytes).unwrap();
                bytes
            };
            assert!(written(document.positions()) == document.bytes(), "{name}");
            let mut moved = document.positions().to_vec();
            let places: Vec<u32> = document.welds().iter().map(|[_, place]| *place).collect();
            places.iter().for_each(|place| moved[*place as usize] = Vec3::repeat(f64::from(copy_of[*place as usize])));
            let back = self::document(std::str::from_utf8(&written(&moved)).unwrap());
            for [vertex, place] in document.welds().iter().map(|pair| pair.map(|v| v as usize)) {
                assert_eq!(back.positions()[vertex], back.positions()[place], "{name}");
                assert_eq!(back.positions()[vertex], moved[place], "{name}");
            }
        }
    }

    #[test]
    fn within_a_distance_pieces_need_not_touch() {
        let random = &mut Random(8);
        for (name, whole, Apart { text, .. }) in in_pieces() {
            let exact = document(&text);
            let size = Surface::from_document(&whole).bounds().longest_edge();
            let step = 1e-7 * size;
            let shaken: Vec<Vec3> = exact.positions().iter().map(|p| p + step * random.vector()).collect();
            let mut bytes = Vec::new();
            exact.write(&shaken, None, &mut bytes).unwrap();
            let text = String::from_utf8(bytes).unwrap();
            let edges = |document: &ObjDocument| Surface::from_document(document).edges().len();
            assert_eq!(welded(&text, 0.0).welds().len(), 0, "{name}");
            let near = welded(&text, 4.0 * step);
            assert_eq!(edges(&near), edges(&whole), "{name}");
            // Each goes as far as the one in its place.
            let way = size * Vec3::new(1.0, 2.0, 3.0);
            let moved: Vec<Vec3> = near.positions().iter().map(|p| p + way).collect();
            for (to, from) in near.with_welds(&moved).iter().zip(near.positions()) {
                assert!((to - from - way).norm() < 1e-12 * (way.norm() + from.norm()), "{name}");
            }
        }
    }

    #[test]
    fn what_does_not_continue_stays_apart() {
        let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
        let none = [
            ("a leaf from both sides", format!("{corners}{corners}f 1 2 3 4\nf 8 7 6 5\n")),
            (
                "three at an edge",
                format!(
                    "{corners}v 0 0 0\nv 1 0 0\nv 0 -1 0\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3 4\nf 6 5 7\nf 9 8 10\n"
                ),
            ),
            ("at a corner", format!("{corners}v 1 1 0\nv 2 1 0\nv 2 2 0\nf 1 2 3 4\nf 5 6 7\n")),
            ("two ends of one face", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nf 1 2 3 4\n".to_owned()),
        ];
        for (what, text) in none {
            assert!(welded(&text, 0.0).welds().is_empty(), "{what}");
        }
        let continued = format!("{corners}v 0 0 -0\nv 1 0 0\nv 0.5 -1 0\nf 1 2 3 4\nf 6 5 7\n");
        assert_eq!(welded(&continued, 0.0).welds(), [[4, 0], [5, 1]]);
        let turned_over = continued.replace("f 6 5 7", "f 5 6 7");
        assert_eq!(welded(&turned_over, 0.0).welds(), [[4, 0], [5, 1]]);
        // The two sides of a leaf stay apart also where one of them is turned over.
        let leaf = format!("{corners}{corners}f 1 2 3 4\nf 5 6 7 8\n");
        assert!(welded(&leaf, 0.0).welds().is_empty());
    }
}
