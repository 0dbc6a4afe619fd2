//! Outcomes as a table for people.

use super::{Outcome, Row};
use std::fmt::Write;

/// The rows of an outcome as a table, then its notes.
pub fn to_text(name: &str, outcome: &Outcome) -> String {
    let mut lines = vec![["case", "quantity", "paper", "target", "measured", "ratio", ""].map(String::from)];
    lines.extend(outcome.rows.iter().map(cells));
    // Columns in which there is nothing but a title are left out.
    let shown: Vec<usize> =
        (0..7).filter(|&column| lines[1..].iter().any(|line| !line[column].is_empty())).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = shown.iter().map(|&column| width(column)).collect();
    let mut out = format!("{name}\n");
    for line in &lines {
        let padded = shown.iter().zip(&widths).map(|(&column, &width)| format!("  {:width$}", line[column]));
        let _ = writeln!(out, "{}", padded.collect::<String>().trim_end());
    }
    for note in &outcome.notes {
        let _ = writeln!(out, "  note: {note}");
    }
    out
}

fn cells(row: &Row) -> [String; 7] {
    let met = match row.met {
        Some(true) => "met",
        Some(false) => "NOT met",
        None => "",
    };
    let with_unit = |text: String| if row.unit.is_empty() { text } else { format!("{text} {}", row.unit) };
    let target = if row.target.is_empty() { String::new() } else { with_unit(row.target.clone()) };
    let paper = row.paper.map_or(String::new(), |paper| with_unit(digits(paper)));
    let ratio = row.paper.map_or(String::new(), |paper| digits(row.measured / paper));
    let measured = with_unit(digits(row.measured));
    [row.case.clone(), row.quantity.clone(), paper, target, measured, ratio, met.into()]
}

/// Four digits, or all of a whole number.
pub fn digits(value: f64) -> String {
    let size = value.abs();
    match value {
        _ if size >= 1e7 || (size < 1e-3 && size > 0.0) => format!("{value:.2e}"),
        _ if size >= 1000.0 || value.fract() == 0.0 => format!("{value:.0}"),
        _ if size >= 100.0 => format!("{value:.1}"),
        _ if size >= 10.0 => format!("{value:.2}"),
        _ if size >= 0.1 => format!("{value:.3}"),
        _ => format!("{value:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn papers_stand_beside_what_is_measured() {
        let rows = vec![Row::new("a", "speed", "m/s", 1.0).paper(4.0), Row::new("a", "steps", "", 3.0)];
        let text = to_text("fig", &Outcome { rows, ..Outcome::default() });
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[1].ends_with("quantity  paper  measured  ratio"), "{text}");
        assert!(lines[2].ends_with("4 m/s  1 m/s     0.250") && lines[3].ends_with("3"), "{text}");
    }

    #[test]
    fn rows_say_what_is_met() {
        let rows = vec![
            Row::new("a", "distance", "rp", 1.25).between(0.9, 1.1),
            Row::new("a", "speed", "m/s", 0.000_12).at_most(0.01),
            Row::new("b", "count", "", 12345.0),
            Row::new("b", "lost", "", f64::NAN).at_most(1.0),
        ];
        let outcome = Outcome { rows, notes: vec!["as is".into()], ..Outcome::default() };
        let text = to_text("rest", &outcome);
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            lines[2].contains("0.900 to 1.100 rp  1.250 rp ") && lines[2].ends_with("  NOT met"),
            "{text}"
        );
        assert!(lines[3].contains("1.20e-4 m/s") && lines[3].ends_with(" met"), "{text}");
        assert!(lines[4].ends_with("12345"), "{text}");
        assert!(lines[5].ends_with("NOT met"), "{text}");
        assert!(lines[6].contains("as is"));
        assert_eq!(outcome.unmet().count(), 2);
        assert_eq!(outcome.measured("b", "count"), Some(12345.0));
    }
}
