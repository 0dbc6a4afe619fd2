//! The short forms of rest and momentum within bounds, which are wider than the targets where those are not met:
//! VALIDATION.md. `volmap-sim validate` has the long ones.

use volmap_bake::watch::Watch;
use volmap_experiments::reproduce;
use volmap_experiments::validation::{EXPERIMENTS, Outcome, Run, table};

fn short(name: &str) -> Outcome {
    let experiment = EXPERIMENTS.iter().find(|experiment| experiment.name == name).unwrap();
    (experiment.run)(&Run { short: true, watch: &Watch::default(), progress: &|_| () }).unwrap()
}

fn between(outcome: &Outcome, case: &str, quantity: &str, [least, most]: [f64; 2]) {
    let value = outcome.measured(case, quantity).unwrap();
    assert!((least..=most).contains(&value), "{quantity}: {value}\n{}", table::to_text(case, outcome));
}

#[test]
fn water_at_rest_lies_in_layers_under_its_own_weight() {
    let outcome = short("hydrostatic");
    let is = |quantity, bounds| between(&outcome, "mirror, block", quantity, bounds);
    is("particles", [2890.0; 2]);
    is("lost", [0.0; 2]);
    // When the block falls on the floor.
    is("found in the wall", [0.0, 10.0]);
    is("first layer above the floor", [0.9, 1.1]);
    is("first layer at the walls", [0.9, 1.1]);
    is("height of the water", [0.95 * 0.361, 1.05 * 0.361]);
    is("rms speed", [0.0, 0.012]);
    is("drift of the centre of mass", [0.0, 0.1]);
    is("pressure in the middle, error", [-3.0, 3.0]);
    is("pressure at the floor, error", [-5.0, 5.0]);
    is("largest density", [1.0, 1.005]);
}

#[test]
fn nothing_gives_or_takes_momentum() {
    let outcome = short("momentum");
    assert_eq!(outcome.unmet().count(), 0, "{}", table::to_text("momentum", &outcome));
    between(&outcome, "viscous", "angular momentum, largest drift", [0.0, 1e-4]);
}

#[test]
fn experiments_have_names_of_their_own() {
    for all in [EXPERIMENTS, reproduce::EXPERIMENTS] {
        let mut names: Vec<&str> = all.iter().map(|experiment| experiment.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
        assert!(all.iter().all(|experiment| !experiment.title.is_empty() && !experiment.about.is_empty()));
    }
}
