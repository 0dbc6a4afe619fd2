//! Shapes whose distance and volume are known: the error of distance and volume falls at the element's order.

use volmap_baker::plan::Settings;
use volmap_baker::volume_map::extension::extension;
use volmap_baker::volume_map::quadrature::{Point, Rule};
use volmap_runtime::DVec3;
use volmap_tests::{Random, SPHERE, Solid, TORUS, map_of};

const RADIUS: f64 = 0.1;

/// Eq. 12 on the exact distance, by a rule that is converged to about 1e-5 of the ball.
fn reference(solid: &Solid, rule: &[Point], x: DVec3) -> f64 {
    let sum = |p: &Point| p.weight * extension((solid.phi)(x + RADIUS * p.position), 1.0 / RADIUS);
    RADIUS.powi(3) * rule.iter().map(sum).sum::<f64>()
}

/// Largest errors of distance (metres) and volume (of the full ball) at random points of the band.
fn errors(solid: &Solid, resolution: u32, rule: Rule, points: usize) -> [f64; 2] {
    let map =
        map_of(solid, resolution, &Settings { support_radius: Some(RADIUS), rule, ..Settings::default() });
    let reference_rule = Rule::Ball(24).points();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let mut random = Random(42);
    let mut worst = [0.0f64; 2];
    let mut found = 0;
    while found < points {
        let x = random.point(map.grid().origin, map.grid().max_corner());
        let phi = (solid.phi)(x);
        if phi.abs() > 2.0 * RADIUS {
            continue;
        }
        let near = map.sample(x).near().unwrap_or_else(|| panic!("{x} is in the band, Phi = {phi}"));
        worst[0] = worst[0].max((near.distance - phi).abs());
        if found % 10 == 0 {
            worst[1] = worst[1].max((near.volume - reference(solid, &reference_rule, x)).abs() / ball);
        }
        found += 1;
    }
    worst
}

#[test]
fn errors_fall_at_the_order_of_the_element() {
    println!("max error at 10,000 random points of the band, r = {RADIUS} m (volume: at 1,000 of them)");
    println!("shape   cells  distance/m  order  volume/ball ball10  order  volume/ball gl30");
    for solid in [&SPHERE, &TORUS] {
        let mut previous: Option<[f64; 2]> = None;
        for resolution in [20, 40, 80] {
            let fine = errors(solid, resolution, Rule::Ball(10), 10_000);
            let paper = errors(solid, resolution, Rule::GaussLegendre(30), 10_000);
            let orders = previous.map(|p| [(p[0] / fine[0]).log2(), (p[1] / fine[1]).log2()]);
            let [phi_order, volume_order] = orders.unwrap_or([f64::NAN; 2]);
            println!(
                "{:7} {resolution:4}^3  {:.3e}  {phi_order:5.2}  {:17.3e}  {volume_order:5.2}  {:16.3e}",
                solid.name, fine[0], fine[1], paper[1]
            );
            previous = Some(fine);
        }
    }
}
