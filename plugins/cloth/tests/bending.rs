//! Bending on four patterns of mesh: the energy of a cylinder, and a plate that sags.

mod strip;

use pliant_cloth::Cloth;
use pliant_plugin_api::kit::{self, Body, Sheet};
use pliant_plugin_api::param::{Params, Table, Value, defaults, position};
use pliant_plugin_api::{Material, TangentScale};
use strip::{PATTERNS, Pattern, strip};

/// N m
const D: f64 = 15e-6;

fn cloth(bending: f64) -> Cloth {
    kit::material(&[("bending", bending), ("bending-warp", D)]).unwrap()
}

/// A symmetric positive definite matrix, factored: lower triangle of `L L^T` (Cholesky 1910).
struct Factor {
    n: usize,
    l: Vec<f64>,
}

impl Factor {
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

    /// `L^-1 b`
    fn forward(&self, b: &mut [f64]) {
        for i in 0..self.n {
            let row = &self.l[i * self.n..i * self.n + i];
            b[i] = (b[i] - row.iter().zip(&b[..i]).map(|(p, q)| p * q).sum::<f64>()) / self.l[i * self.n + i];
        }
    }

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

/// The compliance between coupled hinges, m/N.
fn compliance(body: &Body, material: &Cloth) -> Factor {
    let compliances = body.compliances(material).unwrap();
    let hinges = body.strains(material).unwrap().corners;
    let n = hinges.len();
    let places: std::collections::BTreeMap<[u32; 2], usize> =
        hinges.iter().zip(0..).map(|(h, e)| ([h[0].min(h[1]), h[0].max(h[1])], e)).collect();
    let mut sum = vec![0.0; n * n];
    for (e, t) in compliances.corners.iter().enumerate() {
        let side = |s: usize| places.get(&[t[s].min(t[(s + 1) % 3]), t[s].max(t[(s + 1) % 3])]);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let plane = [[0, 1, 2], [1, 3, 4], [2, 4, 5]][i][j];
            if let (Some(p), Some(q)) = (side(i), side(j)) {
                sum[p * n + q] += compliances.plane(plane)[e];
            }
        }
    }
    Factor::new(sum, n)
}

/// J, `s . m / 2`
fn coupled_energy(body: &Body, material: &Cloth) -> f64 {
    let mut s = body.strains(material).unwrap().plane(0).to_vec();
    compliance(body, material).forward(&mut s);
    0.5 * s.iter().map(|v| v * v).sum::<f64>()
}

/// Hinges along the edges of the ends where `held`: on a node mirrored through the edge, which carries no triangle.
fn hold(sheet: &mut Sheet, held: impl Fn(f64) -> bool) {
    let triangles: Vec<[u32; 3]> = sheet.triangles.nodes.as_chunks::<3>().0.to_vec();
    for [a, b, c] in triangles {
        for [a, b, o] in [[a, b, c], [b, c, a], [c, a, b]] {
            let [p, q, r] = [a, b, o].map(|n| sheet.rest[n as usize]);
            if p[0] == q[0] && held(p[0]) {
                sheet.hinges.nodes.extend([a, b, o, sheet.rest.len() as u32]);
                sheet.rest.push([2.0 * p[0] - r[0], r[1], 0.0]);
            }
        }
    }
}

/// The area of a strip, m^2.
fn area(sheet: &Sheet) -> f64 {
    sheet.points.measure.iter().sum()
}

#[test]
fn coupled_cylinder_has_the_energy_of_a_plate() {
    let (material, radius) = (cloth(0.0), 1.5);
    for pattern in PATTERNS {
        let mut sheet = strip(pattern, 12);
        let real = sheet.rest.len();
        hold(&mut sheet, |x| x == 0.0 || x == 1.0);
        let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
        for (n, x) in body.x.iter_mut().enumerate() {
            // Nodes that hold an end lie in the tangent there.
            let at = if n < real { x[0] } else { x[0].clamp(0.0, 1.0) };
            let (s, c) = (at / radius).sin_cos();
            *x = [radius * s + (x[0] - at) * c, x[1], radius * (1.0 - c) + (x[0] - at) * s];
        }
        let ratio = coupled_energy(&body, &material) / (0.5 * D / radius.powi(2) * area(&sheet));
        println!("{pattern:?}: energy over that of a plate {ratio:.5}");
        assert!((ratio - 1.0).abs() < 0.02, "{pattern:?}: {ratio}");
    }
}

/// A cylinder's energy in hinges alone over that of a plate, bent along axis 0 or 1, with the warp along `warp`.
fn hinged(pattern: Pattern, axis: usize, warp: [f64; 3], weft: f64) -> f64 {
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
    // Free ends are short of half a row of cells each.
    let long = sheet.rest.iter().fold(0.0, |m: f64, x| m.max(x[axis]));
    let row = if axis == 1 && pattern == Pattern::Equilateral { 0.75_f64.sqrt() } else { 1.0 } / cells as f64;
    energy / (0.5 * D / radius.powi(2) * area(&sheet) * (1.0 - row / long))
}

#[test]
fn hinges_alone_have_it_on_good_meshes_only() {
    for pattern in [Pattern::Regular, Pattern::Alternating, Pattern::Equilateral] {
        for axis in [0, 1] {
            let ratio = hinged(pattern, axis, [1.0, 0.0, 0.0], D);
            println!("{pattern:?} along {axis}: {ratio:.5}");
            assert!((ratio - 1.0).abs() < 0.05, "{pattern:?} {axis}: {ratio}");
        }
    }
    let ratio = hinged(Pattern::Irregular, 0, [1.0, 0.0, 0.0], D);
    assert!((ratio - 1.0).abs() > 0.02, "an irregular mesh is what coupled hinges are for: {ratio}");
}

#[test]
fn hinges_know_warp_from_weft() {
    for (axis, warp, rigidity) in [(0, [2.0, 0.0, 0.5], 1.0), (1, [1.0, 0.0, 0.0], 3.0), (0, [0.0, 1.0, 0.0], 3.0)] {
        let ratio = hinged(Pattern::Alternating, axis, warp, 3.0 * D) / rigidity;
        assert!((ratio - 1.0).abs() < 0.05, "{axis} {warp:?}: {ratio}");
    }
}

#[test]
fn warp_weft_and_curved_rest_states() {
    let radius = 1.5;
    let material: Cloth = kit::material(&[("bending-warp", D), ("bending-weft", 3.0 * D)]).unwrap();
    let mut sheet = strip(Pattern::Irregular, 12);
    let real = sheet.rest.len();
    hold(&mut sheet, |x| x == 0.0 || x == 1.0);
    let bend = |n: usize, x: [f64; 3]| {
        let at = if n < real { x[0] } else { x[0].clamp(0.0, 1.0) };
        let (s, c) = (at / radius).sin_cos();
        [radius * s + (x[0] - at) * c, x[1], radius * (1.0 - c) + (x[0] - at) * s]
    };
    let bent: Vec<[f64; 3]> = sheet.rest.iter().enumerate().map(|(n, x)| bend(n, *x)).collect();
    let plate = 0.5 * D / radius.powi(2) * area(&sheet);
    // The warp across the strip: it bends along the weft.
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

/// Deflection of a clamped strip's tip over that of a plate, `q L^4 / (8 D)`, to first order.
fn cantilever(pattern: Pattern, cells: usize) -> f64 {
    let material = cloth(0.0);
    let mut sheet = strip(pattern, cells);
    let real = sheet.rest.len();
    hold(&mut sheet, |x| x == 0.0);
    let body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let factor = compliance(&body, &material);
    let strains = body.strains(&material).unwrap();
    let free: Vec<usize> = (0..real).filter(|n| sheet.rest[*n][0] > 0.0).collect();
    // Columns L^-1 ds/dz: their products are the stiffness.
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
    let stiffness = Factor::new(stiffness.collect(), n);
    let mut w: Vec<f64> = free.iter().map(|node| sheet.points.measure[*node]).collect();
    stiffness.solve(&mut w);
    let tip: Vec<f64> = free.iter().zip(&w).filter(|(node, _)| sheet.rest[**node][0] == 1.0).map(|(_, w)| *w).collect();
    tip.iter().sum::<f64>() / tip.len() as f64 * 8.0 * D
}

#[test]
fn coupled_cantilever_converges_at_second_order_on_every_mesh() {
    for pattern in PATTERNS {
        let errors = [8, 16, 32].map(|cells| cantilever(pattern, cells) - 1.0);
        let order = (errors[1] / errors[2]).abs().log2();
        println!("{pattern:?}: errors {errors:.5?}, order {order:.2}");
        assert!(errors[2].abs() < 5e-3, "{pattern:?}: {errors:?}");
        assert!((order - 2.0).abs() < 0.3, "{pattern:?}: {errors:?} {order}");
    }
}

#[test]
fn collapsed_folds_stay_finite() {
    let sheet = kit::sheet([2, 2], 0.01);
    for bending in [0.0, 1.0] {
        let material = cloth(bending);
        for squash in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e-12, 1e-12, 1.0], [1e9, 1.0, 1.0]] {
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            for (n, x) in body.x.iter_mut().enumerate() {
                *x = [squash[0] * x[0], squash[1] * x[1], squash[2] * 0.01 * (n as f64).sin()];
            }
            let strains = if bending == 0.0 { body.strains(&material).unwrap().values } else { Vec::new() };
            let force = body.forces(&material).unwrap();
            let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 1.0 }).unwrap();
            let finite = strains.iter().chain(force.iter().flatten()).chain(&k).all(|v| v.is_finite());
            assert!(finite, "{bending}: {squash:?}");
        }
    }
}

#[test]
fn hinges_without_a_side_are_refused_by_number() {
    let sheet = kit::sheet([1, 1], 0.01);
    let mut rest = sheet.rest.clone();
    rest[3] = rest[0];
    let found = Body::new(&cloth(1.0), rest, |r| sheet.elements(r.kind));
    let fault = found.map(drop).unwrap_err();
    assert!(fault.reason.starts_with("hinge 0 "), "{fault}");
}
