//! The flow experiments of `volmap-sim validate` in short, with bounds of their physics. They take a minute: the
//! feature `long` has them.

use volmap_bake::watch::Watch;
use volmap_experiments::validation::{Experiment, Outcome, Run, dam_break, floats, grid, incline, sphere};

fn run(experiment: Experiment) -> Outcome {
    let outcome =
        (experiment.run)(&Run { short: true, watch: &Watch::default(), progress: &|_| () }).unwrap();
    for row in &outcome.rows {
        println!("{}: {} = {} {}", row.case, row.quantity, row.measured, row.unit);
    }
    outcome
}

fn assert_all_met(outcome: &Outcome) {
    assert!(!outcome.rows.is_empty());
    let unmet: Vec<_> = outcome.unmet().collect();
    assert!(unmet.is_empty(), "{unmet:?}");
}

#[test]
fn a_dam_break_is_as_fast_as_measured() {
    let outcome = run(dam_break::EXPERIMENT);
    let of = |quantity: &str| outcome.measured("a = 12 particles", quantity).unwrap();
    assert!(of("front, rms deviation") < 0.25, "{}", of("front, rms deviation"));
    assert!(of("front, rms after the gate's delay") < 0.06);
    assert!(of("height, rms deviation") < 0.08, "{}", of("height, rms deviation"));
}

#[test]
fn bodies_are_lifted_and_float() {
    let outcome = run(floats::EXPERIMENT);
    let lift = outcome.measured("ball, held", "lift over weight of displaced water").unwrap();
    assert!((lift - 1.0).abs() < 0.05, "{lift}");
    for (body, across, most) in [("ball", 8, 0.04), ("box", 8, 0.05), ("ball", 16, 0.025), ("box", 16, 0.025)]
    {
        let case = format!("{body}, {across} rp, 500 kg/m^3");
        let of = |quantity: &str| outcome.measured(&case, quantity).unwrap();
        let submerged = of("submerged part less Archimedes'");
        assert!(submerged.abs() < most, "{case}: {submerged}");
        // What begins off the lattice throws it up a little.
        assert!(of("largest speed") < 2.0);
    }
    let early = "acceleration over the closed form, first 0.05 s";
    let early = outcome.measured("ball of 500 kg/m^3, released", early).unwrap();
    assert!((early - 1.0).abs() < 0.1, "{early}");
}

#[test]
fn a_spinning_ball_leaves_water_alone() {
    assert_all_met(&run(sphere::EXPERIMENT));
}

#[test]
fn single_particles_slide_straight() {
    assert_all_met(&run(incline::EXPERIMENT));
}

#[test]
fn thin_walls_hold() {
    assert_all_met(&run(grid::EXPERIMENT));
}
