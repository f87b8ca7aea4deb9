//! The collisions of a step and the ties of bodies: rounds of detection and of the implicit solve, then impulses and impact zones for what is left.

use super::candidates::{find_impacts, list};
use super::contact::{ContactData, feature_key};
use super::dual::{DualBodies, DualMember};
use super::features::{Gap, Kind, gap};
use super::{BodyCollisions, Candidate, CollisionReport, Compliance, LISTED, Member, NEAR, RECOVERY_TIME, zones};
use pliant_mesh::DisjointSets;
use pliant_solver::Vec3;

/// Most rounds of detection and implicit solves.
const MAX_SOLVES: usize = 10;
/// Most rounds of impulses.
const MAX_ROUNDS: usize = 30;
/// Most rounds in which impact zones grow.
const MAX_ZONE_ROUNDS: usize = 50;
/// Least part of a step that is left when an impulse acts: what closes later closes by rounding.
const LEAST_REMAINING: f64 = 1e-3;

impl BodyCollisions {
    /// Takes collisions within the step of `dt` (s) away.
    pub fn resolve(&mut self, dt: f64, bodies: &mut dyn Compliance) -> CollisionReport {
        let mut report = CollisionReport::default();
        self.from.clear();
        for member in &self.members {
            let surface = &self.surfaces[member.body as usize];
            let first = member.node as usize;
            surface.positions(&self.nodes.start[first..], &mut self.from);
        }
        self.update_ends();
        self.list_candidates();
        report.candidates = self.candidates.len();
        self.set.clear();
        if self.candidates.is_empty() && self.ties.is_empty() && !self.has_predicted() {
            self.warm_start.clear();
            return report;
        }
        if self.solve_implicit(dt, bodies, &mut report) {
            return report;
        }
        self.impulses.set.clear();
        for _ in 0..MAX_ROUNDS {
            let first = self.find_impacts();
            if first.is_infinite() {
                return report;
            }
            report.rounds += 1;
            let time = first.min(1.0 - LEAST_REMAINING) * dt;
            self.impulses.set.clear();
            self.add_near(dt, time);
            self.add_impacts(dt, time);
            self.push(dt, time, &mut report);
        }
        self.move_zones(dt, &mut report);
        report
    }

    /// Rounds of the implicit solve, each with the contacts of the round before and those of the impacts that it left. Returns whether no impact is left.
    fn solve_implicit(&mut self, dt: f64, bodies: &mut dyn Compliance, report: &mut CollisionReport) -> bool {
        self.free_x.clone_from(&self.nodes.x);
        self.free_v.clone_from(&self.nodes.v);
        let mut members = std::mem::take(&mut self.dual_members);
        members.clear();
        members.extend((0..self.members.len()).map(|at| {
            let Member { body, node, stands, .. } = self.members[at];
            let end = self.members.get(at + 1).map_or(self.nodes.len(), |next| next.node as usize);
            DualMember { body: body as usize, nodes: node as usize..end, is_moved: !stands }
        }));
        for at in 0..self.candidates.len() {
            let candidate = self.candidates[at];
            let pair = self.pairs[candidate.pair as usize];
            let gap = gap(candidate.kind, &candidate.vertices.map(|v| self.from[v as usize]));
            if gap.is_inside && gap.distance < NEAR * pair.thickness {
                let open = gap.distance - pair.thickness;
                let bound = if open > 0.0 { -open / dt } else { -open / RECOVERY_TIME };
                self.add_contact(&candidate, &gap, bound, true);
            }
        }
        self.add_tie_rows(dt);
        let mut is_clear = false;
        for solve in 0..MAX_SOLVES {
            let first = self.set.contacts.len();
            is_clear = self.find_impacts().is_infinite();
            if !is_clear {
                self.add_first_impacts(dt);
            }
            self.warm_start.apply(&mut self.set, if solve == 0 { 0 } else { first });
            let is_idle = self.set.is_empty() && !self.has_predicted();
            if is_idle || bodies.is_cancelled() || (solve > 0 && self.set.contacts.len() == first) {
                break;
            }
            let mut answering = DualBodies { nodes: &self.nodes, members: &members, compliance: &mut *bodies };
            let solved = self.dual.solve(&mut self.set, &self.free_v, &mut answering, dt);
            report.solves += 1;
            report.contacts = self.set.contacts.len();
            report.iterations += solved.iterations;
            report.solver_iterations += solved.solver_iterations;
            report.has_converged &= solved.converged;
            let ends = self.nodes.x.iter_mut().zip(&mut self.nodes.v);
            for ((x, v), ((free_x, free_v), by)) in
                ends.zip(self.free_x.iter().zip(&self.free_v).zip(&self.dual.changes))
            {
                (*x, *v) = (free_x + dt * by, free_v + by);
            }
            self.follow();
            report.has_pushed = true;
            is_clear = self.find_impacts().is_infinite();
            if is_clear {
                break;
            }
        }
        self.dual_members = members;
        self.warm_start.record(&self.set);
        let totals = &mut self.totals;
        self.set.visit(|bodies, impulse| {
            totals[bodies[0] as usize] += impulse;
            totals[bodies[1] as usize] -= impulse;
        });
        is_clear
    }

    /// Whether a node has had an impulse for the contact of the step before.
    fn has_predicted(&self) -> bool {
        self.nodes.predicted.iter().any(|p| *p != Vec3::zeros())
    }

    /// Adds the contacts of the first impacts of features, with the geometry at the time of each.
    fn add_first_impacts(&mut self, dt: f64) {
        let mut impacts = std::mem::take(&mut self.first_impacts);
        for &at in impacts.find(&self.candidates) {
            let candidate = self.candidates[at as usize];
            let [from, to] = [&self.from, &self.to].map(|x| candidate.vertices.map(|v| x[v as usize]));
            let met: [Vec3; 4] = std::array::from_fn(|i| from[i] + candidate.impact * (to[i] - from[i]));
            let gap = gap(candidate.kind, &met);
            if gap.normal == Vec3::zeros() {
                continue;
            }
            let start: Vec3 = (0..4).map(|i| gap.weights[i] * from[i]).sum();
            let open = gap.normal.dot(&start) - self.pairs[candidate.pair as usize].thickness;
            self.add_contact(&candidate, &gap, -open.max(0.0) / dt, true);
        }
        self.first_impacts = impacts;
    }

    /// Applies the impulses at `time` (s) within a step of `dt` (s).
    fn push(&mut self, dt: f64, time: f64, report: &mut CollisionReport) {
        if self.impulses.set.is_empty() {
            return;
        }
        self.impulses.apply(&mut self.nodes, dt - time);
        let totals = &mut self.totals;
        self.impulses.set.visit(|bodies, impulse| {
            if impulse != Vec3::zeros() {
                report.has_pushed = true;
                totals[bodies[0] as usize] += impulse;
                totals[bodies[1] as usize] -= impulse;
            }
        });
        self.follow();
    }

    /// Brings vertices up to date with nodes, and lists candidates again if they have left the room that was searched.
    fn follow(&mut self) {
        self.update_ends();
        let has_left = self.pairs.iter().any(|pair| {
            pair.members.iter().any(|&at| {
                let range = self.vertices_of(at);
                let ends = self.to[range.clone()].iter().zip(&self.listed[range]);
                ends.fold(0.0, |most: f64, (to, listed)| most.max((to - listed).norm_squared()))
                    > ((LISTED - NEAR) * pair.thickness).powi(2)
            })
        });
        if has_left {
            self.list_candidates();
        }
    }

    fn vertices_of(&self, member: usize) -> std::ops::Range<usize> {
        let Member { body, vertex, .. } = self.members[member];
        vertex as usize..vertex as usize + self.surfaces[body as usize].vertices()
    }

    /// Positions and velocities of the vertices at the end of the step.
    fn update_ends(&mut self) {
        self.to.clear();
        self.speed.clear();
        for member in &self.members {
            let surface = &self.surfaces[member.body as usize];
            let first = member.node as usize;
            surface.positions(&self.nodes.x[first..], &mut self.to);
            surface.interpolate(&self.nodes.v[first..], &mut self.speed);
        }
    }

    /// Lists the features whose ways come near each other.
    fn list_candidates(&mut self) {
        self.listed.clone_from(&self.to);
        for at in 0..self.members.len() {
            let range = self.vertices_of(at);
            let surface = &mut self.surfaces[self.members[at].body as usize];
            surface.refit(&self.from[range.clone()], &self.to[range]);
        }
        let Self { surfaces, members, pairs, candidates, stack, from, to, .. } = self;
        list(surfaces, members, pairs, from, to, stack, candidates);
    }

    /// Finds the candidates that meet. Returns the time of the first impact as a fraction of the step, infinite if there is none.
    fn find_impacts(&mut self) -> f64 {
        find_impacts(&mut self.candidates, &self.pairs, &self.from, &self.to)
    }

    /// Positions of the vertices of a candidate at `before` (s) before the end of the step, on the straight way that its velocities make.
    fn place(&self, candidate: &Candidate, before: f64) -> [Vec3; 4] {
        candidate.vertices.map(|v| self.to[v as usize] - before * self.speed[v as usize])
    }

    /// Adds the contacts of features that are near each other at `time` (s) within a step of `dt` (s).
    fn add_near(&mut self, dt: f64, time: f64) {
        for at in 0..self.candidates.len() {
            let candidate = self.candidates[at];
            let thickness = self.pairs[candidate.pair as usize].thickness;
            let gap = gap(candidate.kind, &self.place(&candidate, dt - time));
            if gap.is_inside && gap.distance < NEAR * thickness {
                self.add_impulse(&candidate, &gap, dt - time);
            }
        }
    }

    /// Adds the contacts of features that meet in the rest of the step from `time` (s) on.
    fn add_impacts(&mut self, dt: f64, time: f64) {
        for at in 0..self.candidates.len() {
            let candidate = self.candidates[at];
            if candidate.impact.is_infinite() {
                continue;
            }
            let thickness = self.pairs[candidate.pair as usize].thickness;
            let gap = gap(candidate.kind, &self.place(&candidate, dt - time));
            let is_known = gap.is_inside && gap.distance < NEAR * thickness;
            if !is_known && (gap.is_inside || gap.distance < NEAR * thickness) && gap.normal != Vec3::zeros() {
                self.add_impulse(&candidate, &gap, dt - time);
            }
        }
    }

    fn add_impulse(&mut self, candidate: &Candidate, gap: &Gap, remaining: f64) {
        let thickness = self.pairs[candidate.pair as usize].thickness;
        self.add_contact(candidate, gap, -(gap.distance - thickness).max(0.0) / remaining, false);
    }

    /// Adds a contact that parts at least at `bound` (m/s), for the implicit solve or for impulses.
    fn add_contact(&mut self, candidate: &Candidate, gap: &Gap, bound: f64, is_implicit: bool) {
        let pair = self.pairs[candidate.pair as usize];
        let Self { impulses, set, surfaces, members, nodes, .. } = self;
        let set = if is_implicit { set } else { &mut impulses.set };
        let is_first = |k: usize| if candidate.kind == Kind::VertexTriangle { k == 0 } else { k > 1 };
        let member_of = |v: u32| members[members.partition_point(|m| m.vertex <= v) - 1];
        let carriers = |k: usize| {
            let v = candidate.vertices[k];
            let member = member_of(v);
            (member.node, surfaces[member.body as usize].carriers(v - member.vertex))
        };
        let body_of = |side: bool| {
            let k = (0..4).find(|k| is_first(*k) == side).unwrap_or(0);
            member_of(candidate.vertices[k]).body
        };
        let own = candidate.vertices.map(|v| {
            let member = member_of(v);
            (member.body, v - member.vertex)
        });
        let data = ContactData {
            bound,
            friction: pair.friction,
            thickness: pair.thickness,
            bodies: [body_of(true), body_of(false)],
            key: feature_key(candidate.kind, own),
        };
        set.add(gap, carriers, nodes, data);
    }

    /// Moves the nodes of collisions that are left as rigid zones, which grow until none is left.
    fn move_zones(&mut self, dt: f64, report: &mut CollisionReport) {
        let mut sets = DisjointSets::new(self.nodes.len());
        let mut is_in_zone = vec![false; self.nodes.len()];
        for _ in 0..MAX_ZONE_ROUNDS {
            if self.find_impacts().is_infinite() {
                return;
            }
            for candidate in self.candidates.iter().filter(|candidate| candidate.impact.is_finite()) {
                let mut first = None;
                for v in candidate.vertices {
                    let member = self.members[self.members.partition_point(|m| m.vertex <= v) - 1];
                    for (node, _) in self.surfaces[member.body as usize].carriers(v - member.vertex) {
                        let node = member.node + node;
                        is_in_zone[node as usize] = true;
                        sets.unite(*first.get_or_insert(node), node);
                    }
                }
            }
            let mut zones: Vec<(u32, u32)> =
                (0..self.nodes.len() as u32).filter(|i| is_in_zone[*i as usize]).map(|i| (sets.find(i), i)).collect();
            zones.sort_unstable();
            report.zones = 0;
            for zone in zones.chunk_by(|a, b| a.0 == b.0) {
                let ids: Vec<u32> = zone.iter().map(|(_, i)| *i).collect();
                zones::move_rigidly(&ids, &mut self.nodes, dt);
                report.zones += 1;
            }
            report.has_pushed = true;
            self.follow();
        }
        report.left = self.candidates.iter().filter(|candidate| candidate.impact.is_finite()).count();
    }
}
