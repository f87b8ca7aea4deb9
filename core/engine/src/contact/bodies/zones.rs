//! Impact zones: nodes whose collisions impulses have not resolved move as one rigid body for the rest of the step, with the linear and angular
//! momentum that they have (Provot 1997; Harmon, Vouga, Tamstorf and Grinspun 2008).

use super::nodes::CollisionNodes;
use nalgebra::Matrix3;
use pliant_solver::Vec3;

/// Largest angle by which a zone turns in a step, rad: the straight paths of its nodes would cut into each other.
const MAX_TURN: f64 = 0.5;

/// Moves the nodes of a zone as a rigid body, from where they were at the start of a step of `dt` (s). A zone with a node that contact cannot move goes with
/// that node.
pub(super) fn move_rigidly(zone: &[u32], nodes: &mut CollisionNodes, dt: f64) {
    let ids = || zone.iter().map(|i| *i as usize);
    let held = ids().filter(|&i| !nodes.is_free(i));
    let (count, moved, v) = held.fold((0, Vec3::zeros(), Vec3::zeros()), |(count, moved, v), i| {
        (count + 1, moved + nodes.x[i] - nodes.start[i], v + nodes.v[i])
    });
    if count > 0 {
        let (moved, v) = (moved / f64::from(count), v / f64::from(count));
        for i in ids().filter(|&i| nodes.inverse_mass[i] > 0.0) {
            nodes.x[i] = nodes.start[i] + moved;
            nodes.v[i] = v;
        }
        return;
    }
    let mass = |i: usize| 1.0 / nodes.inverse_mass[i];
    let total: f64 = ids().map(mass).sum();
    let mean = |field: &[Vec3]| ids().map(|i| mass(i) * field[i]).sum::<Vec3>() / total;
    let (from, to, velocity) = (mean(&nodes.start), mean(&nodes.x), mean(&nodes.v));
    let momentum: Vec3 = ids().map(|i| mass(i) * (nodes.x[i] - to).cross(&(nodes.v[i] - velocity))).sum();
    let energy: f64 = ids().map(|i| mass(i) * (nodes.v[i] - velocity).norm_squared()).sum();
    let inertia = |turn: &Matrix3<f64>| -> Matrix3<f64> {
        let each = ids().map(|i| {
            let arm = turn * (nodes.start[i] - from);
            mass(i) * (arm.norm_squared() * Matrix3::identity() - arm * arm.transpose())
        });
        each.sum()
    };
    let Some(turn) = spin(&inertia(&Matrix3::identity()), momentum).map(|spin| rotation(dt * spin)) else {
        // Nodes on a line, or in a point, have no turn about it.
        return translate(zone, nodes, to - from, velocity);
    };
    let Some(mut spin) = spin(&inertia(&turn), momentum) else {
        return translate(zone, nodes, to - from, velocity);
    };
    // The shape at the start may be narrower than that at the end, and would turn with more energy.
    let turning = momentum.dot(&spin);
    if turning > energy {
        spin *= (energy / turning).sqrt();
    }
    for i in zone.iter().map(|i| *i as usize) {
        let arm = turn * (nodes.start[i] - from);
        nodes.x[i] = to + arm;
        nodes.v[i] = velocity + spin.cross(&arm);
    }
}

/// Moves nodes by a displacement (m) from where they were at the start of the step, and gives them a velocity (m/s).
fn translate(zone: &[u32], nodes: &mut CollisionNodes, by: Vec3, velocity: Vec3) {
    for i in zone.iter().map(|i| *i as usize) {
        nodes.x[i] = nodes.start[i] + by;
        nodes.v[i] = velocity;
    }
}

/// Angular velocity of a body with an angular momentum, rad/s; `None` if its inertia is singular.
fn spin(inertia: &Matrix3<f64>, momentum: Vec3) -> Option<Vec3> {
    let scale = inertia.trace() / 3.0;
    let is_regular = inertia.determinant() > 1e-9 * scale * scale * scale;
    let inverse = is_regular.then(|| inertia.try_inverse()).flatten()?;
    Some(inverse * momentum)
}

/// The rotation of Cayley's formula about `turn`, nearly by its length (rad) and at most by [`MAX_TURN`].
fn rotation(turn: Vec3) -> Matrix3<f64> {
    let angle = turn.norm();
    let half = 0.5 * if angle > MAX_TURN { MAX_TURN / angle * turn } else { turn };
    let cross = half.cross_matrix();
    2.0 / (1.0 + half.norm_squared()) * (cross + cross * cross) + Matrix3::identity()
}
