//! A tree of boxes over the triangles of a surface. It is made once for a topology, and its boxes are brought up to date as the surface moves.

use pliant_solver::Vec3;

/// An axis-aligned box: least and greatest coordinates, m.
pub(super) type Bounds = [Vec3; 2];

/// The box of nothing.
pub(super) const EMPTY: Bounds = [
    Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
    Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
];

/// Whether two boxes are closer than `gap` (m) along each axis.
pub(super) fn are_near(a: &Bounds, b: &Bounds, gap: f64) -> bool {
    (0..3).all(|c| a[0][c] - b[1][c] <= gap && b[0][c] - a[1][c] <= gap)
}

/// The smallest box around two.
pub(super) fn union(a: &Bounds, b: &Bounds) -> Bounds {
    [a[0].inf(&b[0]), a[1].sup(&b[1])]
}

/// Most triangles of a leaf.
const LEAF: usize = 2;

/// A node of the tree, in depth-first order: its first child follows it.
#[derive(Clone, Copy, Debug)]
struct TreeNode {
    bounds: Bounds,
    /// Index of its second child; 0 for a leaf.
    second: u32,
    /// Its triangles, as a range of `order`.
    triangles: [u32; 2],
}

/// A binary tree of boxes around the triangles of a surface, which is refitted in every step.
#[derive(Debug, Default)]
pub(super) struct BoxTree {
    nodes: Vec<TreeNode>,
    /// Triangles, leaf by leaf.
    order: Vec<u32>,
}

impl BoxTree {
    /// A tree over triangles with these centres, m.
    pub fn new(centres: &[Vec3]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..centres.len() as u32).collect() };
        if !centres.is_empty() {
            tree.build(centres, 0, centres.len());
        }
        tree
    }

    /// Adds the nodes over a range of `order`.
    fn build(&mut self, centres: &[Vec3], first: usize, end: usize) {
        let at = self.nodes.len();
        self.nodes.push(TreeNode { bounds: EMPTY, second: 0, triangles: [first as u32, end as u32] });
        if end - first <= LEAF {
            return;
        }
        let centre = |t: &u32| centres[*t as usize];
        let [low, high] =
            self.order[first..end].iter().fold(EMPTY, |[low, high], t| [low.inf(&centre(t)), high.sup(&centre(t))]);
        let axis = (high - low).imax();
        let middle = (end - first) / 2;
        // Ties are broken by number, so that the tree is the same on every machine.
        let by = |a: &u32, b: &u32| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b));
        self.order[first..end].select_nth_unstable_by(middle, by);
        self.order[first..first + middle].sort_unstable();
        self.order[first + middle..end].sort_unstable();
        self.build(centres, first, first + middle);
        self.nodes[at].second = self.nodes.len() as u32;
        self.build(centres, first + middle, end);
    }

    /// Brings the boxes up to date with those of the triangles.
    pub fn refit(&mut self, bounds: impl Fn(u32) -> Bounds) {
        for at in (0..self.nodes.len()).rev() {
            let TreeNode { second, triangles: [first, end], .. } = self.nodes[at];
            self.nodes[at].bounds = match second {
                0 => self.order[first as usize..end as usize].iter().fold(EMPTY, |all, t| union(&all, &bounds(*t))),
                _ => union(&self.nodes[at + 1].bounds, &self.nodes[second as usize].bounds),
            };
        }
    }

    /// Calls `visit` with the triangles of leaves that are within `gap` (m) of a leaf of `other`, pair by pair.
    pub fn pairs(&self, other: &Self, gap: f64, stack: &mut Vec<[u32; 2]>, visit: impl FnMut(u32, u32)) {
        self.descend(other, false, gap, stack, visit);
    }

    /// Calls `visit` with each pair of different triangles whose leaves are within `gap` (m) of each other, once.
    pub fn own_pairs(&self, gap: f64, stack: &mut Vec<[u32; 2]>, visit: impl FnMut(u32, u32)) {
        self.descend(self, true, gap, stack, visit);
    }

    /// Descends two trees, or one tree against itself.
    fn descend(
        &self,
        other: &Self,
        is_own: bool,
        gap: f64,
        stack: &mut Vec<[u32; 2]>,
        mut visit: impl FnMut(u32, u32),
    ) {
        stack.clear();
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            stack.push([0, 0]);
        }
        let list = |node: &TreeNode| node.triangles[0] as usize..node.triangles[1] as usize;
        while let Some([i, j]) = stack.pop() {
            let (a, b) = (&self.nodes[i as usize], &other.nodes[j as usize]);
            let is_same = is_own && i == j;
            if !is_same && !are_near(&a.bounds, &b.bounds, gap) {
                continue;
            }
            let size = |node: &TreeNode| node.triangles[1] - node.triangles[0];
            match (a.second, b.second) {
                (0, 0) => {
                    let (of_a, of_b) = (&self.order[list(a)], &other.order[list(b)]);
                    for (at, s) in of_a.iter().enumerate() {
                        let rest = if is_same { &of_b[at + 1..] } else { of_b };
                        rest.iter().for_each(|t| visit(*s, *t));
                    }
                }
                (second, _) if is_same => stack.extend([[second, second], [i + 1, second], [i + 1, i + 1]]),
                (second, of_other) if of_other == 0 || second != 0 && size(a) >= size(b) => {
                    stack.extend([[second, j], [i + 1, j]]);
                }
                (_, second) => stack.extend([[i, second], [i, j + 1]]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::testing::Random;
    use std::collections::BTreeSet;

    #[test]
    fn pairs_are_those_of_brute_force_each_once() {
        let mut random = Random(11);
        let mut boxes = |count: usize, at: f64| -> Vec<Bounds> {
            let one = |random: &mut Random| {
                let low = Vec3::from_fn(|_, _| at + random.unit());
                [low, low + Vec3::from_fn(|_, _| 0.2 * random.unit())]
            };
            (0..count).map(|_| one(&mut random)).collect()
        };
        let (a, b) = (boxes(90, 0.0), boxes(70, 0.4));
        let tree = |boxes: &[Bounds]| {
            let mut tree = BoxTree::new(&boxes.iter().map(|[low, high]| 0.5 * (low + high)).collect::<Vec<_>>());
            tree.refit(|t| boxes[t as usize]);
            tree
        };
        let (mut stack, gap) = (Vec::new(), 0.03);
        let mut found = Vec::new();
        tree(&a).pairs(&tree(&b), gap, &mut stack, |s, t| {
            if are_near(&a[s as usize], &b[t as usize], gap) {
                found.push((s, t));
            }
        });
        let all = (0..90).flat_map(|s| (0..70).map(move |t| (s, t)));
        let expected: BTreeSet<_> = all.filter(|(s, t)| are_near(&a[*s as usize], &b[*t as usize], gap)).collect();
        assert_eq!(found.len(), expected.len());
        assert_eq!(found.into_iter().collect::<BTreeSet<_>>(), expected);
        let mut own = Vec::new();
        tree(&a).own_pairs(gap, &mut stack, |s, t| {
            if are_near(&a[s as usize], &a[t as usize], gap) {
                own.push((s.min(t), s.max(t)));
            }
        });
        let all = (0..90).flat_map(|t| (0..t).map(move |s| (s, t)));
        let expected: BTreeSet<_> = all.filter(|(s, t)| are_near(&a[*s as usize], &a[*t as usize], gap)).collect();
        assert_eq!(own.len(), expected.len());
        assert_eq!(own.into_iter().collect::<BTreeSet<_>>(), expected);
    }
}
