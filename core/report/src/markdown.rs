//! A report as Markdown, for documents.

use crate::document::Document;
use std::fmt::Write;

/// The report as Markdown, without its pictures.
pub fn markdown(document: &Document) -> String {
    let (v, m) = (&document.verdict, &document.machine);
    let load = m.load.map_or_else(|| "unknown".into(), |l| format!("{l:.2}"));
    let mut out = format!("## {}\n\n", document.report.name());
    let _ = writeln!(out, "`pliant {}`, {}, {}, load {load}.", document.settings.join(" "), document.program, m.cpu);
    let _ = writeln!(out, "{} of {} judged results meet their criterion.", v.passed, v.judged);
    if !v.failed.is_empty() {
        out.push_str("Failed:\n\n");
        v.failed.iter().for_each(|m| {
            let _ = writeln!(out, "- {m}");
        });
    }
    for section in document.sections.iter().filter(|s| !s.tables.is_empty()) {
        let _ = write!(out, "\n### {}\n", section.title);
        section.text.iter().for_each(|p| {
            let _ = write!(out, "\n{p}\n");
        });
        for table in &section.tables {
            let cells = |cells: &[String]| cells.iter().map(|c| c.replace('|', "\\|")).collect::<Vec<_>>().join(" | ");
            let _ = writeln!(out, "\n{}\n\n| {} |", table.caption, cells(&table.head));
            let _ = writeln!(out, "|{}", "---|".repeat(table.head.len()));
            for row in &table.rows {
                let _ = writeln!(out, "| {}{} |", cells(&row.cells), if row.failed { " (failed)" } else { "" });
            }
        }
    }
    out
}
