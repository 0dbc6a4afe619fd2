//! The experiments of `volmap-sim reproduce` in short, with bounds of their physics. The feature `long` has them.

use volmap_solver::reproduce::{friction, incline, puck, sticky, table1};
use volmap_solver::validation::{Experiment, Outcome, Run};

fn run(experiment: Experiment) -> Outcome {
    let outcome = (experiment.run)(&Run { short: true, folder: None, progress: &|_| () }).unwrap();
    for row in &outcome.rows {
        println!("{}: {} = {} {}", row.case, row.quantity, row.measured, row.unit);
    }
    outcome
}

fn of(outcome: &Outcome, case: &str, quantity: &str) -> f64 {
    outcome.measured(case, quantity).unwrap_or_else(|| panic!("no {quantity} of {case}"))
}

#[test]
fn particles_throw_single_ones_aside_and_maps_do_not() {
    let outcome = run(incline::EXPERIMENT);
    let aside = |case| of(&outcome, case, "rms to the side");
    assert!(aside("volume map") < 0.1, "{}", aside("volume map"));
    assert!(aside("particles") > 20.0 * aside("volume map"), "{}", aside("particles"));
    let way = of(&outcome, "volume map", "way down over g sin(slope) t^2 / 2");
    assert!((way - 1.0).abs() < 0.01, "{way}");
}

#[test]
fn a_puck_spins_on_a_map_for_ever() {
    let outcome = run(puck::EXPERIMENT);
    let loss = |case| of(&outcome, case, "part of the spin that was lost");
    assert!(loss("volume map, spins").abs() < 0.002, "{}", loss("volume map, spins"));
    assert!(loss("particles, spins") > 0.02, "{}", loss("particles, spins"));
    let drift = of(&outcome, "volume map, spins", "farthest drift");
    assert!(drift < 0.01, "{drift}");
    let speed = of(&outcome, "volume map, slides", "speed over g sin(slope) t");
    assert!((speed - 1.0).abs() < 0.01, "{speed}");
}

#[test]
fn a_thick_fluid_stays_where_it_sticks() {
    let outcome = run(sticky::EXPERIMENT);
    for scene in ["grid", "ball"] {
        let held = |coefficient: u32| {
            let case = format!("{scene}, mu_B = {coefficient} kg/(m s)");
            of(&outcome, &case, "part of the fluid that is held at the end")
        };
        assert!(held(10000) > 0.6 && held(10000) > held(0) + 0.1, "{scene}: {} {}", held(0), held(10000));
    }
}

#[test]
fn friction_shortens_the_way() {
    let outcome = run(friction::EXPERIMENT);
    assert!(outcome.rows.len() > 7);
    let unmet: Vec<_> = outcome.unmet().collect();
    assert!(unmet.is_empty(), "{unmet:?}");
}

/// No times: tests run beside each other.
#[test]
fn all_methods_race() {
    let outcome = run(table1::EXPERIMENT);
    for case in ["particles", "density map", "volume map, as the paper", "volume map"] {
        assert!(of(&outcome, case, "total") > 0.0);
        let iterations = of(&outcome, case, "iterations of both solves in a step");
        assert!((3.0..60.0).contains(&iterations), "{case}: {iterations}");
    }
    assert!(of(&outcome, "particles", "boundary particles") > 1000.0);
    assert_eq!(of(&outcome, "volume map", "boundary particles"), 0.0);
}
