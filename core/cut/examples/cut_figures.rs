//! Cuts models and prints what it costs: `cargo run --release -p pliant-core --example cut_figures -- MODEL.obj... [--out DIR]`.
#![allow(clippy::print_stdout, reason = "an example speaks")]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use pliant_cut::{Blade, CutMesh, MATERIAL, Refused, Stroke};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{ObjDocument, Placement, Surface};

const STEPS: u32 = 60;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut models = Vec::new();
    let mut out = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--out" {
            out = arguments.next().map(PathBuf::from);
        } else {
            models.push(argument);
        }
    }
    for model in models {
        cut(Path::new(&model), out.as_deref())?;
    }
    Ok(())
}

/// Three cuts across the model: right through, halfway, and a slanting one that crosses both.
fn cut(model: &Path, out: Option<&Path>) -> Result<(), Box<dyn std::error::Error>> {
    let document = ObjDocument::read(model)?;
    let bounds = Surface::from_document(&document).bounds();
    let placement = Placement::fit(&bounds, 0.1)?;
    let start = Instant::now();
    let mut mesh = CutMesh::new(&document, &placement);
    let new = start.elapsed();
    println!(
        "{}: {} triangles, new {:.1} ms",
        model.display(),
        mesh.surface().triangles.len(),
        1e3 * new.as_secs_f64()
    );
    let ways = [
        ("through", [[-0.08, 0.011, -0.08], [-0.08, 0.011, 0.08]], [0.16, 0.003, 0.0]),
        ("halfway", [[0.004, 0.002, -0.07], [0.004, 0.07, -0.07]], [0.003, 0.0, 0.14]),
        ("slanting", [[-0.08, -0.03, -0.06], [-0.06, -0.03, 0.07]], [0.13, 0.06, 0.01]),
    ];
    for (name, [tip, heel], way) in ways {
        let at = |t: f64| {
            let shift = |x: [f64; 3]| Vec3::from(x) + t * Vec3::from(way);
            Blade { tip: shift(tip), heel: shift(heel) }
        };
        let mut stroke = Stroke::begin(at(0.0))?;
        let (mut seconds, mut refused, mut area, mut changed): (Vec<f64>, Vec<Refused>, f64, usize) =
            Default::default();
        for step in 1..=STEPS {
            let start = Instant::now();
            match mesh.advance(&mut stroke, at(f64::from(step) / f64::from(STEPS))) {
                Ok(advance) => {
                    area += advance.area;
                    changed += advance.changed.len();
                }
                Err(reason) => refused.push(reason),
            }
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        let [middle, most] = [seconds[seconds.len() / 2], seconds[seconds.len() - 1]].map(|s| 1e3 * s);
        let parts = mesh.parts();
        let large = parts.all.iter().filter(|part| part.triangles > 20).count();
        println!(
            "  {name}: {middle:.3} ms median, {most:.3} ms most; area {area:.3e} m2, {changed} triangles changed; \
             {} parts ({large} over 20 triangles); {} refused {refused:?}",
            parts.all.len(),
            refused.len(),
        );
    }
    if let Some(folder) = out {
        let name = model.file_stem().unwrap_or_default().to_string_lossy();
        let mut points = mesh.surface().points.clone();
        let mut bytes = Vec::new();
        mesh.write(&document, &points, MATERIAL, &mut bytes)?;
        fs::write(folder.join(format!("{name}-cut.obj")), bytes)?;
        // Parts pushed away from the middle, to look inside.
        let parts = mesh.parts();
        let mut centre = vec![(Vec3::zeros(), 0.0); parts.all.len()];
        for (number, triangle) in mesh.surface().triangles.iter().enumerate() {
            for vertex in triangle {
                let (sum, count) = &mut centre[parts.of[number] as usize];
                *sum += mesh.surface().points[*vertex as usize];
                *count += 1.0;
            }
        }
        for (number, triangle) in mesh.surface().triangles.iter().enumerate() {
            let (sum, count) = centre[parts.of[number] as usize];
            for &vertex in triangle {
                points[vertex as usize] = mesh.surface().points[vertex as usize] + 0.5 * sum / count;
            }
        }
        let mut bytes = Vec::new();
        mesh.write(&document, &points, MATERIAL, &mut bytes)?;
        fs::write(folder.join(format!("{name}-parts.obj")), bytes)?;
    }
    Ok(())
}
