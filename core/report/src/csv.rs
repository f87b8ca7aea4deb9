//! The rows of a report as CSV, for programs.

use crate::row::Row;
use std::fmt::Write;

/// All rows, a line each, under a line of names. Parameters and results that any row has are columns of their own.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut names: Vec<&String> = rows.iter().flat_map(|r| r.parameters.keys().chain(r.results.keys())).collect();
    names.sort();
    names.dedup();
    let mut out = String::from(
        "case,method,n,dt,threads,error,tolerance,order,expected_order,passed,wall_seconds,cpu_seconds,open_seconds,\
         step_seconds_median,step_seconds_p99,spread,bytes,iterations,front,state",
    );
    names.iter().for_each(|name| {
        let _ = write!(out, ",{}", quoted(name));
    });
    out.push_str(",reference,note\n");
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
        let _ = write!(out, ",{},{},{},{}", r.bytes, r.iterations, r.on_front, r.state);
        for name in &names {
            let _ = write!(out, ",{}", number(r.parameters.get(*name).or(r.results.get(*name)).copied()));
        }
        let _ = writeln!(out, ",{},{}", quoted(&r.reference), quoted(&r.note));
    }
    out
}

/// A cell, in quotes where it has a comma, a quote or a line break.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_quotes_what_needs_it_and_has_as_many_cells_in_every_line() {
        let mut rows = vec![Row { case: "a, \"b\"".into(), ..Row::default() }, Row::default()];
        rows[1].results.insert("ratio".into(), 0.5);
        let text = csv(&rows);
        assert!(text.contains("\"a, \"\"b\"\"\""), "{text}");
        let commas = |line: &str| line.matches(',').count();
        let lines: Vec<&str> = text.lines().collect();
        assert!(commas(lines[0]) == commas(lines[2]) && commas(lines[1]) == commas(lines[0]) + 1, "{text}");
        assert!(lines[0].ends_with("ratio,reference,note") && lines[2].ends_with("5e-1,,"));
    }
}
