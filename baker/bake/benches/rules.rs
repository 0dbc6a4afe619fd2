//! Quadrature rules on shapes with a closed form of their distance: error against a converged rule, and cost of a map.
//!
//! `cargo bench -p volmap-bake --bench rules`

mod shapes;

use glam::DVec3;
use shapes::{SHAPES, points};
use std::f64::consts::PI;
use std::sync::{Arc, Mutex};
use std::time::Instant;
use volmap_bake::maps::compute_maps;
use volmap_bake::plan::{Extent, GridChoice, MapSettings, plan};
use volmap_bake::volume_map::extension::extension;
use volmap_bake::volume_map::quadrature::{Point, Rule};
use volmap_bake::watch::Watch;

fn volume(phi: fn(DVec3) -> f64, rule: &[Point], x: DVec3) -> f64 {
    rule.iter().map(|p| p.weight * extension(phi(x + p.position), 1.0)).sum()
}

/// Largest error and root of the mean square, per cent of the ball.
fn errors(phi: fn(DVec3) -> f64, rule: &[Point], reference: &[(DVec3, f64)]) -> [f64; 2] {
    let error = |(x, exact): &(DVec3, f64)| 100.0 * (volume(phi, rule, *x) - exact).abs() / (4.0 / 3.0 * PI);
    let all: Vec<f64> = reference.iter().map(error).collect();
    let squares: f64 = all.iter().map(|e| e * e).sum();
    [all.iter().copied().fold(0.0, f64::max), (squares / all.len() as f64).sqrt()]
}

/// Seconds of the volume stage of a sphere of 5 r at cells of r / 2, one thread: nanoseconds a node, of all the band's.
fn cost(rule: Rule) -> f64 {
    let phi = |x: DVec3| x.length() - 0.5;
    let extent = Extent { min: DVec3::splat(-0.5), max: DVec3::splat(0.5), area: PI };
    let grid = GridChoice::CellSize(0.05);
    let settings = MapSettings { support_radius: Some(0.1), grid, rule, ..MapSettings::default() };
    let plan = plan(&extent, &settings).expect("a plan");
    let run = || {
        // The volume is the last step.
        let begun = Arc::new(Mutex::new(Instant::now()));
        let last = begun.clone();
        let watch = Watch::new(move |_| *last.lock().expect("one thread") = Instant::now());
        let maps = compute_maps(&plan, rule, &phi, &watch).expect("maps");
        let seconds = begun.lock().expect("one thread").elapsed().as_secs_f64();
        1e9 * seconds / maps.nodes.count() as f64
    };
    let mut times: Vec<f64> = (0..7).map(|_| run()).collect();
    times.sort_by(f64::total_cmp);
    times[3]
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("a thread");
    let rules: Vec<Rule> =
        ["gl30", "ball5", "ball6", "ball8", "ball10", "chord4", "chord6", "chord8", "chord10", "chord12"]
            .iter()
            .map(|name| name.parse().expect("a rule"))
            .collect();
    let references: Vec<Vec<(DVec3, f64)>> = SHAPES
        .iter()
        .map(|(_, phi)| {
            let converged = Rule::Ball(32).points();
            points(*phi).into_iter().map(|x| (x, volume(*phi, &converged, x))).collect()
        })
        .collect();
    print!("| rule | points | ns a node |");
    SHAPES.iter().for_each(|(name, _)| print!(" {name} |"));
    println!("\n| --- | --- | --- |{}", " --- |".repeat(SHAPES.len()));
    for rule in rules {
        let points = rule.points();
        print!("| `{rule}` | {} | {:.0} |", points.len(), cost(rule));
        for ((_, phi), reference) in SHAPES.iter().zip(&references) {
            let [max, rms] = errors(*phi, &points, reference);
            print!(" {max:.3} ({rms:.3}) |");
        }
        println!();
    }
}
