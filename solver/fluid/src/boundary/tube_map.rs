//! Boundaries by distance and curvature at the closest point, the idea of Nogina and Sellan 2026, *Tube Maps: Fast SPH
//! Boundary Handling in Tubular Coordinates*. The paper's own formulas were not at hand; these are derived here.
//!
//! The solid is a stack of surfaces parallel to its own. Seen from a particle at distance d, one at distance z >= d
//! is nearest straight below, and a point of it at u along a principal direction has the squared distance z^2 + u^2 /
//! (1 - h z) to lowest order, h being the curvature of the parallel surface through the particle itself. So the
//! kernel over it is that over a plane, W_1, times the root of the area that is left:
//! ```text
//! rho_B / rho_0 = integral from d - e to r of gamma(d - z) W_1(|z|) sqrt((1 - h_1 z) (1 - h_2 z)) dz
//! gamma(Phi) = 1 - Phi / e
//! W_1(z) = 2 pi integral from z to r of W(s) s ds
//! (1 - h_1 z) (1 - h_2 z) = 1 - 2 H z + K z^2        area element of parallel surfaces
//! ```
//! gamma, and its length e, are those of density maps (Bender et al. 2020, Eq. 11; [`super::density_map`]): both
//! methods integrate the same. Exact for half spaces, for hollows, and for balls whose centre is r or more from the
//! particle; too much for smaller ones, whose far side the kernel passes; of cylinders to first order. The gradient
//! is along the normal, where dh/dd = -h^2.
//!
//! Curvatures are the second derivatives of the map's distance along the surface, by differences. Of the two sides
//! the smaller rise counts, and all the less the less straight the distance rises along the normal: where probes look
//! past an edge or into a corner, the face below the particle is taken alone, without curvature. (With the curvatures
//! that differences see in the corners of a box, water at rest in it boils.)
//!
//! One point of the surface is all that is seen: in a corner one wall of two.

use super::density_map::EXTENSION;
use super::{Contact, Pairing, Scratch};
use volmap_runtime::{DVec3, Kernel, KernelKind, Sample, Surface, SurfaceWithGradient};

/// Step of the differences in support radii: a map's cell as scenes bake it.
const STEP: f64 = 0.25;
/// Differences for each particle.
const PROBES: usize = 8;
/// Slope of the distance along the normal, out or in, from which on curvatures count, and count in full: 1 where it
/// is a distance to one smooth surface, 0.7 on the bisector of a corner.
const STRAIGHT: [f64; 2] = [0.95, 0.99];
/// Curvatures beyond this many 1/r count as this: edges are no tubes.
const MOST_CURVED: f64 = 2.0;

/// Adds the contacts of a chunk.
pub(super) fn touch(pairing: Pairing, kernel: &Kernel, scratch: &mut Scratch, contacts: &mut Vec<Contact>) {
    let Scratch { samples, points, values, .. } = scratch;
    let radius = kernel.support_radius();
    points.clear();
    let all = || samples.iter().zip(pairing.positions);
    let near =
        || all().enumerate().filter_map(|(i, (sample, &x))| in_reach(sample, radius).map(|n| (i, x, n)));
    for (_, position, boundary) in near() {
        points.extend(probes(boundary.normal, STEP * radius).map(|offset| position + offset));
    }
    pairing.map().sample_batch(points, values);
    for ((within, _, boundary), values) in near().zip(values.chunks_exact(PROBES)) {
        let distances: [f64; PROBES] = std::array::from_fn(|n| values[n].distance);
        let curvatures = curvatures(boundary.distance, &distances, STEP * radius).map(|h| h * radius);
        let [density, slope] = density(kernel.kind(), boundary.distance / radius, curvatures);
        let gradient = slope / radius * boundary.normal;
        contacts.push(pairing.contact(within, density, gradient, boundary.closest_point));
    }
}

fn in_reach(sample: &Sample<SurfaceWithGradient>, radius: f64) -> Option<Surface> {
    sample.near().map(|near| near.surface).filter(|near| near.distance < (1.0 + EXTENSION) * radius)
}

/// Both ways along two tangents, their diagonal, and the normal.
fn probes(normal: DVec3, step: f64) -> [DVec3; PROBES] {
    let (a, b) = normal.try_normalize().map_or((DVec3::X, DVec3::Y), |n| n.any_orthonormal_pair());
    let diagonal = (a + b) * 0.5_f64.sqrt();
    [a, -a, b, -b, diagonal, -diagonal, normal, -normal].map(|way| step * way)
}

/// Principal curvatures (1/m) of the surface of equal distance through a point, positive where it bends away; from the
/// distances there and at its probes. A ball's are exact.
fn curvatures(at: f64, probes: &[f64; PROBES], step: f64) -> [f64; 2] {
    if !probes.iter().all(|distance| distance.is_finite()) {
        return [0.0; 2];
    }
    let slope = (probes[6] - at).min(at - probes[7]) / step;
    let part = ((slope - STRAIGHT[0]) / (STRAIGHT[1] - STRAIGHT[0])).clamp(0.0, 1.0);
    let along = |n: usize| {
        let [a, b] = [probes[2 * n] - at, probes[2 * n + 1] - at];
        let rise = if a * b <= 0.0 { 0.0 } else { a.abs().min(b.abs()).copysign(a) };
        2.0 * rise / (step * step - rise * rise)
    };
    let [a, b, diagonal] = [along(0), along(1), along(2)];
    let (mean, mixed) = (0.5 * (a + b), diagonal - 0.5 * (a + b));
    let spread = (0.5 * (a - b)).hypot(mixed);
    [part * (mean - spread), part * (mean + spread)]
}

/// Gauss and Legendre's rule of ten points: nodes and weights of [0, 1], mirrored.
const RULE: [[f64; 2]; 5] = [
    [0.013_046_735_741_414_14, 0.033_335_672_154_344_07],
    [0.067_468_316_655_507_73, 0.074_725_674_575_290_3],
    [0.160_295_215_850_487_8, 0.109_543_181_257_991],
    [0.283_302_302_935_376_4, 0.134_633_359_654_998_2],
    [0.425_562_830_509_184_4, 0.147_762_112_357_376_4],
];

/// rho_B / rho_0 and its derivative by d, at distance d with curvatures h; lengths in support radii.
pub fn density(kernel: KernelKind, d: f64, curvatures: [f64; 2]) -> [f64; 2] {
    let [h, k] = curvatures.map(|h| h.clamp(-MOST_CURVED, MOST_CURVED));
    let low = (d - EXTENSION).max(-1.0);
    let at = |z: f64| {
        let [a, b] = [(1.0 - h * z).max(0.0), (1.0 - k * z).max(0.0)];
        [a, b, (a * b).sqrt()]
    };
    let mut sum = [0.0; 2];
    // The kernel is made of two pieces or one.
    for piece in [-1.0_f64, -0.5, 0.0, 0.5] {
        let begin = piece.max(low);
        let width = piece + 0.5 - begin;
        for [node, weight] in RULE.into_iter().flat_map(|[x, w]| [[x, w], [1.0 - x, w]]) {
            if width <= 0.0 {
                break;
            }
            let z = begin + width * node;
            let ([a, b, root], part) = (at(z), weight * width * kernel.sheet_integral(z.abs()));
            let gamma = 1.0 + (z - d) / EXTENSION;
            sum[0] += part * gamma * root;
            sum[1] -= part * root / EXTENSION;
            // Of the root, by d, at fixed z.
            if root > 1e-3 {
                sum[1] += 0.5 * part * gamma * z * root * (h * h / a + k * k / b);
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Midpoint rule.
    fn integral(low: f64, high: f64, steps: u32, f: impl Fn(f64) -> f64) -> f64 {
        let width = (high - low) / f64::from(steps);
        (0..steps).map(|n| f(low + (f64::from(n) + 0.5) * width)).sum::<f64>() * width
    }

    /// The density of a ball (radius R > 0) or of all around a hollow (R < 0) at distance d: Eq. 9 of Bender et al.
    /// 2020 over shells around the particle and their rings.
    fn exact(kernel: KernelKind, radius: f64, d: f64) -> f64 {
        let away = radius + d;
        let gamma = |s: f64, cosine: f64| {
            let from_centre = (away * away + s * s + 2.0 * away * s * cosine).max(0.0).sqrt();
            let phi = radius.signum() * from_centre - radius;
            if phi < EXTENSION { 1.0 - phi / EXTENSION } else { 0.0 }
        };
        let shell = |s: f64| 0.5 * integral(-1.0, 1.0, 800, |cosine| gamma(s, cosine));
        integral(0.0, 1.0, 400, |s| 4.0 * PI * s * s * kernel.unit_value(s) * shell(s))
    }

    #[test]
    fn sheets_are_integrals_of_the_kernel() {
        for kernel in KernelKind::ALL {
            for z in [0.0, 0.2, 0.5, 0.8, 0.99] {
                let sum = integral(z, 1.0, 2000, |s| 2.0 * PI * kernel.unit_value(s) * s);
                assert!((kernel.sheet_integral(z) - sum).abs() < 1e-5, "{kernel} {z}");
            }
            assert!((integral(0.0, 1.0, 2000, |z| 2.0 * kernel.sheet_integral(z)) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn balls_and_hollows_are_exact() {
        for kernel in KernelKind::ALL {
            for radius in [1.0, 4.0, -1.5, -4.0, 1e6, -1e6] {
                for d in [-0.2, 0.05, 0.25, 0.5, 0.8] {
                    if radius > 0.0 && radius + d < 1.0 {
                        continue;
                    }
                    let h = 1.0 / (radius + d);
                    let [value, _] = density(kernel, d, [h, h]);
                    let exact = exact(kernel, radius, d);
                    assert!(
                        (value - exact).abs() < 1e-4 * (1.0 + exact),
                        "{kernel} {radius} {d}: {value} {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_value_along_the_normal() {
        for kappa in [[0.0, 0.0], [0.7, 0.7], [0.7, 0.0], [-0.5, 0.3]] {
            for d in [0.1, 0.3, 0.6] {
                let at = |d: f64| density(KernelKind::CubicSpline, d, kappa.map(|k| k / (1.0 + k * d)));
                let difference = (at(d + 1e-5)[0] - at(d - 1e-5)[0]) / 2e-5;
                assert!((at(d)[1] - difference).abs() < 1e-6, "{kappa:?} {d}: {} {difference}", at(d)[1]);
            }
        }
    }

    #[test]
    fn cylinders_are_close() {
        // Lines parallel to the cylinder's axis, at (u, angle) from the particle's.
        let exact = |radius: f64, d: f64| {
            let line = |u: f64| {
                let height = (1.0 - u * u).max(0.0).sqrt();
                integral(0.0, height, 40, |w| 2.0 * KernelKind::CubicSpline.unit_value(u.hypot(w)))
            };
            let ring = |u: f64| {
                integral(0.0, PI, 400, |angle: f64| {
                    let away = radius + d;
                    let phi = (away * away + u * u + 2.0 * away * u * angle.cos()).sqrt() - radius;
                    if phi < EXTENSION { 2.0 * (1.0 - phi / EXTENSION) } else { 0.0 }
                })
            };
            integral(0.0, 1.0, 200, |u| u * line(u) * ring(u))
        };
        for (radius, bound) in [(4.0, 2e-3), (1.0, 2e-2), (0.5, 0.1)] {
            for d in [0.1, 0.25, 0.5] {
                let [value, _] = density(KernelKind::CubicSpline, d, [0.0, 1.0 / (radius + d)]);
                let ratio = value / exact(radius, d);
                assert!((ratio - 1.0).abs() < bound, "{radius} {d}: {ratio}");
            }
        }
    }

    #[test]
    fn curvatures_of_spheres_cylinders_and_edges() {
        let (at, step) = (DVec3::new(0.3, 0.8, -0.2), 0.2);
        let measured = |phi: &dyn Fn(DVec3) -> f64, normal: DVec3| {
            curvatures(phi(at), &probes(normal, step).map(|offset| phi(at + offset)), step)
        };
        let [a, b] = measured(&|x| x.length(), at.normalize());
        assert!((a * at.length() - 1.0).abs() < 1e-9 && (b * at.length() - 1.0).abs() < 1e-9);
        let axis = |x: DVec3| x.truncate().length();
        let [a, b] = measured(&axis, at.with_z(0.0).normalize());
        assert!(a.abs() < 0.05 && (b * axis(at) - 1.0).abs() < 0.05, "{a} {b}");
        // Above a floor, beside a wall that probes reach; and on the bisector.
        assert_eq!(measured(&|x| x.y.min(x.x + 0.55), DVec3::Y), [0.0; 2]);
        let bisector = DVec3::new(0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0);
        assert_eq!(measured(&|x| x.y.min(x.x + 0.5), bisector).map(f64::abs), [0.0; 2]);
    }

    #[test]
    fn densities_of_baked_balls_and_hollows() {
        let radius = 0.1;
        let kernel = Kernel::new(KernelKind::CubicSpline, radius);
        for (size, container, bound) in [(1.0, false, 0.03), (2.0, false, 0.02), (3.0, true, 0.03)] {
            let mesh = crate::shapes::ball(size * radius, 5);
            let cell = 0.25 * radius;
            let shape = crate::shapes::baked_finely(mesh, radius, cell, container).unwrap();
            let at = DVec3::new(0.6, -0.64, 0.48);
            for d in [0.1, 0.25, 0.5, 0.75] {
                let side = if container { -1.0 } else { 1.0 };
                let place = (size + side * d) * radius * at;
                let near = shape.map.sample(place).near().unwrap();
                let step = STEP * radius;
                let probed =
                    probes(near.normal, step).map(|offset| shape.map.values(place + offset).distance);
                let h = curvatures(near.distance, &probed, step).map(|h| h * radius);
                let [value, _] = density(kernel.kind(), near.distance / radius, h);
                let exact = exact(kernel.kind(), side * size, d);
                assert!(
                    (value - exact).abs() < bound * exact.max(0.1),
                    "{size} {container} {d}: {value} {exact} {h:?}"
                );
            }
        }
    }
}
