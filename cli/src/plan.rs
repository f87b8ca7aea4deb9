//! `pliant plan`.

use crate::args::{Cli, PlanArgs};
use crate::call_watchdog::CallWatchdog;
use crate::outcome::{Failure, Outcome};
use crate::output::{format_seconds, print, print_json};
use crate::scene_session::{OpenedScene, open_scene};
use crate::stop::end_on_stop;
use pliant_engine::memory::format_bytes;
use pliant_engine::session::{Choices, EditCost, ObstacleSummary, Session};
use pliant_record::PlanReport;
use std::time::Instant;

/// Opens a scene and says what a run will do.
pub fn plan(cli: &Cli, args: &PlanArgs) -> Result<Outcome, Failure> {
    end_on_stop();
    let _watchdog = CallWatchdog::start(args.call_limit, "nothing was written");
    let began = Instant::now();
    let OpenedScene { scene, session, .. } = open_scene(cli, &args.scene)?;
    let report = PlanReport::new(&session, scene.time.steps(), began.elapsed());
    if cli.json {
        print_json(&report)?;
    } else {
        print(&plan_text(&report, &session))?;
    }
    Ok(Outcome::Done)
}

/// The plan as people read it.
fn plan_text(report: &PlanReport, session: &Session) -> String {
    let choices = &report.choices;
    let mut lines = vec![format!("{} steps of {}", report.steps, format_seconds(report.dt))];
    for body in &report.bodies {
        let (name, vertices, triangles, edge) = (&body.name, body.vertices, body.triangles, body.edge * 1e3);
        let discretization = match (body.level, body.cells, body.tetrahedra) {
            (Some(level), Some(cells), _) => format!("level {level} with {cells} cells of {edge:.3} mm"),
            (_, _, Some(count)) if body.nodes_of_tetrahedron == Some(10) => {
                format!("{count} quadratic tetrahedra of 10 nodes, which are {edge:.3} mm apart")
            }
            (_, _, Some(count)) => format!("{count} tetrahedra with edges of {edge:.3} mm"),
            _ => format!("its own mesh, edges of {edge:.3} mm"),
        };
        let border = match body.border_edges {
            0 => String::new(),
            edges => format!(", open: {edges} border edges"),
        };
        lines.push(format!("body `{name}`: {vertices} vertices, {triangles} triangles, {discretization}{border}"));
        if body.welded_vertices > 0 {
            lines.push(format!("  {} vertices of borders welded to others at their places", body.welded_vertices));
        }
        let divided = choices.subdivisions.iter().filter(|s| s.body == *name);
        lines.extend(divided.map(|s| format!("  faces divided {} times: {}", s.level, s.why)));
        lines.extend(
            choices.levels.iter().filter(|l| l.body == *name).map(|l| format!("  level {}: {}", l.level, l.why)),
        );
    }
    lines.extend(report.obstacles.iter().map(obstacle_text));
    for contact in &choices.contacts {
        let Some(law) = &contact.law else { continue };
        lines.push(format!(
            "contact of tool `{}` with body `{}`: law `{law}`: {}",
            contact.tool, contact.body, contact.why
        ));
    }
    lines.push(format!("integrator: {} ({})", choices.integrator, choices.why));
    lines.push(format!("step limit: {}", step_limit_text(choices, report.dt)));
    for cost in &report.step_cost {
        lines.push(format!(
            "a step of body `{}` under a tool: about {} for {} nodes and {} elements",
            cost.body,
            format_seconds(cost.seconds),
            cost.nodes,
            cost.elements
        ));
    }
    lines.extend(report.edit_cost.iter().map(edit_text));
    lines.push(format!("threads: {}; memory: at most about {}", choices.threads, format_bytes(report.memory)));
    lines.push("opened:".into());
    for l in &report.loaded {
        lines.push(format!("  {} `{}` {} from {}", l.kind, l.id, l.version, l.path));
    }
    lines.push("left out:".into());
    for l in &report.left_out {
        lines.push(format!("  {}: {}", l.what, l.why));
    }
    let described = session.events.described();
    if !described.is_empty() {
        lines.push("noted:".into());
        lines.extend(described.iter().map(|(_, e)| format!("  {}", e.text)));
    }
    lines.join("\n")
}

/// An edit and what a step of it costs.
fn edit_text(cost: &EditCost) -> String {
    let EditCost { edit, tool, body, radius, nodes, elements, seconds, changes_every } = cost;
    let region = radius.map_or_else(|| "the whole".to_owned(), |radius| format!("within {:.1} mm", 1e3 * radius));
    let anew = changes_every.map_or_else(String::new, |every| {
        format!(
            "; where it changes the body, at most every {}, the rest data of these elements are made anew",
            format_seconds(every)
        )
    });
    format!(
        "a step of `{edit}` with tool `{tool}` on body `{body}`: about {} for {nodes} nodes and {elements} elements ({region}){anew}",
        format_seconds(*seconds)
    )
}

/// An obstacle and what it costs.
fn obstacle_text(obstacle: &ObstacleSummary) -> String {
    let ObstacleSummary { name, surface, triangles, moves, distance_seconds } = obstacle;
    let of = if *triangles > 0 { format!(" of {triangles} triangles") } else { String::new() };
    let moves = if *moves { ", moves" } else { "" };
    let cost = 1e9 * distance_seconds;
    format!(
        "obstacle `{name}`: {surface}{of}{moves}; a distance to it takes about {cost:.0} ns, and a point near it asks for a few in each step"
    )
}

/// The step limit and how the step keeps to it.
fn step_limit_text(choices: &Choices, dt: f64) -> String {
    let (Some(limit), Some(certain)) = (choices.step_limit, choices.certain_step_limit) else {
        return "none".into();
    };
    let substeps = match choices.substeps {
        1 => "no substeps are needed".to_owned(),
        more => format!("{more} substeps of {} each", format_seconds(dt / more as f64)),
    };
    format!("{} predicted, {} guaranteed; {substeps}", format_seconds(limit), format_seconds(certain))
}
