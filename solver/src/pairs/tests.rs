//! Sums over neighbours against slow ones over all pairs, in f64.

use super::lanes::Plain;
use super::*;
use crate::fields::Discretization;
use crate::neighbours::tests::{Arranged, arrange, random, random_points};
use crate::neighbours::{CHUNK, Neighbours};
use volmap_runtime::{DVec3, Dimension, Kernel};

const RADIUS: f64 = 0.1;
const VOLUME: f64 = 1.25e-4;

/// A fluid, a dense clump, pairs in one place, and some alone.
fn cloud() -> Vec<DVec3> {
    let mut positions = random_points(900, 0.5, 1);
    positions.extend(random_points(60, 0.03, 2).iter().map(|x| *x + 0.8));
    positions.extend([DVec3::splat(0.31), DVec3::splat(0.31), DVec3::splat(-0.4), DVec3::new(2.0, 0.0, 0.0)]);
    positions
}

/// One quad for each particle, and one at rest.
fn field(count: usize, seed: u64) -> Vec<Quad> {
    let mut next = random(seed);
    let mut out: Vec<Quad> = (0..count).map(|_| [(); 4].map(|()| (2.0 * next() - 1.0) as f32)).collect();
    out.push([0.0; 4]);
    out
}

/// Laplacian and mean difference.
type Both = [[f32; 3]; 2];
/// What a kernel says of eight distances.
type UnitKernel = fn([f64; 8]) -> [[f32; 8]; 4];

struct Fluid {
    positions: Vec<DVec3>,
    neighbours: Neighbours,
    places: Vec<Quad>,
    velocities: Vec<Quad>,
}

fn fluid() -> Fluid {
    let Arranged { positions, mut fields, neighbours } = arrange(&cloud(), RADIUS);
    let velocities = field(positions.len(), 3);
    for (place, pressure) in fields.places.iter_mut().zip(field(positions.len(), 4)) {
        place[3] = pressure[3].abs();
    }
    fields.places[positions.len()][3] = 0.0;
    Fluid { positions, neighbours, places: fields.places, velocities }
}

impl Fluid {
    fn pairs(&self, kernel: KernelKind) -> Pairs<'_> {
        Discretization { kernel, support_radius: RADIUS, volume: VOLUME, dimension: Dimension::Three }
            .pairs(&self.places)
    }

    /// A sum of every particle, after its slopes.
    fn all<T: Copy + Default>(&self, kernel: KernelKind, sum: impl Fn(&mut Lists, &mut [T])) -> Vec<T> {
        let each = self.neighbours.chunks().iter().flat_map(|lists| {
            let (mut lists, count) = (lists.clone(), lists.len());
            self.pairs(kernel).density(&mut lists, &mut [Density::default(); CHUNK][..count]);
            let mut out = [T::default(); CHUNK];
            sum(&mut lists, &mut out[..count]);
            out[..lists.len()].to_vec()
        });
        each.collect()
    }

    /// For each particle the sum of `term` over the others (index, x_ij, V W, V grad W), and of its magnitude.
    fn slow(
        &self,
        kernel: KernelKind,
        term: impl Fn(usize, usize, DVec3, f64, DVec3) -> DVec3,
    ) -> Vec<(DVec3, f64)> {
        let kernel = Kernel::new(kernel, RADIUS);
        let sum = |i: usize| {
            let mut sum = (DVec3::ZERO, 0.0);
            for (j, other) in self.positions.iter().enumerate().filter(|(j, _)| *j != i) {
                let x = self.positions[i] - *other;
                let distance = x.length();
                let slope = x.normalize_or_zero() * kernel.derivative(distance);
                let term = term(i, j, x, VOLUME * kernel.value(distance), VOLUME * slope);
                sum = (sum.0 + term, sum.1 + term.length());
            }
            sum
        };
        (0..self.positions.len()).map(sum).collect()
    }

    fn velocity(&self, i: usize) -> DVec3 {
        vector([self.velocities[i][0], self.velocities[i][1], self.velocities[i][2]])
    }

    fn pressure(&self, i: usize) -> f64 {
        self.places[i][3].into()
    }
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Rounding of places, 1e-7 of 20 radii, changes terms by parts of 1e-5; those of close pairs by more.
fn assert_close(kernel: KernelKind, got: &[DVec3], wanted: &[(DVec3, f64)]) {
    assert_eq!(got.len(), wanted.len());
    for (i, (got, (wanted, size))) in got.iter().zip(wanted).enumerate() {
        let error = (*got - *wanted).length();
        assert!(error <= 1e-4 * size + 1e-7, "{kernel} at {i}: {got} {wanted}, terms {size}");
    }
}

#[test]
fn density_is_the_slow_one() {
    let fluid = fluid();
    for kernel in KernelKind::ALL {
        let got = fluid.all(kernel, |lists, out| fluid.pairs(kernel).density(lists, out));
        let own = VOLUME * Kernel::new(kernel, RADIUS).value(0.0);
        let scalars =
            |d: &Density| DVec3::new(f64::from(d.density) - own, f64::from(d.squares) * RADIUS * RADIUS, 0.0);
        let slow = fluid.slow(kernel, |_, _, _, value, slope| {
            DVec3::new(value, slope.length_squared() * RADIUS * RADIUS, 0.0)
        });
        // The particle itself is rounded, too.
        let slow: Vec<_> = slow.into_iter().map(|(sum, size)| (sum, size + 0.1 * own)).collect();
        assert_close(kernel, &got.iter().map(scalars).collect::<Vec<_>>(), &slow);
        let gradients: Vec<DVec3> = got.iter().map(|d| vector(d.gradient)).collect();
        assert_close(kernel, &gradients, &fluid.slow(kernel, |_, _, _, _, slope| slope));
        let alone = fluid.positions.iter().position(|x| *x == DVec3::new(2.0, 0.0, 0.0)).unwrap();
        assert_eq!((got[alone].gradient, got[alone].squares), ([0.0; 3], 0.0));
        assert!((f64::from(got[alone].density) / own - 1.0).abs() < 1e-5);
    }
}

#[test]
fn flux_is_the_slow_one() {
    let fluid = fluid();
    for kernel in KernelKind::ALL {
        let got = fluid.all(kernel, |lists, out| fluid.pairs(kernel).flux(lists, &fluid.velocities, out));
        let slow = fluid.slow(kernel, |i, j, _, _, slope| {
            DVec3::new((fluid.velocity(i) - fluid.velocity(j)).dot(slope), 0.0, 0.0)
        });
        assert_close(
            kernel,
            &got.iter().map(|x: &f32| DVec3::new((*x).into(), 0.0, 0.0)).collect::<Vec<_>>(),
            &slow,
        );
    }
}

#[test]
fn acceleration_is_the_slow_one_and_keeps_momentum() {
    let fluid = fluid();
    for kernel in KernelKind::ALL {
        let got = fluid.all(kernel, |lists, out| fluid.pairs(kernel).acceleration(lists, out));
        let got: Vec<DVec3> = got.into_iter().map(vector).collect();
        let slow = fluid.slow(kernel, |i, j, _, _, slope| -(fluid.pressure(i) + fluid.pressure(j)) * slope);
        assert_close(kernel, &got, &slow);
        let sizes: f64 = slow.iter().map(|(_, size)| size).sum();
        assert!(got.iter().sum::<DVec3>().length() < 1e-7 * sizes, "{kernel}");
    }
}

/// So the matrix of the solves is symmetric and has no negative eigenvalue: sum of P flux(u) = - sum of u a(P).
#[test]
fn flux_is_the_adjoint_of_the_acceleration() {
    let fluid = fluid();
    for kernel in KernelKind::ALL {
        let pairs = fluid.pairs(kernel);
        let accelerations: Vec<[f32; 3]> = fluid.all(kernel, |lists, out| pairs.acceleration(lists, out));
        let rates: Vec<f32> = fluid.all(kernel, |lists, out| pairs.flux(lists, &fluid.velocities, out));
        let (mut left, mut right, mut size) = (0.0, 0.0, 0.0);
        for (i, (rate, acceleration)) in rates.iter().zip(accelerations).enumerate() {
            let work = fluid.velocity(i).dot(vector(acceleration));
            left += fluid.pressure(i) * f64::from(*rate);
            right -= work;
            size += work.abs();
        }
        assert!((left - right).abs() < 1e-6 * size, "{kernel}: {left} {right}");
    }
}

#[test]
fn viscosity_is_the_slow_one_and_keeps_momentum() {
    let fluid = fluid();
    for kernel in KernelKind::ALL {
        let got =
            fluid.all(kernel, |lists, out| fluid.pairs(kernel).viscosity(lists, &fluid.velocities, out));
        let part = |n: usize| got.iter().map(|it: &[[f32; 3]; 2]| vector(it[n])).collect::<Vec<_>>();
        let apart = |i, j| fluid.velocity(i) - fluid.velocity(j);
        let laplacian = fluid.slow(kernel, |i, j, x, _, slope| {
            10.0 * apart(i, j).dot(x) / (x.length_squared() + 0.01 * RADIUS * RADIUS) * slope
        });
        let mean = fluid.slow(kernel, |i, j, _, value, _| -value * apart(i, j));
        for (got, slow) in [(part(0), laplacian), (part(1), mean)] {
            assert_close(kernel, &got, &slow);
            let sizes: f64 = slow.iter().map(|(_, size)| size).sum();
            assert!(got.iter().sum::<DVec3>().length() < 1e-7 * sizes, "{kernel}");
        }
    }
}

/// The Laplacian alone is that with the mean, to the bit; and a particle's own part is what it becomes if all others rest.
#[test]
fn laplacian_is_that_of_viscosity_and_knows_its_own_part() {
    let fluid = fluid();
    for kernel in KernelKind::ALL {
        let (pairs, field) = (fluid.pairs(kernel), &fluid.velocities);
        let alone: Vec<[f32; 3]> = fluid.all(kernel, |lists, out| pairs.laplacian(lists, field, out));
        let both: Vec<Both> = fluid.all(kernel, |lists, out| pairs.viscosity(lists, field, out));
        assert!(alone == both.iter().map(|it| it[0]).collect::<Vec<_>>(), "{kernel}");
        let got: Vec<Symmetric> = fluid.all(kernel, |lists, out| pairs.laplacian_own_part(lists, out));
        let own: Vec<DVec3> = got.iter().enumerate().map(|(i, m)| times(m, fluid.velocity(i))).collect();
        let slow = fluid.slow(kernel, |i, _, x, _, slope| {
            10.0 * fluid.velocity(i).dot(x) / (x.length_squared() + 0.01 * RADIUS * RADIUS) * slope
        });
        assert_close(kernel, &own, &slow);
    }
}

fn times(&[xx, yy, zz, xy, xz, yz]: &Symmetric, v: DVec3) -> DVec3 {
    DVec3::new(vector([xx, xy, xz]).dot(v), vector([xy, yy, yz]).dot(v), vector([xz, yz, zz]).dot(v))
}

/// Whatever this processor has, against [`Plain`].
#[test]
fn all_lanes_give_the_same_bits() {
    let fluid = fluid();
    fn plain(kernel: KernelKind, work: impl KernelWork) {
        WithKernel { kernel, work }.run::<Plain>();
    }
    for kernel in KernelKind::ALL {
        let pairs = fluid.pairs(kernel);
        let (field, velocities) = (&fluid.velocities[..], &fluid.velocities[..]);
        let (a, b): (Vec<Density>, Vec<Density>) = (
            fluid.all(kernel, |lists, out| pairs.density(lists, out)),
            fluid.all(kernel, |lists, out| plain(kernel, density::Work { pairs, lists, out })),
        );
        assert!(a == b, "density {kernel}");
        let (a, b): (Vec<f32>, Vec<f32>) = (
            fluid.all(kernel, |lists, out| pairs.flux(lists, field, out)),
            fluid.all(kernel, |lists, out| plain(kernel, flux::Work { pairs, lists, field, out })),
        );
        assert!(a == b, "flux {kernel}");
        let (a, b): (Vec<[f32; 3]>, Vec<[f32; 3]>) = (
            fluid.all(kernel, |lists, out| pairs.acceleration(lists, out)),
            fluid.all(kernel, |lists, out| plain(kernel, acceleration::Work { pairs, lists, out })),
        );
        assert!(a == b, "acceleration {kernel}");
        let (a, b): (Vec<Both>, Vec<Both>) = (
            fluid.all(kernel, |lists, out| pairs.viscosity(lists, velocities, out)),
            fluid.all(kernel, |lists, out| plain(kernel, viscosity::Work { pairs, lists, velocities, out })),
        );
        assert!(a == b, "viscosity {kernel}");
        let (a, b): (Vec<[f32; 3]>, Vec<[f32; 3]>) = (
            fluid.all(kernel, |lists, out| pairs.laplacian(lists, field, out)),
            fluid.all(kernel, |lists, out| plain(kernel, laplacian::Work { pairs, lists, field, out })),
        );
        assert!(a == b, "Laplacian {kernel}");
        let (a, b): (Vec<Symmetric>, Vec<Symmetric>) = (
            fluid.all(kernel, |lists, out| pairs.laplacian_own_part(lists, out)),
            fluid.all(kernel, |lists, out| plain(kernel, laplacian::OwnPart { pairs, lists, out })),
        );
        assert!(a == b, "Laplacian's own part {kernel}");
    }
}

/// A kernel's value and slope (dW/dq / q) at eight q, in units of the support radius.
fn unit<K: KernelLanes>(q: [f64; lanes::LANES]) -> [[f32; lanes::LANES]; 4] {
    let squares = Plain::load(&q.map(|q| (q * q) as f32));
    let (value, slope) = K::both(squares);
    let (norm, of_slope) = (Plain::splat(K::NORM), Plain::splat(K::NORM * K::SLOPE));
    [norm * value, norm * K::value(squares), of_slope * slope, of_slope * K::slope(squares)].map(Lanes::array)
}

#[test]
fn unit_kernels_are_the_runtimes() {
    let of: [(KernelKind, UnitKernel); 4] = [
        (KernelKind::CubicSpline, unit::<CubicSpline>),
        (KernelKind::WendlandC2, unit::<WendlandC2>),
        (KernelKind::Spiky, unit::<Spiky>),
        (KernelKind::Poly6, unit::<Poly6>),
    ];
    for (kind, lanes) in of {
        for n in 0..130 {
            let q: [f64; 8] = std::array::from_fn(|lane| 0.001 + f64::from(8 * n + lane as u32) * 0.001);
            let [value, other_value, slope, other_slope] = lanes(q);
            assert_eq!((value, slope), (other_value, other_slope));
            for lane in 0..8 {
                let (exact, derivative) = (kind.unit_value(q[lane]), kind.unit_derivative(q[lane]));
                let scale = kind.unit_value(0.0);
                assert!((f64::from(value[lane]) - exact).abs() < 1e-6 * scale, "{kind} at {}", q[lane]);
                let error = (f64::from(slope[lane]) * q[lane] - derivative).abs();
                assert!(error < 3e-6 * (derivative.abs() + scale), "{kind} at {}", q[lane]);
            }
        }
        let beyond = lanes([1.0, 1.0001, 2.0, 10.0, 1e3, 1e6, 1e12, 1e18]);
        assert!(beyond.as_flattened().iter().all(|&x| x == 0.0), "{kind}: {beyond:?}");
        assert!(lanes([0.0; 8]).as_flattened().iter().all(|x| x.is_finite()));
    }
}

/// u = (y^2, 0, 0) on a square lattice: its Laplacian is 2, of which Eq. 16's 0.01 r^2 takes some per cent.
#[test]
fn laplacian_in_the_plane_is_that_of_the_field() {
    let spacing = RADIUS / 8.0;
    let place = |n: i32| spacing * DVec3::new(f64::from(n % 41 - 20), f64::from(n / 41 - 20), 0.0);
    let points: Vec<DVec3> = (0..41 * 41).map(place).collect();
    let Arranged { positions, fields, neighbours } = arrange(&points, RADIUS);
    let square = |x: &DVec3| [(x.y * x.y) as f32, 0.0, 0.0, 0.0];
    let field: Vec<Quad> = positions.iter().map(square).chain([[0.0; 4]]).collect();
    for kernel in [KernelKind::CubicSpline, KernelKind::WendlandC2] {
        let volume = spacing * spacing * kernel.plane_thickness() * RADIUS;
        let with = Discretization { kernel, support_radius: RADIUS, volume, dimension: Dimension::Two };
        for lists in neighbours.chunks() {
            let (mut lists, count) = (lists.clone(), lists.len());
            let (mut densities, mut out) = ([Density::default(); CHUNK], [[0.0; 3]; CHUNK]);
            with.pairs(&fields.places).density(&mut lists, &mut densities[..count]);
            with.pairs(&fields.places).laplacian(&lists, &field, &mut out[..count]);
            for within in 0..count {
                if positions[lists.first + within].abs().max_element() > 11.5 * spacing {
                    continue;
                }
                assert!(
                    (densities[within].density - 1.0).abs() < 0.01,
                    "{kernel}: {}",
                    densities[within].density
                );
                let [x, y, z] = out[within];
                assert!((x / 2.0 - 0.95).abs() < 0.05 && y.abs() < 0.01 && z == 0.0, "{kernel}: {x} {y} {z}");
            }
        }
    }
}
