//! The fast integral against the plain one, and the band against its definition.

use volmap_bake::maps::compute_maps;
use volmap_bake::plan::{GridChoice, MapSettings, plan};
use volmap_bake::rows::positions;
use volmap_bake::sdf::field::DistanceField;
use volmap_bake::volume_map::oracle;
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_formats::asset::Exterior;
use volmap_runtime::layout::Cell;
use volmap_runtime::{DVec3, VolumeMap};
use volmap_tests::{Random, SPHERE, Solid, TORUS, asset_of, compute};

/// A box of 0.8 x 0.5 x 0.3 with a notch: flat faces, edges, a concave edge. Exact outside, a bound inside.
const NOTCHED: Solid = Solid {
    name: "notched box",
    extent: volmap_bake::plan::Extent {
        min: DVec3::new(-0.4, -0.25, -0.15),
        max: DVec3::new(0.4, 0.25, 0.15),
        area: 1.58,
    },
    phi: |x| {
        let cuboid = |x: DVec3, half: DVec3| {
            let q = x.abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        };
        let body = cuboid(x, DVec3::new(0.4, 0.25, 0.15));
        let notch = cuboid(x - DVec3::new(0.3, 0.2, 0.0), DVec3::new(0.2, 0.15, 0.3));
        body.max(-notch)
    },
};

/// The same as a container.
const CONTAINER: Solid = Solid { name: "container", extent: NOTCHED.extent, phi: |x| -(NOTCHED.phi)(x) };

#[test]
fn lattice_is_the_oracle_at_every_node() {
    for (solid, resolution, invert) in
        [(&SPHERE, 9, false), (&TORUS, 14, false), (&NOTCHED, 11, false), (&CONTAINER, 8, true)]
    {
        for rule in [Rule::GaussLegendre(30), Rule::Ball(6), Rule::GaussLegendre(5)] {
            let settings = MapSettings { support_radius: Some(0.1), rule, invert, ..MapSettings::default() };
            let (plan, maps) = compute(solid, resolution, &settings);
            let exterior = if invert { Exterior::Solid } else { Exterior::Fluid };
            let phi = |x: DVec3| (solid.phi)(x);
            let field = DistanceField::sample(plan.grid, &maps.cells, &maps.nodes, exterior, &phi);
            let points = rule.points();
            let mut worst = 0.0f64;
            for (number, x) in positions(&maps.nodes, &plan.grid).enumerate().step_by(7) {
                let expected = oracle::volume(&field, &points, plan.support_radius, x);
                worst = worst.max((maps.volume[number] - expected).abs());
            }
            // Points on cell faces may fall to either side: continuous, so to rounding.
            assert!(worst < 1e-13, "{} {rule}: {worst}", solid.name);
        }
    }
}

#[test]
fn band_holds_every_cell_with_a_point_within_two_radii() {
    let settings = MapSettings { support_radius: Some(0.08), rule: Rule::Ball(2), ..MapSettings::default() };
    for solid in [&SPHERE, &TORUS, &NOTCHED] {
        let (plan, maps) = compute(solid, 24, &settings);
        let field = DistanceField::sample(plan.grid, &maps.cells, &maps.nodes, plan.exterior, &|x: DVec3| {
            (solid.phi)(x)
        });
        let mut random = Random::from_state(19);
        let mut unneeded = 0;
        for cell in 0..24u32.pow(3) {
            let cell = [cell % 24, cell / 24 % 24, cell / 576];
            let corner = plan.grid.cell_corner(cell.into());
            let kind = field.cells.find(cell.into());
            let mut nearest = f64::INFINITY;
            for _ in 0..60 {
                let phi = (solid.phi)(random.point(corner, corner + plan.grid.cell_size));
                nearest = nearest.min(phi.abs());
                match kind {
                    Cell::Band(_) => (),
                    Cell::Solid => assert!(phi < -plan.band_width, "{} {cell:?}: {phi}", solid.name),
                    Cell::Fluid => assert!(phi > plan.band_width, "{} {cell:?}: {phi}", solid.name),
                }
            }
            let spare = matches!(kind, Cell::Band(_))
                && nearest > plan.band_width + 0.3 * plan.grid.cell_size.length();
            unneeded += usize::from(spare);
        }
        assert_eq!(unneeded, 0, "{}: cells kept without need", solid.name);
    }
}

#[test]
fn a_domain_that_cuts_the_band_changes_no_value() {
    let settings = MapSettings {
        support_radius: Some(0.1),
        grid: GridChoice::CellSize(0.05),
        rule: Rule::GaussLegendre(9),
        ..MapSettings::default()
    };
    let whole = plan(&NOTCHED.extent, &settings).unwrap();
    let map = |settings: &MapSettings| {
        let plan = plan(&NOTCHED.extent, settings).unwrap();
        let maps = compute_maps(&plan, settings.rule, &NOTCHED.phi, &Watch::default()).unwrap();
        (plan.clone(), VolumeMap::from_asset(&asset_of(&plan, settings, maps)).unwrap())
    };
    let (_, all) = map(&settings);
    // A box of whole cells in the middle of things.
    let low = whole.grid.cell_corner([6, 4, 5].into());
    let high = whole.grid.cell_corner([17, 12, 9].into());
    let (cut_plan, cut) =
        map(&MapSettings { domain: Some([low.to_array(), high.to_array()]), ..settings.clone() });
    assert!(cut_plan.cut[0].iter().all(|&c| c > 0.0) && cut_plan.margin.min_element() >= 2);
    let mut random = Random::from_state(23);
    let mut near = 0;
    for _ in 0..5_000 {
        let at = random.point(low, high);
        let (Some(a), Some(b)) = (all.sample(at).near(), cut.sample(at).near()) else { continue };
        assert!((a.distance - b.distance).abs() < 1e-12 && (a.volume - b.volume).abs() < 1e-12, "{at}");
        near += 1;
    }
    assert!(near > 1_000, "{near}");
}

#[test]
fn values_at_the_ends_are_nothing_and_the_rules_ball() {
    for rule in [Rule::GaussLegendre(30), Rule::Ball(6)] {
        let settings = MapSettings { support_radius: Some(0.1), rule, ..MapSettings::default() };
        let (plan, maps) = compute(&SPHERE, 20, &settings);
        let ball = rule.ball_volume(0.1);
        for (phi, v) in maps.distance.iter().zip(&maps.volume) {
            assert!((0.0..=ball * (1.0 + 1e-12)).contains(v));
            if *phi > plan.band_width * 1.01 {
                assert_eq!(*v, 0.0);
            }
            if *phi < -1.1 * plan.support_radius {
                assert!((v / ball - 1.0).abs() < 1e-9, "{v} at {phi}");
            }
        }
    }
}

/// The paper's rule, bit for bit: maps that were baked with it can be made again.
#[test]
fn bits_of_gl30_never_change() {
    let rule = Rule::GaussLegendre(30);
    let settings = MapSettings { support_radius: Some(0.1), rule, ..MapSettings::default() };
    for (solid, expected) in [(&SPHERE, 0xc5d56db092b4839au64), (&NOTCHED, 0x9b9ddd66b6f41b5b)] {
        let (_, maps) = compute(solid, 12, &settings);
        // FNV-1a over the bits.
        let hash = maps
            .volume
            .iter()
            .flat_map(|v| v.to_bits().to_le_bytes())
            .fold(0xcbf29ce484222325u64, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x100000001b3));
        assert_eq!(hash, expected, "{}: {hash:#x}", solid.name);
    }
}
