//! A report as one HTML page that loads nothing from outside: the verdict first, then the sections.

use crate::document::Document;
use crate::section::Table;
use crate::xml::escape;
use std::fmt::Write;

/// Style sheet of the page.
const STYLE: &str = "body{font:15px/1.5 Helvetica,Arial,sans-serif;color:#222;max-width:1080px;margin:2em auto;padding:0 1.5em}\
h1{font-size:26px}h2{font-size:19px;margin-top:2.2em;border-bottom:1px solid #ccc;padding-bottom:.2em}\
table{border-collapse:collapse;font-size:13px;margin:.8em 0}th,td{padding:.22em .7em;border-bottom:1px solid #e2e2e2;\
text-align:left;vertical-align:top}th{background:#f4f4f4}td.n{text-align:right;font-variant-numeric:tabular-nums;\
white-space:nowrap}tr.failed td{background:#fbe3d9}\
caption{text-align:left;font-weight:bold;padding:.3em 0}.good{background:#e3f3ea}.bad{background:#fbe3d9}\
.verdict{padding:.8em 1.1em;border-radius:6px}svg{max-width:100%;height:auto;display:inline-block;vertical-align:top;margin:.8em 0}\
.wide{overflow-x:auto}dl{display:grid;grid-template-columns:max-content 1fr;gap:.1em 1.2em;font-size:13px}\
dt{color:#666}dd{margin:0}";

/// The page as a text.
pub(crate) fn html(document: &Document) -> String {
    let name = document.report.name();
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>pliant: {name}</title><style>{STYLE}</style>\
         </head><body><h1>pliant: {name}</h1>"
    );
    verdict(&mut out, document);
    about(&mut out, document);
    for section in &document.sections {
        let _ = write!(out, "<h2>{}</h2>", escape(&section.title));
        section.text.iter().for_each(|p| {
            let _ = write!(out, "<p>{}</p>", escape(p));
        });
        section.plots.iter().for_each(|(_, svg)| out.push_str(svg));
        section.tables.iter().for_each(|t| table(&mut out, t));
    }
    if !document.not_run.is_empty() {
        out.push_str("<h2>Cases that were not run</h2><table><tr><th>case</th><th>why</th></tr>");
        for left in &document.not_run {
            let _ = write!(out, "<tr><td>{}</td><td>{}</td></tr>", escape(&left.case), escape(&left.why));
        }
        out.push_str("</table>");
    }
    out.push_str("</body></html>\n");
    out
}

/// Adds the verdict and the failed rows.
fn verdict(out: &mut String, document: &Document) {
    let v = &document.verdict;
    let class = if v.good { "good" } else { "bad" };
    let _ = write!(
        out,
        "<div class=\"verdict {class}\"><b>{} of {} judged results meet their criterion.</b>",
        v.passed, v.judged
    );
    if document.interrupted {
        out.push_str(" The report was stopped before its end.");
    }
    if !v.failed.is_empty() {
        out.push_str(" Failed:<ul>");
        v.failed.iter().for_each(|m| {
            let _ = write!(out, "<li>{}</li>", escape(m));
        });
        out.push_str("</ul>");
    }
    out.push_str("</div>");
}

/// Adds settings and machine of the report.
fn about(out: &mut String, document: &Document) {
    let m = &document.machine;
    let plugins: Vec<&str> = document.plugins.iter().map(String::as_str).collect();
    let load = m.load.map_or_else(|| "unknown".into(), |l| format!("{l:.2} at the start, over the last minute"));
    let clock = format!(
        "{:.1} s by the report's clock, {:.1} s by the calendar; threads worked {:.0} % of their time",
        document.clock.wall_seconds,
        document.clock.calendar_seconds,
        100.0 * document.clock.cpu_share
    );
    out.push_str("<dl>");
    for (name, text) in [
        ("program", document.program.clone()),
        ("plugins", plugins.join(", ")),
        ("command", format!("pliant {}", document.settings.join(" "))),
        ("processor", format!("{}, {} to use", m.cpu, m.processors)),
        ("system", m.system.clone()),
        ("load", load),
        ("threads of a run", document.threads.to_string()),
        ("seed", document.seed.to_string()),
        ("time", clock),
    ] {
        let _ = write!(out, "<dt>{name}</dt><dd>{}</dd>", escape(&text));
    }
    out.push_str("</dl>");
}

/// Adds a table.
fn table(out: &mut String, table: &Table) {
    let _ = write!(out, "<div class=\"wide\"><table><caption>{}</caption><tr>", escape(&table.caption));
    table.head.iter().for_each(|h| {
        let _ = write!(out, "<th>{}</th>", escape(h));
    });
    out.push_str("</tr>");
    for row in &table.rows {
        out.push_str(if row.failed { "<tr class=\"failed\">" } else { "<tr>" });
        for cell in &row.cells {
            let number = cell.starts_with(|c: char| c.is_ascii_digit() || c == '-') && cell.len() < 14;
            let class = if number { " class=\"n\"" } else { "" };
            let _ = write!(out, "<td{class}>{}</td>", escape(cell));
        }
        out.push_str("</tr>");
    }
    out.push_str("</table></div>");
}
