//! Closures against the exact density of solids with known distances.

mod shapes;

use shapes::*;
use volmap_runtime::{
    Closure, ClosureError, ClosureKind, DVec3, Kernel, KernelKind, Surface, SurfaceWithGradient,
};

const STEPS: i32 = 64;

fn kernel() -> Kernel {
    Kernel::new(KernelKind::CubicSpline, 1.0)
}

fn closure(kind: ClosureKind) -> Closure {
    closure_of(kind, kernel(), PARTICLE)
}

/// The least and the largest ratio of a closure's density to the exact one.
fn range(cases: &[Case], density: impl Fn(&Case) -> f64) -> (f64, f64) {
    let ratios = cases.iter().map(|case| density(case) / case.density);
    ratios.fold((f64::INFINITY, 0.0), |(low, high), ratio| (ratio.min(low), ratio.max(high)))
}

fn plain(kind: ClosureKind) -> impl Fn(&Case) -> f64 {
    let closure = closure(kind);
    move |case| closure.density(&case.surface, case.position).unwrap().density
}

/// As printed where these closures were first measured: cubic spline, rp = r / 4, d = 0.25 to 2.5 rp.
#[test]
fn densities_have_the_published_ratios() {
    let table = [
        (plane(), [(18.0, 41.0), (3.7, 12.0), (1.00, 1.00)]),
        (ball("ball 4 r", 4.0), [(18.0, 43.0), (3.8, 12.0), (1.00, 1.01)]),
        (bowl("bowl 4 r", 4.0), [(18.0, 39.0), (3.7, 12.0), (1.00, 1.01)]),
        (ball("ball r", 1.0), [(20.0, 50.0), (4.0, 14.0), (1.01, 1.05)]),
        (ball("ball r/2", 0.5), [(22.0, 61.0), (4.0, 16.0), (1.05, 1.17)]),
        (concave_edge(), [(15.0, 34.0), (3.0, 9.0), (0.85, 1.02)]),
        (concave_corner(), [(0.0, f64::INFINITY), (0.0, f64::INFINITY), (0.73, 0.95)]),
        (convex_edge(), [(29.0, 114.0), (6.0, 27.0), (1.4, 2.3)]),
        (plate("plate r/4", 0.25), [(24.0, 41.0), (5.0, 13.0), (1.01, 1.25)]),
    ];
    let kinds = [ClosureKind::Paper, ClosureKind::Offset, ClosureKind::Calibrated];
    for (shape, bounds) in table {
        let cases = cases(&shape, &kernel(), STEPS);
        for (kind, bounds) in kinds.into_iter().zip(bounds) {
            let (low, high) = range(&cases, plain(kind));
            // Two printed digits, and the oracle's error far from the wall.
            let slack = if kind == ClosureKind::Calibrated { 0.015 } else { 0.06 };
            let within = low > bounds.0 * (1.0 - slack) && high < bounds.1 * (1.0 + slack);
            assert!(within, "{}, {kind}: {low:.3} to {high:.3}, not {bounds:?}", shape.name);
        }
    }
}

#[test]
fn wedge_is_right_around_convex_edges() {
    let probing = closure(ClosureKind::Wedge);
    let probed = |shape: &Shape, case: &Case| {
        probing.density_probing(&case.surface, case.position, &shape.phi).unwrap().density
    };
    for shape in [convex_edge(), around_convex_edge()] {
        let cases = cases(&shape, &kernel(), STEPS);
        for (low, high) in
            [range(&cases, plain(ClosureKind::Wedge)), range(&cases, |case| probed(&shape, case))]
        {
            assert!(low > 0.94 && high < 1.07, "{}: {low} to {high}", shape.name);
        }
        assert!(range(&cases, plain(ClosureKind::Calibrated)).1 > 1.4, "{}", shape.name);
    }
    // With the second look balls stay what they are to the calibrated closure, and so does what isn't convex.
    let others = [plane(), ball("ball 4 r", 4.0), ball("ball r", 1.0), ball("ball r/2", 0.5), concave_edge()];
    for shape in others {
        let cases = cases(&shape, &kernel(), STEPS);
        let (low, high) = range(&cases, |case| probed(&shape, case));
        let expected = range(&cases, plain(ClosureKind::Calibrated));
        assert!((low - expected.0).abs() < 0.01 && (high - expected.1).abs() < 0.01, "{}", shape.name);
    }
}

/// Root mean square of the gradients' errors over the flat wall's slope: along the normal, and the true one.
fn gradient_errors(shape: &Shape, kind: ClosureKind) -> [f64; 2] {
    let (wall, closure, kernel) = (closure(ClosureKind::Calibrated), closure(kind), kernel());
    let mut sums = [0.0; 2];
    let mut count = 0.0;
    for d in [0.5, 1.0, 2.0].map(|d| PARTICLE * d) {
        for x in (shape.places)(d) {
            let (_, volume) = integrate(&shape.phi, &kernel, x, 48);
            let surface = surface(&shape.phi, x, volume);
            let (exact, volume_gradient) = gradients(shape, &kernel, x, 48);
            let flat = Surface { volume: integrate(&|x| x.z, &kernel, d * DVec3::Z, 48).1, ..surface };
            let scale = wall.density(&flat, x).unwrap().gradient.length();
            let simple = closure.density(&surface, x).unwrap().gradient;
            let near = SurfaceWithGradient { surface, volume_gradient };
            let full = closure.density(&near, x).unwrap().gradient;
            sums[0] += (simple - exact).length_squared() / (scale * scale);
            sums[1] += (full - exact).length_squared() / (scale * scale);
            count += 1.0;
        }
    }
    sums.map(|sum: f64| (sum / count).sqrt())
}

#[test]
fn true_gradient_is_nearer_to_the_exact_one_at_edges() {
    for (shape, kind) in [
        (along_concave_edge(), ClosureKind::Calibrated),
        (around_convex_edge(), ClosureKind::Calibrated),
        (around_convex_edge(), ClosureKind::Wedge),
    ] {
        let [simple, full] = gradient_errors(&shape, kind);
        println!("{}, {kind}: {simple:.3} {full:.3}", shape.name);
        assert!(full < 0.9 * simple, "{}, {kind}: {simple} {full}", shape.name);
    }
}

/// Where walls meet at right angles, closure `mirror` must fill up what a lattice of particles lacks there.
#[test]
fn mirror_fills_edges_and_corners() {
    // In support radii of the map: those of the kernel are four times as long.
    let particle = 1.0;
    let kernel = Kernel::new(KernelKind::CubicSpline, 4.0);
    let mirror = closure_of(ClosureKind::Mirror, kernel, particle);
    for (count, slack) in [(1, 2e-3), (2, 0.025), (3, 0.045)] {
        // Walls in the last `count` axes.
        let phi = |x: DVec3| x.to_array()[3 - count..].iter().copied().fold(f64::INFINITY, f64::min);
        // Walls stand back by a fortieth of rp.
        let x = 0.975 * particle * DVec3::ONE;
        let (_, volume) = integrate(&phi, &Kernel::new(KernelKind::CubicSpline, 1.0), x, STEPS);
        let wall = mirror.density(&surface(&phi, x, volume), x).unwrap().density;
        let from = |axis: usize| if axis < 3 - count { -3 } else { 0 };
        let steps = (0..343).map(|n| [n % 7 - 3, n / 7 % 7 - 3, n / 49 - 3]);
        let fluid: f64 = steps
            .filter(|step| (0..3).all(|axis| step[axis] >= from(axis)))
            .map(|step| 8.0 * kernel.value(2.0 * DVec3::from(step.map(f64::from)).length()))
            .sum();
        assert!((fluid + wall - 1.0).abs() < slack, "{count} walls: {fluid} + {wall}");
    }
}

/// A closure and a map that don't belong together are refused, with the numbers that would.
#[test]
fn maps_of_another_radius_are_refused() {
    let kernel = Kernel::new(KernelKind::CubicSpline, 0.1);
    for kind in ClosureKind::ALL {
        let needed = kind.map_radius(0.1);
        // As near as single precision.
        assert!(map_of(f64::from(needed as f32)).closure(kind, kernel, 0.025).is_ok(), "{kind}");
        for found in [0.05, 0.0251, 0.1001] {
            let error = map_of(found).closure(kind, kernel, 0.025).unwrap_err();
            assert_eq!(error, ClosureError::MapRadius { kind, kernel_radius: 0.1, needed, found });
        }
    }
    let error = map_of(0.1).closure(ClosureKind::Mirror, kernel, 0.025).unwrap_err().to_string();
    let expected = "closure `mirror` with a kernel of support radius 0.1 m needs a map of support radius 0.025 m; \
                    this map's is 0.1 m";
    assert_eq!(error, expected);
    let closure = map_of(0.1).closure(ClosureKind::Wedge, kernel, 0.025).unwrap();
    assert!(closure.check(&map_of(0.1)).is_ok() && closure.check(&map_of(0.025)).is_err());
}

#[test]
fn what_is_no_length_or_of_another_dimension_is_refused() {
    let map = map_of(0.1);
    let kernel = Kernel::new(KernelKind::CubicSpline, 0.1);
    for found in [0.0, -0.025, f64::INFINITY, f64::NAN] {
        let error = map.closure(ClosureKind::Paper, kernel, found).unwrap_err();
        assert!(matches!(error, ClosureError::ParticleRadius { .. }), "{error}");
    }
    let in_plane = Kernel::in_plane(KernelKind::CubicSpline, 0.1);
    let error = map.closure(ClosureKind::Paper, in_plane, 0.025).unwrap_err();
    assert_eq!(error, ClosureError::Dimension { map: 3, kernel: 2 });
}
