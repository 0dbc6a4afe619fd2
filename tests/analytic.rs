//! Shapes whose distance and volume are known: the error of distance and volume falls at the element's order.

use volmap_bake::plan::MapSettings;
use volmap_bake::volume_map::extension::extension;
use volmap_bake::volume_map::quadrature::{Point, Rule};
use volmap_runtime::DVec3;
use volmap_tests::{Random, SPHERE, Solid, TORUS, map_of};

const RADIUS: f64 = 0.05;
/// Points whose volume is compared, each at the cost of 18,432 distances.
const VOLUMES: usize = if cfg!(feature = "long") { 10_000 } else { 2_000 };

/// Eq. 12 on the exact distance, by a rule that is converged to 5e-5 of the ball.
fn reference(solid: &Solid, rule: &[Point], x: DVec3) -> f64 {
    let sum = |p: &Point| p.weight * extension((solid.phi)(x + RADIUS * p.position), 1.0 / RADIUS);
    RADIUS.powi(3) * rule.iter().map(sum).sum::<f64>()
}

/// Part of the lattice that is looked at.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Whole,
    /// The octant of positive coordinates, by symmetry as good as the whole.
    Octant,
}

/// Largest errors of distance (metres) and volume (of the full ball) at random points of the band.
fn errors(solid: &Solid, resolution: u32, part: Part, rule: Rule) -> [f64; 2] {
    let mut settings = MapSettings { support_radius: Some(RADIUS), rule, ..MapSettings::default() };
    let resolution = if part == Part::Octant { resolution / 2 } else { resolution };
    if part == Part::Octant {
        settings.domain = Some([[0.0; 3], (solid.extent.max + 2.0 * RADIUS).to_array()]);
    }
    let map = map_of(solid, resolution, &settings);
    let reference_rule = Rule::Ball(16).points();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let mut random = Random::from_state(42);
    let mut worst = [0.0f64; 2];
    let mut found = 0;
    while found < 10_000 {
        let x = random.point(map.grid().origin, map.grid().max_corner());
        let phi = (solid.phi)(x);
        if phi.abs() > 2.0 * RADIUS {
            continue;
        }
        let near = map.sample(x).near().unwrap_or_else(|| panic!("{x} is in the band, Phi = {phi}"));
        worst[0] = worst[0].max((near.distance - phi).abs());
        if found < VOLUMES {
            worst[1] = worst[1].max((near.volume - reference(solid, &reference_rule, x)).abs() / ball);
        }
        found += 1;
    }
    worst
}

/// Prints the table; returns, per solid and step of refinement, the orders of distance and volume, and at last the
/// finest errors of volume with both rules.
fn table(solid: &Solid, part_of_finest: Part) -> (Vec<[f64; 2]>, [f64; 2]) {
    println!("{}: max error at 10,000 random points of the band, r = {RADIUS} m", solid.name);
    println!("cells  distance/m  order  volume/ball ball10  order  volume/ball gl30");
    let mut previous: Option<[f64; 2]> = None;
    let (mut orders, mut finest) = (Vec::new(), [0.0; 2]);
    for (resolution, part) in [(20, Part::Whole), (40, Part::Whole), (80, part_of_finest)] {
        let ball = errors(solid, resolution, part, Rule::Ball(10));
        let paper = errors(solid, resolution, part, Rule::GaussLegendre(30));
        let order = previous.map(|p| [(p[0] / ball[0]).log2(), (p[1] / ball[1]).log2()]);
        let [phi_order, volume_order] = order.unwrap_or([f64::NAN; 2]);
        println!(
            "{resolution:3}^3  {:10.3e}  {phi_order:5.2}  {:18.3e}  {volume_order:5.2}  {:16.3e}",
            ball[0], ball[1], paper[1]
        );
        previous = Some(ball);
        orders.extend(order);
        finest = [ball[1], paper[1]];
    }
    (orders, finest)
}

/// Cubic elements: fourth order for the distance, which is smooth in the band. The volume has kinks in its third
/// derivatives, where gamma* has them in its second, and falls by the third.
fn check_orders(part_of_finest: Part) {
    for solid in [&SPHERE, &TORUS] {
        let (orders, [ball, paper]) = table(solid, part_of_finest);
        assert!(orders[0][0] > 3.2 && orders[1][0] > 3.9, "{}: {orders:?}", solid.name);
        assert!(orders[0][1] > 2.5 && orders[1][1] > 3.0, "{}: {orders:?}", solid.name);
        // The order-30 rule's own error of 2.6 % of the ball is its floor.
        assert!(ball < 2e-3 && (0.025..0.04).contains(&paper), "{}: {ball} {paper}", solid.name);
    }
}

#[test]
fn errors_fall_at_the_order_of_the_element() {
    check_orders(Part::Octant);
}

#[cfg(feature = "long")]
#[test]
fn errors_fall_at_the_order_of_the_element_on_the_whole_of_80_cubed() {
    check_orders(Part::Whole);
}
