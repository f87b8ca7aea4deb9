//! Reports as tables: CSV for programs, Markdown for documents.

use super::{Document, Row};
use std::fmt::Write;

/// All rows, a line each, under one line of names.
pub fn csv(rows: &[Row]) -> String {
    let mut names: Vec<&String> = rows.iter().flat_map(|r| r.at.keys().chain(r.found.keys())).collect();
    names.sort();
    names.dedup();
    let mut out = String::from(
        "case,method,n,dt,threads,error,tolerance,order,expected_order,passed,wall_seconds,cpu_seconds,open_seconds,\
         step_seconds_median,step_seconds_p99,spread,bytes,iterations,front,state",
    );
    names.iter().for_each(|name| {
        let _ = write!(out, ",{}", quoted(name));
    });
    out.push_str(",note\n");
    for r in rows {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:e}"));
        let _ = write!(out, "{},{},{},{:e},{}", quoted(&r.case), quoted(&r.method), r.n, r.dt, r.threads);
        for value in [r.error, r.tolerance, r.order, r.expected_order] {
            let _ = write!(out, ",{}", number(value));
        }
        let _ = write!(out, ",{}", r.passed.map_or(String::new(), |p| p.to_string()));
        let _ = write!(out, ",{:e},{:e},{:e}", r.wall_seconds, r.cpu_seconds, r.open_seconds);
        for value in [r.step_seconds_median, r.step_seconds_p99, r.spread] {
            let _ = write!(out, ",{}", number(value));
        }
        let _ = write!(out, ",{},{},{},{}", r.bytes, r.iterations, r.front, r.state);
        for name in &names {
            let _ = write!(out, ",{}", number(r.at.get(*name).or(r.found.get(*name)).copied()));
        }
        let _ = writeln!(out, ",{}", quoted(&r.note));
    }
    out
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The report without its pictures.
pub fn markdown(document: &Document) -> String {
    let (v, m) = (&document.verdict, &document.machine);
    let load = m.load.map_or_else(|| "unknown".into(), |l| format!("{l:.2}"));
    let mut out = format!("## {}\n\n", document.report.name());
    let _ = writeln!(out, "`pliant {}`, {}, {}, load {load}.", document.settings.join(" "), document.program, m.cpu);
    let _ = writeln!(out, "{} of {} judged results are within what they must meet.", v.passed, v.judged);
    if !v.missed.is_empty() {
        out.push_str("Missed:\n\n");
        v.missed.iter().for_each(|m| {
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
            for (row, missed) in &table.rows {
                let _ = writeln!(out, "| {}{} |", cells(row), if *missed { " (missed)" } else { "" });
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_quotes_what_needs_it_and_has_as_many_cells_in_every_line() {
        let mut rows = vec![Row { case: "a, \"b\"".into(), ..Row::default() }, Row::default()];
        rows[1].found.insert("ratio".into(), 0.5);
        let text = csv(&rows);
        assert!(text.contains("\"a, \"\"b\"\"\""), "{text}");
        let commas = |line: &str| line.matches(',').count();
        let lines: Vec<&str> = text.lines().collect();
        assert!(commas(lines[0]) == commas(lines[2]) && commas(lines[1]) == commas(lines[0]) + 1, "{text}");
        assert!(lines[0].ends_with("ratio,note") && lines[2].ends_with("5e-1,"));
    }
}
