//! Density maps against Eq. 9 of Bender et al. 2020: point by point, in closed form, through the file, in queries.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;
use volmap_bake::density_map::{DensitySettings, oracle};
use volmap_bake::plan::{Extent, MapSettings};
use volmap_bake::rows::positions;
use volmap_bake::sdf::band::find_band;
use volmap_bake::sdf::field::{DistanceField, Phi};
use volmap_bake::volume_map::quadrature::{Rule, gauss_legendre};
use volmap_bake::watch::Work;
use volmap_formats::asset::{self, Compression, Exterior};
use volmap_runtime::KernelKind;
use volmap_runtime::layout::Nodes;
use volmap_runtime::{DQuat, DVec3, MapDensity, Pose, PosedMap, Sample, VolumeMap};
use volmap_tests::{Random, SPHERE, Solid, TORUS, asset_of, compute, map_of};

const R: f64 = 0.1;

fn settings(density: DensitySettings) -> MapSettings {
    MapSettings {
        support_radius: Some(R),
        rule: Rule::Ball(3),
        density: Some(density),
        ..MapSettings::default()
    }
}

/// All below z = 0.
const FLOOR: Solid = Solid {
    name: "floor",
    extent: Extent { min: DVec3::splat(-0.5), max: DVec3::new(0.5, 0.5, 0.0), area: 1.0 },
    phi: |x| x.z,
};

/// The solid around a sphere.
const CONTAINER: Solid = Solid { name: "container", extent: SPHERE.extent, phi: |x| 0.5 - x.length() };

#[test]
fn lattice_is_the_oracle_at_every_node() {
    let short =
        DensitySettings { extension: 0.2, rule: Rule::GaussLegendre(11), ..DensitySettings::default() };
    let wendland = DensitySettings { kernel: KernelKind::WendlandC2, rule: Rule::Chord(6), ..short };
    let cases = [
        (&SPHERE, 9, DensitySettings::default()),
        (&TORUS, 14, short),
        (&SPHERE, 25, DensitySettings { extension: 1.0, ..wendland }),
        (&CONTAINER, 12, wendland),
    ];
    for (solid, resolution, density) in cases {
        let invert = solid.name == "container";
        let (plan, maps) = compute(solid, resolution, &MapSettings { invert, ..settings(density) });
        // Phi wherever a ball may reach, on a lattice with a margin.
        let grid = plan.grown((R / plan.grid.cell_size).ceil().as_uvec3() + 1);
        let cells =
            find_band(&grid, 3.0 * R + 2.0 * grid.cell_size.length(), &solid.phi, &Work::default()).unwrap();
        let nodes = Nodes::new(grid.resolution, &cells.band).unwrap();
        let field = DistanceField::sample(grid, &cells, &nodes, Exterior::Fluid, &|x: DVec3| (solid.phi)(x));
        let phi = |x: DVec3| match field.at(x) {
            Phi::Value(phi) => phi,
            Phi::Fluid => f64::INFINITY,
            Phi::Solid => panic!("{}: {x} is too deep", solid.name),
        };
        let values = maps.density.unwrap();
        let (mut worst, mut deepest) = (0.0f64, 0.0f64);
        for (number, x) in positions(&maps.nodes, &plan.grid).enumerate().step_by(13) {
            let expected = oracle::density(phi, &density, R, x);
            worst = worst.max((values[number] - expected).abs());
            deepest = deepest.max(expected);
        }
        assert!(worst < 1e-11 && deepest > 2.0, "{}: {worst} {deepest}", solid.name);
    }
}

/// Eq. 9 at distance d from a half space for r = 1, by two exact one-dimensional rules.
fn half_space(kernel: KernelKind, d: f64) -> f64 {
    let integral = |breaks: &[f64], f: &dyn Fn(f64) -> f64| {
        let piece = |ends: &[f64]| {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            gauss_legendre(12).into_iter().map(|(x, w)| half * w * f(middle + half * x)).sum::<f64>()
        };
        breaks.windows(2).map(piece).sum::<f64>()
    };
    // W over the disc of the ball at height z.
    let disc = |z: f64| {
        let z = z.abs();
        2.0 * PI * integral(&[z, z.max(0.5), 1.0], &|q| kernel.unit_value(q) * q)
    };
    let kink = (1.0 - d).clamp(-1.0, 1.0);
    let mut breaks = vec![-1.0, -0.5, 0.0, 0.5, 1.0, kink];
    breaks.sort_by(f64::total_cmp);
    integral(&breaks, &|z| oracle::extension(d + z, 1.0) * disc(z))
}

#[test]
fn a_floor_has_the_density_of_the_half_space() {
    for kernel in [KernelKind::CubicSpline, KernelKind::WendlandC2] {
        assert!((half_space(kernel, -1.5) - 2.5).abs() < 1e-12 && half_space(kernel, 2.0) == 0.0);
        for (rule, limit) in [(Rule::GaussLegendre(30), 3e-3), (Rule::GaussLegendre(50), 5e-4)] {
            let density = DensitySettings { kernel, rule, ..DensitySettings::default() };
            let domain = Some([[-0.2, -0.2, -0.3], [0.2, 0.2, 0.25]]);
            let (plan, maps) = compute(&FLOOR, 10, &MapSettings { domain, ..settings(density) });
            let values = maps.density.unwrap();
            let (mut worst, mut deep, mut highest) = (0.0f64, 0.0f64, 0.0f64);
            let mut exact = BTreeMap::new();
            for (number, x) in positions(&maps.nodes, &plan.grid).enumerate() {
                let exact = exact.entry(x.z.to_bits()).or_insert_with(|| half_space(kernel, x.z / R));
                let error = (values[number] - *exact).abs();
                worst = worst.max(error);
                if x.z < -R {
                    deep = deep.max((values[number] - (1.0 - x.z / R)).abs());
                }
                highest = highest.max(values[number]);
            }
            assert!(worst < limit && deep < 3e-4, "{kernel} {rule}: {worst} {deep}");
            assert!(highest > 2.9, "{highest}");
        }
    }
}

#[test]
fn maps_hold_the_exact_density_to_what_the_element_allows() {
    for solid in [&SPHERE, &TORUS, &CONTAINER] {
        let invert = solid.name == "container";
        let density = DensitySettings { rule: Rule::GaussLegendre(50), ..DensitySettings::default() };
        let error = |resolution: u32| {
            let map = map_of(solid, resolution, &MapSettings { invert, ..settings(density) });
            let mut random = Random::from_state(71);
            let (mut worst, mut seen) = (0.0f64, 0);
            while seen < 300 {
                let x = random.point(map.grid().origin, map.grid().max_corner());
                let Sample::Near(near) = map.sample(x) else { continue };
                if near.distance < -R {
                    continue;
                }
                let exact = oracle::density(solid.phi, &density, R, x);
                worst = worst.max((map.density(x).unwrap().value - exact).abs());
                seen += 1;
            }
            worst
        };
        let (coarse, fine) = (error(12), error(24));
        println!("{}: largest error {coarse:.2e} at 12^3, {fine:.2e} at 24^3", solid.name);
        assert!(fine < 0.02 && fine < 0.35 * coarse, "{}: {coarse} {fine}", solid.name);
    }
}

#[test]
fn gradients_are_finite_differences() {
    let map = map_of(&TORUS, 20, &settings(DensitySettings::default()));
    let mut random = Random::from_state(73);
    let mut checked = 0;
    while checked < 1_000 {
        let x = random.point(map.grid().origin, map.grid().max_corner());
        let u = (x - map.grid().origin) / map.grid().cell_size;
        if (u - u.floor() - 0.5).abs().max_element() > 0.49 || map.sample(x).near().is_none() {
            continue;
        }
        let h = 1e-6;
        let value = |x: DVec3| map.density(x).unwrap().value;
        let slope = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| (value(x + h * e) - value(x - h * e)) / (2.0 * h));
        let gradient = map.density(x).unwrap().gradient;
        assert!((gradient - DVec3::from(slope)).length() < 1e-6 * (1.0 + gradient.length()), "{x}");
        checked += 1;
    }
}

#[test]
fn a_density_goes_through_the_file_and_is_known_where_it_can_be() {
    let (plan, maps) = compute(&SPHERE, 20, &settings(DensitySettings::default()));
    let with = asset_of(&plan, &settings(DensitySettings::default()), maps);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("density.h5");
    asset::write(&path, &with, Compression::default()).unwrap();
    assert_eq!(asset::read(&path).unwrap(), with);
    let map = VolumeMap::open(&path).unwrap();
    assert_eq!(map.density_kernel(), Some(KernelKind::CubicSpline));
    assert_eq!(map.density(DVec3::splat(9.0)), Some(MapDensity::default()));
    assert_eq!(map.density(DVec3::NAN), Some(MapDensity::default()));
    assert_eq!((map.sample(DVec3::ZERO), map.density(DVec3::ZERO)), (Sample::DeepInside, None));
    let at_surface = map.density(DVec3::X * 0.5).unwrap();
    assert!((0.8..1.2).contains(&at_surface.value) && at_surface.gradient.x < -5.0, "{at_surface:?}");
    let without = asset::Asset { density: None, ..with };
    let volume_alone = VolumeMap::from_asset(&without).unwrap();
    assert_eq!((volume_alone.density_kernel(), volume_alone.density(DVec3::X * 0.5)), (None, None));
    assert_eq!(volume_alone.sample(DVec3::X * 0.5), map.sample(DVec3::X * 0.5));
    assert!(volume_alone.memory_bytes() < map.memory_bytes());
}

#[test]
fn bodies_turn_the_gradient() {
    let map = Arc::new(map_of(&TORUS, 15, &settings(DensitySettings::default())));
    let rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    let pose = Pose { rotation, translation: DVec3::new(3.0, -2.0, 1.0) };
    let body = PosedMap { map: map.clone(), pose };
    let mut random = Random::from_state(79);
    let points: Vec<DVec3> =
        (0..1_500).map(|_| random.point(map.grid().origin, map.grid().max_corner())).collect();
    let world: Vec<DVec3> = points.iter().map(|&x| pose.to_world(x)).collect();
    let mut batch: Vec<Option<MapDensity>> = Vec::new();
    body.sample_batch(&world, &mut batch);
    let mut near = 0;
    for ((&x, &w), &in_world) in points.iter().zip(&world).zip(&batch) {
        assert_eq!(in_world, body.density(w));
        if let (Some(a), Some(b)) = (map.density(pose.to_map(w)), in_world) {
            assert_eq!(a.value, b.value, "{x}");
            assert!((rotation * a.gradient - b.gradient).length() < 1e-12 * (1.0 + a.gradient.length()));
            near += usize::from(a.value > 0.0);
        }
    }
    assert!(near > 300, "{near}");
}

/// A volume map is the same to the bit, whether or not a density is baked with it.
#[test]
fn the_volume_does_not_depend_on_the_density() {
    for (solid, invert) in [(&SPHERE, false), (&CONTAINER, true)] {
        let with = MapSettings { invert, ..settings(DensitySettings::default()) };
        let (plan, maps) = compute(solid, 13, &with);
        let (own_plan, own) = compute(solid, 13, &MapSettings { density: None, ..with });
        assert_eq!((plan.grid, &maps.cells), (own_plan.grid, &own.cells));
        assert_eq!((maps.distance, maps.volume), (own.distance, own.volume));
    }
}
