//! Outcomes as a table for people.

use super::{Outcome, Row};
use std::fmt::Write;

/// All rows in one table, then what was assumed.
pub fn to_text(outcomes: &[Outcome]) -> String {
    let mut lines = vec![["experiment", "quantity", "paper", "ours", "ours / paper"].map(String::from)];
    for outcome in outcomes {
        lines.extend(outcome.rows.iter().map(|row| cells(outcome.experiment.name(), row)));
    }
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths = [0, 1, 2, 3].map(width);
    let mut out = String::new();
    for line in &lines {
        let [experiment, quantity, paper, ours, ratio] = line;
        let [a, b, c, d] = widths;
        let text = format!("{experiment:a$}  {quantity:b$}  {paper:c$}  {ours:d$}  {ratio}");
        let _ = writeln!(out, "{}", text.trim_end());
    }
    for outcome in outcomes {
        let _ = writeln!(out, "\n{}: {}; {:.1} s", outcome.experiment.name(), outcome.title, outcome.seconds);
        outcome.assumed.iter().for_each(|line| {
            let _ = writeln!(out, "{}", wrapped(line));
        });
    }
    out
}

fn cells(experiment: &str, row: &Row) -> [String; 5] {
    let figure = |value: Option<f64>| value.map(|value| format!("{} {}", digits(value), row.unit));
    let ours = figure(row.ours).or_else(|| row.remark.clone()).unwrap_or_default();
    [
        experiment.to_owned(),
        row.quantity.clone(),
        figure(row.paper).unwrap_or_default(),
        ours,
        row.ratio.map(digits).unwrap_or_default(),
    ]
}

/// Three digits, or all of a whole number.
fn digits(value: f64) -> String {
    let size = value.abs();
    match value {
        _ if size >= 1e6 || (size < 1e-3 && size > 0.0) => format!("{value:.2e}"),
        _ if size >= 100.0 || value.fract() == 0.0 => format!("{value:.0}"),
        _ if size >= 10.0 => format!("{value:.1}"),
        _ if size >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// An item of a list, in lines of 100 characters.
fn wrapped(text: &str) -> String {
    let mut out = String::from(" ");
    let mut used = 1;
    for word in text.split(' ') {
        if used + 1 + word.chars().count() > 100 {
            out.push_str("\n  ");
            used = 2;
        }
        out.push_str(if used == 1 { "- " } else { " " });
        out.push_str(word);
        used += 1 + word.chars().count();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::Experiment;

    #[test]
    fn numbers_have_three_digits() {
        let known =
            [(1.2e-5, "1.20e-5"), (0.3, "0.300"), (5.53, "5.53"), (35.7, "35.7"), (580.4, "580"), (0.0, "0")];
        for (value, text) in known {
            assert_eq!(digits(value), text);
        }
    }

    #[test]
    fn columns_are_aligned_and_lines_are_short() {
        let outcome = Outcome {
            experiment: Experiment::Dragon,
            title: Experiment::Dragon.describe(),
            rows: vec![
                Row::new("dense", "MiB", Some(35.7), 34.9),
                Row::missing("sparse, in words that are longer", "MiB", Some(6.4), "needs a mesh"),
            ],
            assumed: vec!["a word ".repeat(40).trim_end().to_owned()],
            seconds: 0.25,
        };
        let text = to_text(&[outcome]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0].find("ours"), lines[1].find("34.9"));
        assert_eq!(lines[0].find("ours"), lines[2].find("needs"));
        assert!(lines[1].ends_with("0.978") && lines[2].ends_with("a mesh"), "{text}");
        assert!(lines[4].starts_with("dragon: memory") && lines[5].starts_with(" - a word"), "{text}");
        assert!(lines[5..].len() > 2 && lines[5..].iter().all(|line| line.len() <= 100), "{text}");
    }
}
