//! `pliant plan`.

use crate::args::{Cli, SceneArgs};
use crate::open::open;
use crate::outcome::{Failure, Outcome};
use crate::text;
use pliant_engine::session::Session;
use serde::Serialize;
use std::time::Instant;

/// What will happen, without its happening.
#[derive(Serialize)]
struct Report<'a> {
    steps: u64,
    dt: f64,
    choices: &'a pliant_engine::session::Choices,
    loaded: &'a [pliant_engine::session::Loaded],
    left_out: &'a [pliant_engine::plan::LeftOut],
    bodies: Vec<pliant_record::BodySummary>,
    /// Bytes of the largest parts, before a tool touches anything.
    memory: usize,
    open_seconds: f64,
    step_cost: Vec<pliant_engine::session::StepCost>,
}

pub fn plan(cli: &Cli, args: &SceneArgs) -> Result<Outcome, Failure> {
    let began = Instant::now();
    let (scene, _, session) = open(cli, args)?;
    let report = Report {
        steps: scene.time.steps(),
        dt: session.dt(),
        choices: &session.choices,
        loaded: &session.loaded,
        left_out: &session.left_out,
        bodies: pliant_record::summarize_bodies(&session),
        memory: session.bytes(),
        open_seconds: began.elapsed().as_secs_f64(),
        step_cost: session.step_costs().to_vec(),
    };
    if cli.json {
        return text::out(&crate::pretty(&report));
    }
    text::out(&tell(&report, &session))
}

fn tell(report: &Report<'_>, session: &Session) -> String {
    let c = report.choices;
    let mut lines = vec![format!("{} steps of {}", report.steps, text::seconds(report.dt))];
    for body in &report.bodies {
        let (name, vertices, triangles, edge) = (&body.name, body.vertices, body.triangles, body.edge * 1e3);
        let carrier = match (body.level, body.cells) {
            (Some(level), Some(cells)) => format!("level {level} with {cells} cells of {edge:.3} mm"),
            _ => format!("its own mesh, edges of {edge:.3} mm"),
        };
        lines.push(format!("body `{name}`: {vertices} vertices, {triangles} triangles, {carrier}"));
    }
    lines.push(format!("integrator: {} ({})", c.integrator, c.why));
    lines.push(match (c.step_limit, c.certain_step_limit) {
        (Some(limit), Some(certain)) => format!(
            "step limit: {} predicted, {} for certain; {} substeps of {}",
            text::seconds(limit),
            text::seconds(certain),
            c.substeps,
            text::seconds(report.dt / c.substeps as f64)
        ),
        _ => "step limit: none".into(),
    });
    for cost in &report.step_cost {
        lines.push(format!(
            "a step of body `{}` under a tool: about {} for {} nodes and {} elements",
            cost.body,
            text::seconds(cost.seconds),
            cost.nodes,
            cost.elements
        ));
    }
    lines.push(format!("threads: {}; memory: {}", c.threads, text::bytes(report.memory as u64)));
    lines.push("opened:".into());
    for l in report.loaded {
        lines.push(format!("  {} `{}` {} from {}", l.kind, l.id, l.version, l.path));
    }
    lines.push("left out:".into());
    for l in report.left_out {
        lines.push(format!("  {}: {}", l.what, l.why));
    }
    let told = session.events.told();
    if !told.is_empty() {
        lines.push("noted:".into());
        lines.extend(told.iter().map(|(_, e)| format!("  {}", e.text)));
    }
    lines.join("\n")
}
