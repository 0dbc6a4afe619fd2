//! Maps in two dimensions against closed forms: half plane, disc, corners. Bender et al. 2020, Eq. 9 and 12 in the
//! plane.

use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use volmap_bake::area_map::disc::DiscRule;
use volmap_bake::area_map::outline::OutlineDistance;
use volmap_bake::area_map::{AreaDensity, AreaSettings, bake};
use volmap_bake::density_map::oracle::extension as gamma;
use volmap_bake::plan::{GridChoice, Precision};
use volmap_bake::volume_map::extension::extension;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{self, Compression};
use volmap_formats::mesh::Outline;
use volmap_runtime::KernelKind;
use volmap_runtime::{DVec3 as Point, Dimension, Sample, SurfaceWithGradient, VolumeMap};

const RADIUS: f64 = 0.1;
const DISC: f64 = PI * RADIUS * RADIUS;

fn settings(cell: f64) -> AreaSettings {
    AreaSettings {
        support_radius: Some(RADIUS),
        grid: GridChoice::CellSize(cell),
        precision: Precision::F64,
        rule: DiscRule::Disc(24),
        ..AreaSettings::default()
    }
}

fn map(bounds: [DVec2; 2], phi: impl Fn(DVec2) -> f64 + Sync, settings: &AreaSettings) -> VolumeMap {
    VolumeMap::from_asset(&bake(bounds, &phi, settings, &Watch::default()).unwrap()).unwrap()
}

/// The integral of f from low to high: Simpson's rule.
fn integrate(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 800;
    let h = (high - low) / f64::from(STEPS);
    let weight = |n: u32| if n == 0 || n == STEPS { 1.0 } else { f64::from(2 + 2 * (n % 2)) };
    (0..=STEPS).map(|n| weight(n) * f(low + h * f64::from(n))).sum::<f64>() * h / 3.0
}

/// V at distance d from a straight line: over chords of length 2 r cos t at height r sin t.
fn half_plane(d: f64, of: impl Fn(f64) -> f64) -> f64 {
    let chord = |t: f64| 2.0 * (RADIUS * t.cos()).powi(2) * of(d + RADIUS * t.sin());
    integrate(-0.5 * PI, 0.5 * PI, chord)
}

/// V at distance d from the centre of a disc of radius R: over arcs around the centre.
fn around_disc(big: f64, d: f64) -> f64 {
    let arc = |rho: f64| {
        let cos = (rho * rho + d * d - RADIUS * RADIUS) / (2.0 * rho * d);
        2.0 * rho * cos.clamp(-1.0, 1.0).acos() * extension(rho - big, 1.0 / RADIUS)
    };
    // In the angle at which the arcs enter, so that the ends are smooth.
    integrate(0.0, PI, |t| arc(d - RADIUS * t.cos()) * RADIUS * t.sin())
}

/// Eq. 12 as it is written, with a fine rule.
fn anywhere(x: DVec2, phi: impl Fn(DVec2) -> f64) -> f64 {
    let term = |position: DVec2| extension(phi(x + RADIUS * position), 1.0 / RADIUS);
    DiscRule::Disc(96).points().iter().map(|p| p.weight * term(p.position)).sum::<f64>() * RADIUS * RADIUS
}

fn at(x: f64, y: f64) -> Point {
    Point::new(x, y, 0.0)
}

#[test]
fn half_plane_is_its_closed_form() {
    let wide = AreaSettings { padding: 0.3, ..settings(RADIUS / 4.0) };
    let map = map([DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.0)], |x| x.y, &wide);
    assert_eq!(map.dimension(), Dimension::Two);
    let mut worst = 0.0f64;
    for n in -60..60 {
        let d = (f64::from(n) + 0.37) / 60.0 * 2.0 * RADIUS;
        let sample = map.sample_with_gradient(at(0.0123 * f64::from(n % 7), d));
        let SurfaceWithGradient { surface: near, volume_gradient: gradient } = sample.near().unwrap();
        assert!((near.distance - d).abs() < 1e-15 && (near.normal - Point::Y).length() < 1e-12);
        assert!(near.closest_point.y.abs() < 1e-15);
        worst = worst.max((near.volume - half_plane(d, |phi| extension(phi, 1.0 / RADIUS))).abs() / DISC);
        let slope = (half_plane(d + 1e-6, |phi| extension(phi, 1.0 / RADIUS))
            - half_plane(d - 1e-6, |phi| extension(phi, 1.0 / RADIUS)))
            / 2e-6;
        assert!((gradient - slope * Point::Y).length() < 0.01 * DISC / RADIUS, "{d}: {gradient} {slope}");
        assert_eq!((gradient.z, near.normal.z), (0.0, 0.0));
    }
    assert!(worst < 2e-4, "{worst}");
    assert_eq!(map.sample(at(0.0, 0.3)), Sample::Outside);
    let deep = map.values(at(0.0, -0.3));
    assert!(deep.distance == f64::NEG_INFINITY && (deep.volume / DISC - 1.0).abs() < 1e-12);
}

#[test]
fn disc_converges_to_its_closed_form() {
    const BIG: f64 = 0.3;
    let bounds = [DVec2::splat(-BIG), DVec2::splat(BIG)];
    let error = |cell: f64| {
        let map = map(bounds, |x| x.length() - BIG, &settings(cell));
        let place = |n: u32| {
            let (angle, d) = (0.7 * f64::from(n), BIG + 2.0 * RADIUS * f64::from(n) / 200.0 - 0.5 * RADIUS);
            let here = map.values(at(d * angle.cos(), d * angle.sin()));
            (here.volume - around_disc(BIG, d)).abs() / DISC
        };
        (0..150).map(place).fold(0.0, f64::max)
    };
    let errors = [1.0, 0.5, 0.25].map(|cells| error(cells * RADIUS));
    assert!(errors[0] < 0.02 && errors[1] < errors[0] / 4.0 && errors[2] < errors[1] / 4.0, "{errors:?}");
    assert!(errors[2] < 4e-4, "{errors:?}");
}

/// The oracle of the corners is itself held against the half plane.
#[test]
fn corners_are_the_integrals_over_them() {
    for d in [-0.05, 0.0, 0.03, 0.11] {
        let error = anywhere(DVec2::new(0.2, d), |x| x.y) - half_plane(d, |phi| extension(phi, 1.0 / RADIUS));
        assert!(error.abs() < 1e-5 * DISC, "{d}: {error}");
    }
    let square = Outline {
        points: vec![[0.0, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3]],
        segments: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
        ..Outline::default()
    };
    for invert in [false, true] {
        let phi = OutlineDistance::new(&square, invert, 0.0);
        let map = map(
            phi.bounds(),
            |x| phi.at(x),
            &AreaSettings { invert, rule: DiscRule::Disc(16), ..settings(RADIUS / 6.0) },
        );
        let side = if invert { 1.0 } else { -1.0 };
        let mut worst = 0.0f64;
        for n in 0..40 {
            // Around the corner at the origin, in the fluid.
            let x = side * RADIUS * DVec2::new(1.3 * f64::from(n % 7) / 7.0, 1.3 * f64::from(n % 6) / 6.0);
            let here = map.values(x.extend(0.0));
            worst = worst.max((here.volume - anywhere(x, |x| phi.at(x))).abs() / DISC);
        }
        assert!(worst < 2e-3, "invert {invert}: {worst}");
    }
    // A quarter of the disc, and of what the extension adds, at the corner of a square: by symmetry.
    let quarter = anywhere(DVec2::ZERO, |x| if x.x < 0.0 && x.y < 0.0 { -1.0 } else { 1.0 });
    assert!((quarter / DISC - 0.25).abs() < 1e-3, "{quarter}");
}

/// gamma W over the half plane: Eq. 9 in the plane, in polar coordinates.
#[test]
fn density_of_a_half_plane_is_its_integral() {
    for kernel in [KernelKind::CubicSpline, KernelKind::WendlandC2] {
        let density = AreaDensity { kernel, rule: DiscRule::Disc(24), extension: 1.0 };
        let settings = AreaSettings { density: Some(density), ..settings(RADIUS / 4.0) };
        let map = map([DVec2::new(-0.1, 0.0), DVec2::new(0.1, 0.0)], |x| x.y, &settings);
        for n in -8..9 {
            let d = 0.11 * RADIUS * f64::from(n) + 0.003 * RADIUS;
            let ring = |s: f64| {
                let around = integrate(0.0, PI, |t| gamma(d - s * RADIUS * t.cos(), RADIUS));
                2.0 * around * s * kernel.unit_value_in_plane(s)
            };
            let exact: f64 = (0..2)
                .map(|half| {
                    const STEPS: u32 = 60;
                    let h = 0.5 / f64::from(STEPS);
                    let low = 0.5 * f64::from(half);
                    (0..STEPS).map(|n| ring(low + h * (f64::from(n) + 0.5))).sum::<f64>() * h
                })
                .sum();
            let here = map.density(at(0.05, d)).unwrap();
            assert!((here.value - exact).abs() < 2e-3, "{kernel} at {d}: {} {exact}", here.value);
            assert!(here.gradient.y < 0.0 && here.gradient.x.abs() < 1e-9 && here.gradient.z == 0.0);
        }
        // Deep in the solid gamma goes on as 1 - Phi / r, and with it the density.
        let deep = map.density(at(0.0, -1.5 * RADIUS)).unwrap();
        assert!((deep.value - 2.5).abs() < 1e-3, "{}", deep.value);
    }
}

#[test]
fn z_plays_no_part() {
    let map = map([DVec2::splat(-0.3), DVec2::splat(0.3)], |x| x.length() - 0.3, &settings(RADIUS / 2.0));
    for n in 0..50 {
        let x = DVec2::from_angle(f64::from(n)) * (0.25 + 0.004 * f64::from(n));
        let here = map.values(x.extend(0.0));
        for z in [-1e6, -0.0, 1e-9, 0.3, 7e300] {
            assert_eq!(map.values(x.extend(z)), here);
            let Sample::Near(near) = map.sample(x.extend(z)) else { continue };
            assert!(near.closest_point.z == z && near.normal.z == 0.0);
        }
        for z in [f64::NAN, f64::INFINITY] {
            assert_eq!(map.sample(x.extend(z)), Sample::Outside);
        }
    }
}

#[test]
fn assets_come_back_from_files_the_same_on_any_number_of_threads() {
    let phi = |x: DVec2| (x - DVec2::new(0.1, 0.2)).length() - 0.3;
    let bounds = [DVec2::new(-0.2, -0.1), DVec2::new(0.4, 0.5)];
    let folder = tempfile::tempdir().unwrap();
    for (precision, density) in [
        (Precision::F32, None),
        (Precision::F64, Some(AreaDensity::default())),
        (Precision::Rounded(1e-4), None),
    ] {
        let settings = AreaSettings { precision, density, ..settings(RADIUS / 3.0) };
        let asset = bake(bounds, &phi, &settings, &Watch::default()).unwrap();
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(alone.install(|| bake(bounds, &phi, &settings, &Watch::default()).unwrap()), asset);
        let path = folder.path().join("map.h5");
        asset::write(&path, &asset, Compression::default()).unwrap();
        assert_eq!(asset::read(&path).unwrap(), asset);
        assert_eq!(asset.format_version(), 3 + u64::from(density.is_some()));
        let map = VolumeMap::open(&path).unwrap();
        assert_eq!(map.density_kernel().is_some(), density.is_some());
        let near = map.sample(at(0.45, 0.2)).near().unwrap();
        assert!((near.distance - 0.05).abs() < 2e-3 && (near.normal - DVec3::X).length() < 0.02);
    }
}

#[test]
fn settings_that_make_no_map_are_named() {
    let line = [DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.0)];
    let error = |settings: AreaSettings| {
        bake(line, &|x: DVec2| x.y, &settings, &Watch::default()).unwrap_err().to_string()
    };
    let base = || settings(RADIUS);
    let cases = [
        (AreaSettings { support_radius: Some(f64::NAN), ..base() }, "support_radius"),
        (AreaSettings { grid: GridChoice::CellSize(-1.0), ..base() }, "cell_size"),
        (AreaSettings { grid: GridChoice::CellSize(1e-5), ..base() }, "cell_size"),
        (AreaSettings { grid: GridChoice::Resolution([0, 5, 5]), ..base() }, "resolution"),
        (AreaSettings { padding: -1.0, ..base() }, "padding"),
        (AreaSettings { domain: Some([[0.0, 1.0], [1.0, 0.0]]), ..base() }, "domain"),
        (AreaSettings { domain: Some([[0.0, 5.0], [1.0, 6.0]]), ..base() }, "domain"),
    ];
    for (settings, part) in cases {
        let error = error(settings);
        assert!(error.contains(part), "{error}");
    }
}
