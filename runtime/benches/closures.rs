//! How right and how fast closures are: `cargo bench -p volmap-runtime --bench closures`.
//!
//! The table of `BENCHMARKS.md`: the ratio of the density to the exact one over all distances and places of a shape,
//! and its largest error in parts of the rest density.

#[path = "../tests/shapes/mod.rs"]
mod shapes;

use shapes::*;
use std::hint::black_box;
use std::time::Instant;
use volmap_runtime::{BoundaryDensity, Closure, ClosureKind, Kernel, KernelKind};

const STEPS: i32 = 100;

fn main() {
    for kind in KernelKind::ALL {
        accuracy(&Kernel::new(kind, 1.0));
    }
    times();
}

fn all_shapes() -> Vec<Shape> {
    vec![
        plane(),
        ball("ball 4 r", 4.0),
        bowl("bowl 4 r", 4.0),
        bowl("bowl 2 r", 2.0),
        ball("ball r", 1.0),
        ball("ball r/2", 0.5),
        cylinder("cylinder r", 1.0),
        cylinder("cylinder r/2", 0.5),
        concave_edge(),
        along_concave_edge(),
        concave_corner(),
        convex_edge(),
        around_convex_edge(),
        convex_corner(),
        plate("plate r/4", 0.25),
        plate("plate r/8", 0.125),
        plate_end("end of plate r/2", 0.5),
        plate_end("end of plate r/4", 0.25),
    ]
}

fn accuracy(kernel: &Kernel) {
    println!("{}: ratio to the exact density, largest error\n", kernel.kind());
    // `mirror` isn't meant to be the integral of W.
    let kinds = ClosureKind::ALL.into_iter().filter(|&kind| !kind.has_image());
    let closures: Vec<Closure> = kinds.map(|kind| closure_of(kind, *kernel, PARTICLE)).collect();
    print!("| shape |");
    closures.iter().for_each(|closure| print!(" {} |", closure.kind()));
    println!(" wedge, probing |\n| --- |{}", " --- |".repeat(closures.len() + 1));
    for shape in all_shapes() {
        let cases = cases(&shape, kernel, STEPS);
        print!("| {} |", shape.name);
        for closure in &closures {
            column(&cases, |case| closure.density(&case.surface, case.position));
        }
        let wedge = closures.iter().find(|it| it.kind() == ClosureKind::Wedge).expect("all are there");
        column(&cases, |case| wedge.density_probing(&case.surface, case.position, &shape.phi));
        println!();
    }
    println!();
}

fn column(cases: &[Case], density: impl Fn(&Case) -> Option<BoundaryDensity>) {
    let (mut low, mut high, mut error) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    for case in cases {
        let value = density(case).map_or(0.0, |at| at.density);
        (low, high) = (low.min(value / case.density), high.max(value / case.density));
        error = error.max((value - case.density).abs());
    }
    print!(" {low:.2}-{high:.2}, {error:.3} |");
}

/// Nanoseconds a particle, milliseconds a construction; medians of 15 rounds in which all take turns.
fn times() {
    const ROUNDS: usize = 15;
    const REPEATS: usize = 2_000;
    let kernel = Kernel::new(KernelKind::CubicSpline, 1.0);
    let cases: Vec<Case> =
        [convex_edge(), plane(), concave_edge()].iter().flat_map(|it| cases(it, &kernel, 20)).collect();
    let mut rounds = [const { Vec::new() }; ClosureKind::ALL.len()];
    for _ in 0..ROUNDS {
        for (kind, rounds) in ClosureKind::ALL.into_iter().zip(&mut rounds) {
            let start = Instant::now();
            // The volumes are of balls of radius 1: those that the kind's maps have.
            let scale = 1.0 / kind.map_radius(1.0);
            let closure = closure_of(kind, Kernel::new(kernel.kind(), scale), scale * PARTICLE);
            let made = start.elapsed().as_secs_f64() * 1e3;
            let start = Instant::now();
            for case in (0..REPEATS).flat_map(|_| &cases) {
                black_box(closure.density(black_box(&case.surface), case.position));
            }
            let each = start.elapsed().as_secs_f64() * 1e9 / (REPEATS * cases.len()) as f64;
            rounds.push((each, made));
        }
    }
    println!("| closure | ns a particle | ms to make |\n| --- | --- | --- |");
    for (kind, mut rounds) in ClosureKind::ALL.into_iter().zip(rounds) {
        rounds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let each = rounds[ROUNDS / 2].0;
        rounds.sort_by(|a, b| a.1.total_cmp(&b.1));
        println!("| {kind} | {each:.1} | {:.2} |", rounds[ROUNDS / 2].1);
    }
}
