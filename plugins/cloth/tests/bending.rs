//! Bending on four patterns of triangles: the energy of a cylinder, and the deflection of a cantilever.

mod strip;

use pliant_cloth::Cloth;
use pliant_plugin_api::kit::{self, Body, Sheet};
use pliant_plugin_api::param::{Params, Table, Value, defaults, position};
use pliant_plugin_api::{Material, TangentScale};
use strip::{PATTERNS, Pattern, strip};

/// Bending rigidity along the warp, N m.
const D: f64 = 15e-6;

/// Cloth with a bending model: 0 for coupled hinges, 1 for hinges alone.
fn cloth(bending: f64) -> Cloth {
    kit::material(&[("bending", bending), ("bending-warp", D)]).unwrap()
}

/// The Cholesky factor L of a symmetric positive definite matrix `L L^T`, dense.
struct Cholesky {
    n: usize,
    l: Vec<f64>,
}

impl Cholesky {
    /// Factorises the lower triangle of a row-major matrix.
    fn new(mut a: Vec<f64>, n: usize) -> Self {
        for j in 0..n {
            for i in j..n {
                let (row, column) = (&a[i * n..i * n + j], &a[j * n..j * n + j]);
                let sum = a[i * n + j] - row.iter().zip(column).map(|(p, q)| p * q).sum::<f64>();
                if i == j {
                    assert!(sum > 0.0, "not positive definite at {j}: {sum}");
                    a[j * n + j] = sum.sqrt();
                } else {
                    a[i * n + j] = sum / a[j * n + j];
                }
            }
        }
        Self { n, l: a }
    }

    /// Replaces b by `L^-1 b`.
    fn forward(&self, b: &mut [f64]) {
        for i in 0..self.n {
            let row = &self.l[i * self.n..i * self.n + i];
            b[i] = (b[i] - row.iter().zip(&b[..i]).map(|(p, q)| p * q).sum::<f64>()) / self.l[i * self.n + i];
        }
    }

    /// Replaces b by `(L L^T)^-1 b`.
    fn solve(&self, b: &mut [f64]) {
        self.forward(b);
        for i in (0..self.n).rev() {
            b[i] /= self.l[i * self.n + i];
            let (head, tail) = b.split_at_mut(i);
            let row = &self.l[i * self.n..i * self.n + i];
            head.iter_mut().zip(row).for_each(|(h, l)| *h -= l * tail[0]);
        }
    }
}

/// The compliance between coupled hinges (m/N), summed over the triangles and factorised.
fn compliance(body: &Body, material: &Cloth) -> Cholesky {
    let compliances = body.compliances(material).unwrap();
    let hinges = body.strains(material).unwrap().corners;
    let n = hinges.len();
    let hinge_of_edge: std::collections::BTreeMap<[u32; 2], usize> =
        hinges.iter().zip(0..).map(|(h, e)| ([h[0].min(h[1]), h[0].max(h[1])], e)).collect();
    let mut sum = vec![0.0; n * n];
    for (e, t) in compliances.corners.iter().enumerate() {
        let hinge_of_side = |s: usize| hinge_of_edge.get(&[t[s].min(t[(s + 1) % 3]), t[s].max(t[(s + 1) % 3])]);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let plane = [[0, 1, 2], [1, 3, 4], [2, 4, 5]][i][j];
            if let (Some(p), Some(q)) = (hinge_of_side(i), hinge_of_side(j)) {
                sum[p * n + q] += compliances.plane(plane)[e];
            }
        }
    }
    Cholesky::new(sum, n)
}

/// Energy of the coupled hinges, J: `s . m / 2 = s . G^-1 s / 2`.
fn coupled_energy(body: &Body, material: &Cloth) -> f64 {
    let mut s = body.strains(material).unwrap().plane(0).to_vec();
    compliance(body, material).forward(&mut s);
    0.5 * s.iter().map(|v| v * v).sum::<f64>()
}

/// Clamps the ends of a strip at the positions `is_clamped` selects: adds hinges at the edges there, to a node without triangles that is
/// the mirror image of the opposite corner.
fn clamp(sheet: &mut Sheet, is_clamped: impl Fn(f64) -> bool) {
    let triangles: Vec<[u32; 3]> = sheet.triangles.nodes.as_chunks::<3>().0.to_vec();
    for [a, b, c] in triangles {
        for [a, b, o] in [[a, b, c], [b, c, a], [c, a, b]] {
            let [p, q, r] = [a, b, o].map(|n| sheet.rest[n as usize]);
            if p[0] == q[0] && is_clamped(p[0]) {
                sheet.hinges.nodes.extend([a, b, o, sheet.rest.len() as u32]);
                sheet.rest.push([2.0 * p[0] - r[0], r[1], 0.0]);
            }
        }
    }
}

/// The position on a cylinder about y of a node that rests at `rest` (m) in the plane; the nodes of the clamps, which are not on the
/// strip, lie in the tangent plane at its end.
fn on_cylinder(rest: [f64; 3], radius: f64, is_on_strip: bool) -> [f64; 3] {
    let arc_length = if is_on_strip { rest[0] } else { rest[0].clamp(0.0, 1.0) };
    let (s, c) = (arc_length / radius).sin_cos();
    let tangential = rest[0] - arc_length;
    [radius * s + tangential * c, rest[1], radius * (1.0 - c) + tangential * s]
}

/// The area of a strip, m^2.
fn area(sheet: &Sheet) -> f64 {
    sheet.points.measure.iter().sum()
}

#[test]
fn coupled_hinges_on_a_cylinder_have_the_energy_of_a_plate() {
    let (material, radius) = (cloth(0.0), 1.5);
    for pattern in PATTERNS {
        let mut sheet = strip(pattern, 12);
        let strip_nodes = sheet.rest.len();
        clamp(&mut sheet, |x| x == 0.0 || x == 1.0);
        let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
        for (n, x) in body.x.iter_mut().enumerate() {
            *x = on_cylinder(*x, radius, n < strip_nodes);
        }
        let ratio = coupled_energy(&body, &material) / (0.5 * D / radius.powi(2) * area(&sheet));
        println!("{pattern:?}: energy relative to that of a plate {ratio:.5}");
        assert!((ratio - 1.0).abs() < 0.02, "{pattern:?}: {ratio}");
    }
}

/// Energy of hinges alone on a strip bent along an axis (0 or 1), relative to that of a plate of rigidity D. The warp is along `warp`; the
/// rigidity along the weft is `weft` (N m).
fn energy_ratio_of_hinges(pattern: Pattern, axis: usize, warp: [f64; 3], weft: f64) -> f64 {
    let (cells, radius) = (48, 1.5);
    let mut values = defaults(Cloth::INFO.params);
    let mut set = |key: &str, value: Value| values[position(Cloth::INFO.params, key).unwrap()] = value;
    set("bending", Value::Number(1.0));
    set("bending-warp", Value::Number(D));
    set("bending-weft", Value::Number(weft));
    set("warp", Value::Table(Table { columns: 3, values: warp.to_vec() }));
    let material = Cloth::new(&Params::new(Cloth::INFO.params, &values)).unwrap();
    let membrane: Cloth = kit::material(&[("bending", 2.0)]).unwrap();
    let sheet = strip(pattern, cells);
    let bend = |x: &mut [f64; 3]| {
        let (s, c) = (x[axis] / radius).sin_cos();
        (x[axis], x[2]) = (radius * s, radius * (1.0 - c));
    };
    let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let mut flat = Body::new(&membrane, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    body.x.iter_mut().for_each(bend);
    flat.x.clone_from(&body.x);
    let energy = body.energy(&material).unwrap() - flat.energy(&membrane).unwrap();
    // At each free end half a row of cells has no hinge.
    let length = sheet.rest.iter().fold(0.0, |m: f64, x| m.max(x[axis]));
    let row = if axis == 1 && pattern == Pattern::Equilateral { 0.75_f64.sqrt() } else { 1.0 } / cells as f64;
    energy / (0.5 * D / radius.powi(2) * area(&sheet) * (1.0 - row / length))
}

#[test]
fn hinges_alone_have_the_energy_of_a_plate_on_regular_meshes_only() {
    for pattern in [Pattern::Regular, Pattern::Alternating, Pattern::Equilateral] {
        for axis in [0, 1] {
            let ratio = energy_ratio_of_hinges(pattern, axis, [1.0, 0.0, 0.0], D);
            println!("{pattern:?} along {axis}: {ratio:.5}");
            assert!((ratio - 1.0).abs() < 0.05, "{pattern:?} {axis}: {ratio}");
        }
    }
    let ratio = energy_ratio_of_hinges(Pattern::Irregular, 0, [1.0, 0.0, 0.0], D);
    assert!((ratio - 1.0).abs() > 0.02, "hinges alone are accurate on an irregular mesh: {ratio}");
}

#[test]
fn hinges_alone_have_the_rigidities_of_warp_and_weft() {
    for (axis, warp, rigidity) in [(0, [2.0, 0.0, 0.5], 1.0), (1, [1.0, 0.0, 0.0], 3.0), (0, [0.0, 1.0, 0.0], 3.0)] {
        let ratio = energy_ratio_of_hinges(Pattern::Alternating, axis, warp, 3.0 * D) / rigidity;
        assert!((ratio - 1.0).abs() < 0.05, "{axis} {warp:?}: {ratio}");
    }
}

#[test]
fn coupled_hinges_have_the_rigidities_of_warp_and_weft_flat_or_curved_at_rest() {
    let radius = 1.5;
    let material: Cloth = kit::material(&[("bending-warp", D), ("bending-weft", 3.0 * D)]).unwrap();
    let mut sheet = strip(Pattern::Irregular, 12);
    let strip_nodes = sheet.rest.len();
    clamp(&mut sheet, |x| x == 0.0 || x == 1.0);
    let bent: Vec<[f64; 3]> =
        sheet.rest.iter().enumerate().map(|(n, x)| on_cylinder(*x, radius, n < strip_nodes)).collect();
    let plate = 0.5 * D / radius.powi(2) * area(&sheet);
    // With the warp across the strip it bends along the weft.
    let mut across = sheet.clone();
    across.triangles.material.chunks_mut(2).for_each(|u| (u[0], u[1]) = (u[1], -u[0]));
    for (sheet, rigidity) in [(&sheet, 1.0), (&across, 3.0)] {
        for (rest, x) in [(&sheet.rest, &bent), (&bent, &sheet.rest)] {
            let mut body = Body::new(&material, rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            assert!(coupled_energy(&body, &material) < 1e-20 * plate);
            body.x.clone_from(x);
            let ratio = coupled_energy(&body, &material) / (rigidity * plate);
            assert!((ratio - 1.0).abs() < 0.02, "{rigidity}: {ratio}");
        }
    }
}

/// Deflection at the tip of a clamped strip under a uniform load q, to first order, relative to that of a plate, `q L^4 / (8 D)`.
fn cantilever_ratio(pattern: Pattern, cells: usize) -> f64 {
    let material = cloth(0.0);
    let mut sheet = strip(pattern, cells);
    let strip_nodes = sheet.rest.len();
    clamp(&mut sheet, |x| x == 0.0);
    let body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let factor = compliance(&body, &material);
    let strains = body.strains(&material).unwrap();
    let free: Vec<usize> = (0..strip_nodes).filter(|n| sheet.rest[*n][0] > 0.0).collect();
    // The stiffness ds/dz^T G^-1 ds/dz has the scalar products of the columns L^-1 ds/dz as entries.
    let columns: Vec<Vec<f64>> = free
        .iter()
        .map(|node| {
            let mut column = vec![0.0; strains.corners.len()];
            for (e, corners) in strains.corners.iter().enumerate() {
                for corner in (0..4).filter(|c| corners[*c] as usize == *node) {
                    column[e] += strains.plane(1 + 3 * corner + 2)[e];
                }
            }
            factor.forward(&mut column);
            column
        })
        .collect();
    let n = free.len();
    let dot = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f64>();
    let stiffness = (0..n * n).map(|i| if i % n <= i / n { dot(&columns[i / n], &columns[i % n]) } else { 0.0 });
    let stiffness = Cholesky::new(stiffness.collect(), n);
    let mut w: Vec<f64> = free.iter().map(|node| sheet.points.measure[*node]).collect();
    stiffness.solve(&mut w);
    let tip: Vec<f64> = free.iter().zip(&w).filter(|(node, _)| sheet.rest[**node][0] == 1.0).map(|(_, w)| *w).collect();
    tip.iter().sum::<f64>() / tip.len() as f64 * 8.0 * D
}

#[test]
fn coupled_hinges_converge_at_second_order_on_every_mesh() {
    for pattern in PATTERNS {
        let errors = [8, 16, 32].map(|cells| cantilever_ratio(pattern, cells) - 1.0);
        let order = (errors[1] / errors[2]).abs().log2();
        println!("{pattern:?}: errors {errors:.5?}, order {order:.2}");
        assert!(errors[2].abs() < 5e-3, "{pattern:?}: {errors:?}");
        assert!((order - 2.0).abs() < 0.3, "{pattern:?}: {errors:?} {order}");
    }
}

#[test]
fn degenerate_hinges_have_finite_forces() {
    let sheet = kit::sheet([2, 2], 0.01);
    for bending in [0.0, 1.0] {
        let material = cloth(bending);
        for scale in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e-12, 1e-12, 1.0], [1e9, 1.0, 1.0]] {
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            for (n, x) in body.x.iter_mut().enumerate() {
                *x = [scale[0] * x[0], scale[1] * x[1], scale[2] * 0.01 * (n as f64).sin()];
            }
            let strains = if bending == 0.0 { body.strains(&material).unwrap().values } else { Vec::new() };
            let force = body.forces(&material).unwrap();
            let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 1.0 }).unwrap();
            let all_finite = strains.iter().chain(force.iter().flatten()).chain(&k).all(|v| v.is_finite());
            assert!(all_finite, "{bending}: {scale:?}");
        }
    }
}

#[test]
fn hinges_with_coincident_nodes_are_refused_by_number() {
    let sheet = kit::sheet([1, 1], 0.01);
    let mut rest = sheet.rest.clone();
    rest[3] = rest[0];
    let opened = Body::new(&cloth(1.0), rest, |r| sheet.elements(r.kind));
    let fault = opened.map(drop).unwrap_err();
    assert!(fault.reason.starts_with("hinge 0 "), "{fault}");
}
