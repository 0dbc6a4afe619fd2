//! Density maps: quadrature rules on shapes with a closed form of their distance, against a converged rule, and what a
//! density map costs beside a volume map.
//!
//! `cargo bench -p volmap-baker --bench density`

mod shapes;

use glam::DVec3;
use shapes::{SHAPES, points};
use volmap_baker::density_map::DensitySettings;
use volmap_baker::density_map::oracle::density;
use volmap_baker::density_map::smoothing::Smoothing;
use volmap_baker::volume_map::quadrature::Rule;

const RULES: [&str; 11] =
    ["gl30", "gl50", "gl100", "ball5", "ball6", "ball8", "ball10", "chord6", "chord8", "chord10", "chord12"];

/// Largest error and root of the mean square, per cent of rest density.
fn errors(phi: fn(DVec3) -> f64, settings: &DensitySettings, reference: &[(DVec3, f64)]) -> [f64; 2] {
    let error = |(x, exact): &(DVec3, f64)| 100.0 * (density(phi, settings, 1.0, *x) - exact).abs();
    let all: Vec<f64> = reference.iter().map(error).collect();
    let squares: f64 = all.iter().map(|e| e * e).sum();
    [all.iter().copied().fold(0.0, f64::max), (squares / all.len() as f64).sqrt()]
}

fn rules(kernel: Smoothing) {
    let with = |rule: Rule| DensitySettings { kernel, rule, ..DensitySettings::default() };
    let converged = with(Rule::GaussLegendre(200));
    let references: Vec<Vec<(DVec3, f64)>> = SHAPES
        .iter()
        .map(|(_, phi)| {
            let exact = |x| (x, density(phi, &converged, 1.0, x));
            points(*phi).into_iter().map(exact).collect()
        })
        .collect();
    println!("{kernel}");
    print!("| rule | points | integral of W |");
    SHAPES.iter().for_each(|(name, _)| print!(" {name} |"));
    println!("\n| --- | --- | --- |{}", " --- |".repeat(SHAPES.len()));
    for rule in RULES.map(|name| name.parse().expect("a rule")) {
        let settings = with(rule);
        let integral: f64 = settings.points().iter().map(|p| p.weight).sum();
        print!("| `{rule}` | {} | 1 {:+.1e} |", settings.points().len(), integral - 1.0);
        for ((_, phi), reference) in SHAPES.iter().zip(&references) {
            let [max, rms] = errors(*phi, &settings, reference);
            print!(" {max:.3} ({rms:.3}) |");
        }
        println!();
    }
}

fn main() {
    [Smoothing::CubicSpline, Smoothing::WendlandC2].into_iter().for_each(rules);
}
