//! The rows of an experiment as a table for people.

use super::{Outcome, Row, digits};
use std::fmt::Write;

/// Characters of a line of a note, at most.
const WIDTH: usize = 100;

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
        let _ = writeln!(out, "{}", wrapped("  note: ", note));
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
    let ratio = row.ratio().map_or(String::new(), digits);
    let measured = row.remark.clone().unwrap_or_else(|| with_unit(digits(row.measured)));
    [row.case.clone(), row.quantity.clone(), paper, target, measured, ratio, met.into()]
}

/// A text in lines, the first of which begins so, and the others as far to the right.
fn wrapped(begin: &str, text: &str) -> String {
    let mut out = begin.to_owned();
    let indent = begin.chars().count();
    let mut used = indent;
    for (number, word) in text.split(' ').enumerate() {
        let length = word.chars().count();
        if number > 0 && used + 1 + length > WIDTH {
            let _ = write!(out, "\n{:indent$}", "");
            used = indent;
        } else if number > 0 {
            out.push(' ');
            used += 1;
        }
        out.push_str(word);
        used += length;
    }
    out
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
        assert!(lines[2].ends_with("4 m/s  1 m/s     0.25") && lines[3].ends_with("3"), "{text}");
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
        assert!(lines[2].contains("0.9 to 1.1 rp  1.25 rp ") && lines[2].ends_with("  NOT met"), "{text}");
        assert!(lines[3].contains("1.200e-4 m/s") && lines[3].ends_with(" met"), "{text}");
        assert!(lines[4].ends_with("12,345"), "{text}");
        assert!(lines[5].ends_with("NOT met"), "{text}");
        assert!(lines[6].contains("as is"));
        assert_eq!(outcome.unmet().count(), 2);
        assert_eq!(outcome.measured("b", "count"), Some(12345.0));
    }

    #[test]
    fn columns_are_aligned_and_lines_are_short() {
        let rows = vec![
            Row::new("", "dense", "MiB", 34.9).paper(35.7),
            Row::missing("", "sparse, in words that are longer", "MiB", "needs a mesh").paper(6.4),
        ];
        let notes = vec!["a word ".repeat(40).trim_end().to_owned()];
        let text = to_text("dragon", &Outcome { rows, notes, ..Outcome::default() });
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1].find("measured"), lines[2].find("34.9"));
        assert_eq!(lines[1].find("measured"), lines[3].find("needs"));
        assert!(lines[2].ends_with("0.9776") && lines[3].ends_with("a mesh"), "{text}");
        assert!(lines[4].starts_with("  note: a word") && lines[5].starts_with("        "), "{text}");
        assert!(lines[4..].len() > 2 && lines[4..].iter().all(|line| line.len() <= WIDTH), "{text}");
    }
}
