//! Closures against closed forms.

use super::*;
use crate::kernel::KernelKind;
use crate::sample::SurfaceWithGradient;
use volmap_formats::asset::Dimension;

const RADIUS: f64 = 0.1;
const PARTICLE: f64 = 0.025;

fn kernel(kind: KernelKind) -> Kernel {
    Kernel::new(kind, RADIUS)
}

/// What a map of the half space below z = 0 says at height d.
fn wall(d: f64) -> (Surface, DVec3) {
    wall_for(ClosureKind::Paper, d)
}

/// The same, by the map that a closure takes.
fn wall_for(kind: ClosureKind, d: f64) -> (Surface, DVec3) {
    let radius = kind.map_radius(RADIUS);
    let volume = plane::volume(d / radius)[0] * radius.powi(3);
    let closest_point = DVec3::new(0.3, -0.2, 0.0);
    (Surface { distance: d, normal: DVec3::Z, closest_point, volume }, closest_point + d * DVec3::Z)
}

fn at_wall(closure: &Closure, d: f64) -> BoundaryDensity {
    let (boundary, position) = wall_for(closure.kind(), d);
    closure.density(&boundary, position).unwrap()
}

/// The half space's density for radius 1, its polynomials worked out by hand; 0 <= d <= 1.
fn half_space(kind: KernelKind, d: f64) -> f64 {
    let u = 1.0 - d;
    match kind {
        KernelKind::CubicSpline if d < 0.5 => {
            0.5 - 1.4 * d + 8.0 / 3.0 * d.powi(3) - 4.8 * d.powi(5) + 3.2 * d.powi(6)
        }
        KernelKind::CubicSpline => 1.6 * u.powi(5) - 16.0 / 15.0 * u.powi(6),
        KernelKind::WendlandC2 => 3.5 * u.powi(6) - 4.5 * u.powi(7) + 1.5 * u.powi(8),
        KernelKind::Spiky => 1.5 * u.powi(5) - u.powi(6),
        KernelKind::Poly6 => {
            let odd = d - 4.0 / 3.0 * d.powi(3) + 1.2 * d.powi(5) - 4.0 / 7.0 * d.powi(7) + d.powi(9) / 9.0;
            0.5 - 315.0 / 256.0 * odd
        }
    }
}

/// Distances in parts of r, between the nodes of the tables.
fn distances(low: f64, high: f64) -> impl Iterator<Item = f64> {
    (0..401).map(move |n| low + (high - low) * f64::from(n) / 400.3)
}

#[test]
fn half_space_density_is_the_closed_form() {
    for kind in KernelKind::ALL {
        for d in distances(0.0, 1.0) {
            let [value, slope] = plane::density(kind, d);
            assert!((value - half_space(kind, d)).abs() < 1e-14, "{kind} at {d}");
            assert!((plane::density(kind, -d)[0] + value - 1.0).abs() < 1e-14);
            let difference = (half_space(kind, d + 1e-6) - half_space(kind, d - 1e-6)) / 2e-6;
            assert!((slope - difference).abs() < 1e-8, "{kind} at {d}: {slope} {difference}");
        }
    }
}

#[test]
fn half_space_volume_is_a_ball_inside_and_nothing_beyond_2_radii() {
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    for d in [-3.0, -1.5, -1.0] {
        assert!((plane::volume(d)[0] - ball).abs() < 1e-14 && plane::volume(d)[1] == 0.0);
    }
    assert_eq!((plane::volume(2.0), plane::volume(9.0)), ([0.0; 2], [0.0; 2]));
    assert!(plane::volume(1.9)[0] > 0.0);
    for d in distances(-2.0, 2.2) {
        let difference = (plane::volume(d + 1e-6)[0] - plane::volume(d - 1e-6)[0]) / 2e-6;
        assert!((plane::volume(d)[1] - difference).abs() < 1e-8, "at {d}");
    }
}

#[test]
fn calibrated_is_exact_at_a_flat_wall() {
    for kind in KernelKind::ALL {
        let closure = Closure::new(ClosureKind::Calibrated, kernel(kind), PARTICLE);
        for d in distances(0.0, 0.999) {
            let at = at_wall(&closure, d * RADIUS);
            assert!((at.density - half_space(kind, d)).abs() < 1e-8, "{kind} at {d}");
            let slope = plane::density(kind, d)[1] / RADIUS;
            assert!(
                (at.gradient - slope * DVec3::Z).length() < 1e-5,
                "{kind} at {d}: {}",
                at.gradient.z - slope
            );
        }
    }
}

#[test]
fn exponent_has_the_published_values() {
    // DESIGN: 1.30 at 0.25 rp to 1.44 at 2.5 rp for the cubic spline, r = 4 rp.
    let exponent = |d: f64| plane::exponent(KernelKind::CubicSpline, d / 4.0);
    assert!((exponent(0.25) - 1.30).abs() < 0.005, "{}", exponent(0.25));
    assert!((exponent(2.5) - 1.44).abs() < 0.005, "{}", exponent(2.5));
    for kind in KernelKind::ALL {
        assert!((plane::exponent(kind, 1.0) - plane::exponent(kind, 1.0 - 1e-7)).abs() < 1e-5, "{kind}");
        assert!(plane::exponent(kind, -1.0 + 2e-6).abs() < 1e-4, "{kind}");
    }
}

#[test]
fn paper_is_equation_14_and_15() {
    for kind in KernelKind::ALL {
        let closure = Closure::new(ClosureKind::Paper, kernel(kind), PARTICLE);
        let (boundary, position) = wall(0.03);
        let at = closure.density(&boundary, position).unwrap();
        let away = position - boundary.closest_point;
        let slope = kernel(kind).derivative(away.length());
        assert!((at.density / (boundary.volume * kernel(kind).value(away.length())) - 1.0).abs() < 1e-12);
        assert!((at.gradient - boundary.volume * slope * away / away.length()).length() < 1e-10);
        assert_eq!(at.point, boundary.closest_point);
    }
}

#[test]
fn offset_is_the_peers() {
    let kernel = kernel(KernelKind::CubicSpline);
    let closure = Closure::new(ClosureKind::Offset, kernel, PARTICLE);
    for (d, distance) in [(0.01, 0.05), (0.0374, 0.05), (0.05, 0.0625), (0.08, 0.0925)] {
        let (boundary, position) = wall(d);
        let at = closure.density(&boundary, position).unwrap();
        assert!(
            (at.density / (0.8 * boundary.volume * kernel.value(distance)) - 1.0).abs() < 1e-12,
            "at {d}"
        );
        assert!((position.z - at.point.z - distance).abs() < 1e-15);
    }
    let (boundary, position) = wall(0.09);
    assert_eq!(closure.density(&boundary, position), None);
}

#[test]
fn density_grows_inwards_and_pushes_out() {
    for kind in KernelKind::ALL {
        for closure in ClosureKind::ALL.map(|it| Closure::new(it, kernel(kind), PARTICLE)) {
            let mut last: Option<BoundaryDensity> = None;
            for n in 0..3000 {
                let d = RADIUS * (1.0 - f64::from(n) * 0.001);
                let (boundary, position) = wall_for(closure.kind(), d);
                let Some(at) = closure.density(&boundary, position) else { continue };
                assert!(at.gradient.z <= 0.0, "{} {kind} at {d}", closure.kind());
                if let Some(last) = last {
                    let rise = at.density - last.density;
                    assert!(rise >= 0.0, "{} {kind} at {d}: {rise}", closure.kind());
                    assert!(rise < 0.02 * (last.density + 1.0), "{} {kind} jumps at {d}", closure.kind());
                }
                last = Some(at);
            }
            let deep = at_wall(&closure, -0.02);
            assert!(deep.gradient.z < -1.0, "{} {kind}", closure.kind());
        }
    }
}

#[test]
fn gradient_is_that_of_the_interpolated_density() {
    let walls = wall::Walls::new(kernel(KernelKind::Spiky), |d| plane::density(KernelKind::Spiky, d), None);
    for d in distances(-1.9, 0.99) {
        let at = |d: f64| walls.plane.at(d)[0];
        let difference = (at(d + 1e-6)[0] - at(d - 1e-6)[0]) / 2e-6;
        assert!((at(d)[1] - difference).abs() < 1e-7, "at {d}");
    }
}

#[test]
fn beyond_reach_there_is_nothing() {
    for kind in ClosureKind::ALL {
        let closure = Closure::new(kind, kernel(KernelKind::CubicSpline), PARTICLE);
        let (boundary, position) = wall(RADIUS);
        assert_eq!(closure.density(&boundary, position), None);
        let (boundary, position) = wall_for(kind, 0.02);
        assert_eq!(closure.density(&Surface { volume: 0.0, ..boundary }, position), None);
        assert_eq!(closure.density(&Surface { distance: f64::NAN, ..boundary }, position), None);
        assert!(closure.density(&boundary, position).is_some());
    }
}

#[test]
fn lattice_rests_in_layers() {
    let spacing = 2.0 * PARTICLE;
    for kind in KernelKind::ALL {
        let (kernel, closure) = (kernel(kind), Closure::new(ClosureKind::Lattice, kernel(kind), PARTICLE));
        // The full lattice; of a column's layers 0, 1, .. at rp, 3 rp, .. above the wall the fluid's share at layer n.
        let sum = |layers: std::ops::RangeInclusive<i32>| {
            let mut sum = (0.0, 0.0);
            for (i, j) in (-3..=3).flat_map(|i| (-3..=3).map(move |j| (i, j))) {
                for away in layers.clone().map(|k| spacing * DVec3::new(i.into(), j.into(), (-k).into())) {
                    let distance = away.length();
                    let along = if distance > 0.0 { away.z / distance } else { 0.0 };
                    sum.0 += spacing.powi(3) * kernel.value(distance);
                    sum.1 += spacing.powi(3) * kernel.derivative(distance) * along;
                }
            }
            sum
        };
        let full = sum(-4..=4).0;
        if kind == KernelKind::CubicSpline {
            assert!((full - 1.0).abs() < 2e-4, "{full}");
        }
        for layer in 0..3 {
            let fluid = sum(-layer..=4);
            let (boundary, position) = wall(f64::from(2 * layer + 1) * PARTICLE);
            let at = closure.density(&boundary, position);
            let (density, slope) = at.map_or((0.0, 0.0), |at| (at.density, at.gradient.z));
            assert!((fluid.0 + density - full).abs() < 1e-7, "{kind} {layer}: {}", fluid.0 + density - full);
            assert!((fluid.1 + slope).abs() < 1e-4, "{kind} {layer}: {} {slope}", fluid.1);
        }
    }
}

#[test]
fn fine_lattice_is_a_continuum() {
    for kind in KernelKind::ALL {
        for d in distances(0.0, 1.0) {
            let [value, slope] = lattice::density(kind, 1.0 / 24.0, d).unwrap();
            let [exact, exact_slope] = plane::density(kind, d);
            assert!(
                (value - exact).abs() < 4e-3 && (slope - exact_slope).abs() < 4e-2,
                "{kind} at {d}: {value} {exact}"
            );
        }
    }
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        assert_eq!(lattice::density(KernelKind::Poly6, wrong, 0.1), None);
    }
}

/// Density as a function of place for any field of volumes, against the gradient that is returned.
#[test]
fn true_gradient_is_that_of_the_density() {
    let normal = DVec3::new(0.0, 0.6, 0.8);
    for closure in
        ClosureKind::ALL[2..].iter().map(|&it| Closure::new(it, kernel(KernelKind::WendlandC2), PARTICLE))
    {
        let cubes = (closure.kind().map_radius(RADIUS) / RADIUS).powi(3);
        let volume = cubes * DVec3::new(0.002, -0.001, -0.009);
        for (d, v) in [(0.012, 0.0017), (0.04, 0.0008), (0.07, 0.0006), (-0.01, 0.0018), (0.03, 0.0013)] {
            let at = |shift: DVec3| {
                let surface = Surface {
                    distance: d + normal.dot(shift),
                    normal,
                    closest_point: DVec3::ZERO,
                    volume: cubes * v + volume.dot(shift),
                };
                closure.density(&SurfaceWithGradient { surface, volume_gradient: volume }, shift).unwrap()
            };
            let exact = at(DVec3::ZERO).gradient;
            for axis in DVec3::AXES {
                let difference = (at(1e-6 * axis).density - at(-1e-6 * axis).density) / 2e-6;
                assert!(
                    (exact.dot(axis) - difference).abs() < 1e-4,
                    "{} at {d}: {exact} {difference}",
                    closure.kind()
                );
            }
        }
    }
}

#[test]
fn mirror_is_the_images_density_at_a_flat_wall() {
    for kind in KernelKind::ALL {
        for particle in [0.02, PARTICLE, 0.04] {
            let closure = Closure::new(ClosureKind::Mirror, kernel(kind), particle);
            let mirror = mirror::Mirror::new(kind, Dimension::Three, particle / RADIUS);
            let map_radius = ClosureKind::Mirror.map_radius(RADIUS);
            for d in distances(-0.12, 0.49) {
                let (boundary, position) = wall_for(ClosureKind::Mirror, d * RADIUS);
                let slope = plane::volume(d * RADIUS / map_radius)[1] * map_radius.powi(2);
                let [value, exact] = mirror.density(d);
                let slack = if d < 0.0 { [5e-4, 0.1] } else { [2e-5, 0.02] };
                let near = SurfaceWithGradient { surface: boundary, volume_gradient: slope * DVec3::Z };
                let full = closure.density(&near, position);
                let simple = closure.density(&boundary, position);
                for at in [full, simple].map(|at| at.map_or([0.0; 2], |at| [at.density, at.gradient.z])) {
                    assert!((at[0] - value).abs() < slack[0], "{kind} {particle} at {d}: {} {value}", at[0]);
                    assert!(
                        (at[1] * RADIUS - exact).abs() < slack[1],
                        "{kind} at {d}: {} {exact}",
                        at[1] * RADIUS
                    );
                }
            }
        }
    }
}

/// A lattice whose first layer is at rp: the image fills it up, and pushes it as much as the fluid does under equal
/// pressures, which counts twice between particles and once from the wall.
#[test]
fn mirror_holds_the_first_layer_at_a_particle_radius() {
    let spacing = 2.0 * PARTICLE;
    let (mut density, mut slope) = (0.0, 0.0);
    for (i, j, k) in (0..343).map(|n| (n % 7 - 3, n / 7 % 7 - 3, n / 49)) {
        let away = spacing * DVec3::new(f64::from(i), f64::from(j), f64::from(k));
        let distance = away.length();
        let kernel = kernel(KernelKind::CubicSpline);
        density += spacing.powi(3) * kernel.value(distance);
        if distance > 0.0 {
            slope -= spacing.powi(3) * kernel.derivative(distance) * away.z / distance;
        }
    }
    let closure = Closure::new(ClosureKind::Mirror, kernel(KernelKind::CubicSpline), PARTICLE);
    // The wall stands back by a fortieth of rp.
    let at = at_wall(&closure, 0.975 * PARTICLE);
    assert!((density + at.density - 1.0).abs() < 1e-3, "{density} {}", at.density);
    assert!((2.0 * slope / -at.gradient.z - 1.0).abs() < 0.03, "{slope} {}", at.gradient.z);
}

#[test]
fn mirror_knows_a_flat_walls_wide_volume() {
    let closure = Closure::new(ClosureKind::Mirror, kernel(KernelKind::CubicSpline), PARTICLE);
    for d in distances(-0.49, 0.49) {
        let volume = closure.volume(&wall_for(ClosureKind::Mirror, d * RADIUS).0);
        let exact = plane::volume(d)[0] * RADIUS.powi(3);
        if d <= 0.25 {
            assert!((volume / exact - 1.0).abs() < 1e-5, "at {d}: {volume} {exact}");
        } else {
            assert!(volume < exact && volume > 0.0, "at {d}: {volume} {exact}");
        }
    }
    assert!(closure.volume(&wall_for(ClosureKind::Mirror, 0.0499 * RADIUS * 10.0).0) < 1e-7);
    let wedge = Closure::new(ClosureKind::Wedge, kernel(KernelKind::CubicSpline), PARTICLE);
    assert_eq!(wedge.volume(&wall(0.02).0), wall(0.02).0.volume);
}

#[test]
fn half_plane_area_is_its_integral() {
    let disc = std::f64::consts::PI;
    assert!((plane::area(-1.5)[0] - disc).abs() < 1e-14 && plane::area(-1.5)[1] == 0.0);
    assert!((plane::area(2.5)[0]).abs() < 1e-14);
    for d in distances(-2.0, 2.2).step_by(10) {
        const STEPS: u32 = 2_000;
        let strip = |n: u32| {
            let t = disc * ((f64::from(n) + 0.5) / f64::from(STEPS) - 0.5);
            2.0 * t.cos().powi(2) * plane::extension(d + t.sin())
        };
        let slow = (0..STEPS).map(strip).sum::<f64>() * disc / f64::from(STEPS);
        assert!((plane::area(d)[0] - slow).abs() < 1e-6, "{d}: {} {slow}", plane::area(d)[0]);
        let difference = (plane::area(d + 1e-6)[0] - plane::area(d - 1e-6)[0]) / 2e-6;
        assert!((plane::area(d)[1] - difference).abs() < 1e-6, "{d}");
    }
}

/// The image of lines of particles in the plane: the kernel summed along them, and its slope.
#[test]
fn image_in_the_plane_is_the_sum_over_lines() {
    for kind in KernelKind::ALL {
        let kernel = Kernel::in_plane(kind, RADIUS);
        let closure = Closure::new(ClosureKind::Mirror, kernel, PARTICLE);
        let map_radius = ClosureKind::Mirror.map_radius(RADIUS);
        let images = |d: f64| {
            const STEPS: i32 = 4_000;
            let along = |n: i32| 1.2 * RADIUS * f64::from(n) / f64::from(STEPS);
            let line = |z: f64| {
                let sum: f64 = (-STEPS..=STEPS).map(|n| kernel.value(z.hypot(along(n)))).sum();
                2.0 * PARTICLE * sum * 1.2 * RADIUS / f64::from(STEPS)
            };
            (0..2).map(|layer| line(2.0 * d + 2.0 * PARTICLE * f64::from(layer))).sum::<f64>()
        };
        for part in [0.6, 0.8, 1.0, 1.3, 1.6] {
            let d = part * PARTICLE;
            let [area, slope] = plane::area(d / map_radius);
            let (volume, slope) = (area * map_radius * map_radius, slope * map_radius);
            let boundary = Surface { distance: d, normal: DVec3::Y, closest_point: DVec3::ZERO, volume };
            let near = SurfaceWithGradient { surface: boundary, volume_gradient: slope * DVec3::Y };
            let found = closure.density(&near, d * DVec3::Y).unwrap();
            let exact = images(d);
            assert!(
                (found.density - exact).abs() < 2e-3 * exact + 1e-5,
                "{kind} at {part}: {} {exact}",
                found.density
            );
            let slope = (images(d + 1e-5) - images(d - 1e-5)) / 2e-5;
            let error = (found.gradient - slope * DVec3::Y).length();
            assert!(error < 0.02 * slope.abs() + 0.02, "{kind} at {part}: {} {slope}", found.gradient);
        }
    }
}

/// The closed form that maps store the difference from, by the integral over the ball's slices, whose rule is exact.
#[test]
fn closed_form_of_a_flat_wall_is_that_of_the_integral() {
    let flat = crate::layout::FlatWall::new(1.0, 4.0 / 3.0 * std::f64::consts::PI);
    for n in -100..=200 {
        let q = 0.01 * f64::from(n);
        let [value, slope] = plane::volume(q);
        assert!((flat.volume(q) - value).abs() < 1e-13, "{q}: {} {value}", flat.volume(q));
        assert!((flat.slope(q) - slope).abs() < 3e-13, "{q}: {} {slope}", flat.slope(q));
    }
}
