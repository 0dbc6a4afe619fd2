//! The short forms of the experiments: everything that has a target meets it. `volmap-sim validate` has the long ones.

use volmap_solver::validation::{EXPERIMENTS, Experiment, Outcome, Run, table};

fn short(name: &str) -> Outcome {
    let experiment = Experiment::named(name).unwrap();
    let outcome = (experiment.run)(&Run { short: true, folder: None, progress: &|_| () }).unwrap();
    assert!(outcome.rows.iter().any(|row| row.met.is_some()), "{name} has targets");
    assert_eq!(outcome.unmet().count(), 0, "{}", table::to_text(name, &outcome));
    outcome
}

#[test]
fn water_at_rest_lies_in_layers_under_its_own_weight() {
    let outcome = short("hydrostatic");
    assert_eq!(outcome.measured("mirror", "particles"), Some(4000.0));
}

#[test]
fn nothing_gives_or_takes_momentum() {
    short("momentum");
}

#[test]
fn experiments_have_names_of_their_own() {
    let mut names: Vec<&str> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), EXPERIMENTS.len());
    assert!(EXPERIMENTS.iter().all(|experiment| !experiment.title.is_empty() && !experiment.about.is_empty()));
}
