//! Pressure of the boundary at its contacts, p_b in Eq. 1 of Band et al. 2018, *MLS Pressure Boundaries for
//! Divergence-Free and Viscous SPH Fluids*:
//! ```text
//! a_i = .. - sum over contacts of (p_i / rho_i^2 + p_b / rho_0^2) grad rho_B
//! ```
//! - `own`: without the second term; forces are then the gradient of the boundary's density;
//! - `mirror`: p_b = p_i, Eq. 2, and Eq. 15 of Bender et al. 2020;
//! - `sph`: Eq. 3, after Adami et al. 2012: the mean of the fluid's pressures, and the weight of the fluid in between;
//! - `mls`: Eq. 4 to 16: the plane through the fluid's pressures, by moving least squares.
//!
//! The last two belong to sites, each with one pressure: boundary particles, or on maps, which both papers leave
//! open, the sample point of each particle and body. Neighbours are those of the sample point; the pressure is taken
//! behind it, in the middle of what the body adds to the particle's gradient (see `Contact::depth`). Negative
//! pressures are none.
//!
//! Both are linear in the fluid's pressures, with factors that its places alone give: they are computed once a step,
//! and an iteration of a solve adds up products. Unknowns are P = p / (rho_0 D^2), so p / rho_0 = P D^2.

use super::{Boundary, Contact, Method};
use crate::cells::Cells;
use crate::discretization::Discretization;
use crate::pairs::Quad;
use crate::settings::BoundaryPressure;
use glam::{DMat3, IVec3};
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// Spread of a site's neighbours along a direction, in parts of the support radius, below which there is no slope
/// along it. The paper takes no slope at all where the matrix of Eq. 14 can't be inverted, and any else. Measured on
/// water at rest: with 0.03 and less the slope across a layer, from that layer's own unevenness, throws the fluid
/// about, with 0.1 and more it is as calm as without extrapolation.
const LEAST_SPREAD: f64 = 0.1;

/// The least part of a particle's factor that a boundary's pressure may leave.
const LEAST_ANSWER: f32 = 0.1;

/// Sites that are worked on together.
const CHUNK: usize = 256;

/// How pressures at the sites follow from the fluid's.
#[derive(Clone, Debug, Default)]
pub struct Extrapolation {
    sites: Vec<Site>,
    chunks: Vec<Chunk>,
    /// New numbers of the boundary's particles.
    numbers: Vec<u32>,
}

/// Where the boundary has one pressure.
#[derive(Clone, Copy, Debug)]
struct Site {
    /// Where neighbours are looked for, metres.
    place: DVec3,
    /// From there to where the pressure is taken, metres.
    depth: DVec3,
}

/// The factors of a chunk of sites.
#[derive(Clone, Debug, Default)]
struct Chunk {
    /// First factor of each site, and the number of factors.
    starts: Vec<u32>,
    /// Particle, and what its P is multiplied by.
    factors: Vec<(u32, f32)>,
    /// The weight of the fluid between it and the site, p / rho_0.
    weights: Vec<f32>,
    /// Of each site the sum of the absolute values of its factors.
    bounds: Vec<f32>,
    near: Vec<Neighbour>,
}

/// A fluid particle near a site.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    particle: u32,
    /// From the site, in support radii.
    way: DVec3,
    /// W, times r^3.
    weight: f64,
    /// D = rho / rho_0.
    density: f64,
}

/// The fluid that sites look at.
#[derive(Clone, Copy)]
pub struct Fluid<'a> {
    /// Cells of the particles.
    pub cells: &'a Cells,
    /// Their centres, metres.
    pub positions: &'a [DVec3],
    /// Their relative densities D.
    pub densities: &'a [f32],
    /// Kernel and support radius.
    pub with: Discretization,
    /// m/s^2.
    pub gravity: DVec3,
}

impl Extrapolation {
    /// Finds the sites of a boundary and their fluid neighbours; none if nothing is extrapolated.
    pub fn find(&mut self, kind: BoundaryPressure, boundary: &mut Boundary, fluid: Fluid) {
        self.sites.clear();
        if kind.is_extrapolated() {
            let own_part = boundary.own_part(kind);
            boundary.number_sites(own_part, &mut self.sites, &mut self.numbers);
        }
        self.chunks.resize_with(self.sites.len().div_ceil(CHUNK), Chunk::default);
        self.chunks.par_iter_mut().zip(self.sites.par_chunks(CHUNK)).for_each(|(chunk, sites)| {
            chunk.clear();
            for &site in sites {
                fluid.find_near(site.place, &mut chunk.near);
                let depth = site.depth / fluid.with.support_radius;
                match kind {
                    BoundaryPressure::Sph => chunk.add_sph(depth, &fluid),
                    _ => chunk.add_mls(depth),
                }
                chunk.close();
            }
        });
    }

    /// p_b / rho_0 of every site into `out`, by those of the fluid.
    fn pressures(&self, fluid: &[f32], with_weight: bool, out: &mut Vec<f32>) {
        out.resize(self.sites.len(), 0.0);
        out.par_chunks_mut(CHUNK).zip(&self.chunks).for_each(|(out, chunk)| {
            for (site, out) in out.iter_mut().enumerate() {
                let factors = &chunk.factors[chunk.starts[site] as usize..chunk.starts[site + 1] as usize];
                let sum: f32 =
                    factors.iter().map(|&(particle, factor)| factor * fluid[particle as usize]).sum();
                *out = (if with_weight { sum + chunk.weights[site] } else { sum }).max(0.0);
            }
        });
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let of =
            |chunk: &Chunk| 8 * chunk.factors.capacity() + 4 * (chunk.starts.len() + chunk.weights.len());
        self.sites.capacity() * size_of::<Site>() + self.chunks.iter().map(of).sum::<usize>()
    }
}

impl Boundary {
    /// Numbers the sites of the contacts, in their order, and writes their places.
    fn number_sites(&mut self, own_part: f32, sites: &mut Vec<Site>, numbers: &mut Vec<u32>) {
        let shared = matches!(self.method, Method::Particles(..));
        numbers.clear();
        numbers.resize(self.particle_count(), u32::MAX);
        for contact in self.blocks.iter_mut().flat_map(|block| &mut block.contacts) {
            let mut number = if shared { numbers[contact.site as usize] } else { u32::MAX };
            if number == u32::MAX {
                number = sites.len() as u32;
                let depth = if shared { DVec3::ZERO } else { contact.depth(own_part) };
                sites.push(Site { place: contact.point, depth });
                if shared {
                    numbers[contact.site as usize] = number;
                }
            }
            contact.site = number;
        }
    }

    /// Part of a contact's gradient that is the wall's own: a closure with an image has its part in it already.
    fn own_part(&self, kind: BoundaryPressure) -> f32 {
        let has_image =
            matches!(&self.method, Method::VolumeMap(Some(closure)) if closure.kind().has_image());
        if has_image && kind.is_extrapolated() { 0.5 } else { 1.0 }
    }
}

impl Contact {
    /// From a map's sample point to the middle of what it adds to the gradient, metres: a linear pressure is taken
    /// there for the force to be right. At a plane the solid from d on has the density R(d) and the gradient -R'(d) =
    /// W_1(d), so its middle lies R / W_1 deeper.
    fn depth(&self, own_part: f32) -> DVec3 {
        let gradient = f64::from(own_part) * self.gradient();
        let square = gradient.length_squared();
        if square > 0.0 { f64::from(self.density) / square * gradient } else { DVec3::ZERO }
    }
}

impl Fluid<'_> {
    /// The particles within the support radius of a site.
    fn find_near(&self, site: DVec3, near: &mut Vec<Neighbour>) {
        near.clear();
        let cell = self.cells.cell(site);
        let per = 1.0 / self.with.support_radius;
        for n in 0..27 {
            for particle in self.cells.particles(cell + IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) {
                let way = per * (self.positions[particle] - site);
                let square = way.length_squared();
                if square < 1.0 {
                    let weight = self.with.kernel.unit_value(square.sqrt());
                    let density = f64::from(self.densities[particle]);
                    near.push(Neighbour { particle: particle as u32, way, weight, density });
                }
            }
        }
    }
}

impl Chunk {
    fn clear(&mut self) {
        self.starts.clear();
        self.starts.push(0);
        self.factors.clear();
        self.weights.clear();
        self.bounds.clear();
    }

    /// Ends a site's factors.
    fn close(&mut self) {
        let first = self.starts.last().map_or(0, |&first| first as usize);
        self.bounds.push(self.factors[first..].iter().map(|(_, factor)| factor.abs()).sum());
        self.starts.push(self.factors.len() as u32);
    }

    /// Eq. 3: p_b = (sum p_f W + g . sum rho_f (x_b - x_f) W) / sum W.
    fn add_sph(&mut self, depth: DVec3, fluid: &Fluid) {
        let sum: f64 = self.near.iter().map(|near| near.weight).sum();
        let mut below = DVec3::ZERO;
        for &Neighbour { particle, way, weight, density } in &self.near {
            below += weight * density * (depth - way);
            self.factors.push((particle, (weight / sum * density * density) as f32));
        }
        let per_sum = if sum > 0.0 { fluid.with.support_radius / sum } else { 0.0 };
        self.weights.push((fluid.gravity.dot(below) * per_sum) as f32);
    }

    /// Eq. 13 to 16, as a sum over p_f: with the weights V_f W, the mean d_b of the neighbours (Eq. 7) and x' = x -
    /// d_b, p_b = sum of V_f W (1 / sum V W + x'_b . M^-1 x'_f) p_f, M = sum of V W x'_f x'_f^T.
    fn add_mls(&mut self, depth: DVec3) {
        let weight = |near: &Neighbour| near.weight / near.density;
        let sum: f64 = self.near.iter().map(weight).sum();
        let mean = self.near.iter().map(|near| weight(near) * near.way).sum::<DVec3>() / sum;
        let mut matrix = DMat3::ZERO;
        for near in &self.near {
            let way = near.way - mean;
            let part = weight(near) / sum * way;
            matrix += DMat3::from_cols(part * way.x, part * way.y, part * way.z);
        }
        // The site itself is the origin.
        let slope = solve_determined(matrix, depth - mean, LEAST_SPREAD * LEAST_SPREAD);
        for near in &self.near {
            let part = weight(near) / sum * (1.0 + slope.dot(near.way - mean));
            self.factors.push((near.particle, (part * near.density * near.density) as f32));
        }
        self.weights.push(0.0);
    }
}

/// M^-1 v of a symmetric matrix without negative eigenvalues; those up to `least` count as infinite. By Jacobi's
/// rotations, and not by nalgebra's: its eigenvalues differ in their last bits, and with them every run by `mls`.
fn solve_determined(mut matrix: DMat3, vector: DVec3, least: f64) -> DVec3 {
    let mut axes = DMat3::IDENTITY;
    for sweep in 0..24 {
        let (row, column) = [(0, 1), (0, 2), (1, 2)][sweep % 3];
        let off = matrix.col(column)[row];
        if off.abs() <= 1e-15 * (matrix.col(0).x + matrix.col(1).y + matrix.col(2).z) {
            continue;
        }
        let theta = 0.5 * (matrix.col(column)[column] - matrix.col(row)[row]) / off;
        let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
        let cosine = 1.0 / tangent.hypot(1.0);
        let mut turn = DMat3::IDENTITY;
        turn.col_mut(row)[row] = cosine;
        turn.col_mut(column)[column] = cosine;
        turn.col_mut(column)[row] = tangent * cosine;
        turn.col_mut(row)[column] = -tangent * cosine;
        matrix = turn.transpose() * matrix * turn;
        axes *= turn;
    }
    let turned = axes.transpose() * vector;
    let part = |n: usize| if matrix.col(n)[n] > least { turned[n] / matrix.col(n)[n] } else { 0.0 };
    axes * DVec3::new(part(0), part(1), part(2))
}

/// The boundary's pressure in a solve.
#[derive(Clone, Copy)]
pub struct WallPressure<'a> {
    kind: BoundaryPressure,
    extrapolation: &'a Extrapolation,
    /// Whether Eq. 3's weight of the fluid counts: pressures of the divergence solve don't carry it.
    with_weight: bool,
    own_part: f32,
}

/// Fluid and sites in an iteration.
#[derive(Clone, Copy)]
pub struct Pressures<'a> {
    /// P of each particle, m^2/s^2.
    pub fluid: &'a [f32],
    /// Relative densities D.
    pub densities: &'a [f32],
    /// p_b / rho_0, m^2/s^2; empty where nothing is extrapolated.
    pub sites: &'a [f32],
}

/// What a solve knows of the particles.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// D.
    pub densities: &'a [f32],
    /// See [`crate::fields::Fields::factors`], 1/m^2.
    pub factors: &'a [f32],
    /// Gradients of D, 1/m.
    pub gradients: &'a [Quad],
}

impl<'a> WallPressure<'a> {
    /// Of a boundary whose sites are known. `with_weight`: what is solved for carries the fluid's weight.
    pub fn new(
        kind: BoundaryPressure,
        boundary: &Boundary,
        extrapolation: &'a Extrapolation,
        with_weight: bool,
    ) -> WallPressure<'a> {
        WallPressure { kind, extrapolation, with_weight, own_part: boundary.own_part(kind) }
    }

    /// Pressures at all sites, p_b / rho_0, into `out`.
    pub fn at_sites(&self, fluid: &[f32], out: &mut Vec<f32>) {
        self.extrapolation.pressures(fluid, self.with_weight, out);
    }

    /// What a contact's gradient is multiplied by: (p_i / rho_i^2 + p_b / rho_0^2) rho_0, m^2/s^2.
    #[inline]
    pub fn factor(&self, pressures: Pressures, contact: &Contact) -> f32 {
        let particle = contact.particle as usize;
        self.of_particle(pressures, particle) + self.of_site(pressures, contact)
    }

    /// The part of it that is the same in all contacts of a particle.
    #[inline]
    fn of_particle(&self, pressures: Pressures, particle: usize) -> f32 {
        let (pressure, density) = (pressures.fluid[particle], pressures.densities[particle]);
        match self.kind {
            BoundaryPressure::Mirror => pressure * (1.0 + density * density),
            _ => self.own_part * pressure,
        }
    }

    /// The part that is the site's.
    #[inline]
    fn of_site(&self, pressures: Pressures, contact: &Contact) -> f32 {
        if pressures.sites.is_empty() { 0.0 } else { self.own_part * pressures.sites[contact.site as usize] }
    }

    /// Whether the boundary has a pressure of its own.
    pub fn is_more_than_own(&self) -> bool {
        self.kind != BoundaryPressure::Own
    }

    /// Adds to the factors of a block's particles, the first of which is `first`, a bound of what the boundary's
    /// pressure does beyond `own`: to the particle itself, and to its neighbours. p_b has D^2 for each P, and where
    /// walls make most of a density that is so much that Jacobi's steps would be too long. An extrapolated pressure is
    /// the neighbours' as well, so that only what is beyond the rest density's counts. Infinite where the boundary
    /// would press a particle together the more the more pressure it has: no pressure is a solution there.
    pub fn add_bounds(
        &self,
        boundary: &Boundary,
        block: usize,
        first: usize,
        seen: Seen,
        factors: &mut [f32],
    ) {
        let is_own = self.kind == BoundaryPressure::Mirror;
        let dot = |a: [f32; 3], b: Quad| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let add = |particle: usize, [x, y, z]: [f32; 3], per_pressure: f32, factors: &mut [f32]| {
            let (own, factor) = (dot([x, y, z], seen.gradients[particle]), seen.factors[particle]);
            let others = (dot([x, y, z], [x, y, z, 0.0]) * factor).sqrt();
            let beyond = (per_pressure - 1.0).max(0.0);
            let more = if is_own { per_pressure } else { beyond } * own.abs() + beyond * others;
            let is_against = factor + per_pressure * own < LEAST_ANSWER * factor;
            factors[particle - first] += if is_against { f32::INFINITY } else { more };
        };
        if self.kind == BoundaryPressure::Mirror {
            for particle in first..first + factors.len() {
                let gradient = boundary.of_particle[particle].gradient;
                add(particle, gradient, seen.densities[particle].powi(2), factors);
            }
            return;
        }
        for contact in boundary.contacts_of_block(block) {
            let site = contact.site as usize;
            let bound = self.extrapolation.chunks[site / CHUNK].bounds[site % CHUNK];
            add(contact.particle as usize, contact.gradient, self.own_part * bound, factors);
        }
    }

    /// Adds what the boundary's part has more than the pressure of each particle times the boundary's gradient to the
    /// accelerations of a block: its number, and its first particle.
    pub fn accelerate(
        &self,
        boundary: &Boundary,
        block: usize,
        first: usize,
        pressures: Pressures,
        out: &mut [Quad],
    ) {
        let add = |out: &mut Quad, factor: f32, gradient: [f32; 3]| {
            for axis in 0..3 {
                out[axis] -= factor * gradient[axis];
            }
        };
        if self.kind != BoundaryPressure::Own {
            for (particle, out) in (first..).zip(&mut *out) {
                let more = self.of_particle(pressures, particle) - pressures.fluid[particle];
                add(out, more, boundary.of_particle[particle].gradient);
            }
        }
        if !pressures.sites.is_empty() {
            for contact in boundary.contacts_of_block(block) {
                let out = &mut out[contact.particle as usize - first];
                add(out, self.of_site(pressures, contact), contact.gradient);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_runtime::{Dimension, KernelKind};

    const RADIUS: f64 = 0.1;

    /// Random places in a cube of 0.12 m at the origin.
    fn places(count: usize) -> Vec<DVec3> {
        crate::neighbours::tests::random_points(count, 0.12, 11)
    }

    /// p_b / rho_0 at a site for a pressure p / rho_0 of its place.
    fn extrapolated(kind: BoundaryPressure, at: &[DVec3], site: DVec3, p: impl Fn(DVec3) -> f64) -> f64 {
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(at, RADIUS, &mut order);
        let positions: Vec<DVec3> = order.iter().map(|&old| at[old as usize]).collect();
        let densities: Vec<f32> = (0..at.len()).map(|n| 0.9 + 0.02 * (n % 10) as f32).collect();
        let with = Discretization {
            kernel: KernelKind::CubicSpline,
            support_radius: RADIUS,
            volume: 1.25e-4,
            rest_sum: 1.0,
            gradient_scale: 1.0,
            dimension: Dimension::Three,
        };
        let gravity = DVec3::new(0.0, -10.0, 0.0);
        let fluid = Fluid { cells: &cells, positions: &positions, densities: &densities, with, gravity };
        let mut chunk = Chunk::default();
        chunk.clear();
        fluid.find_near(site, &mut chunk.near);
        match kind {
            BoundaryPressure::Sph => chunk.add_sph(DVec3::ZERO, &fluid),
            _ => chunk.add_mls(DVec3::ZERO),
        }
        let one = |&(n, factor): &(u32, f32)| {
            let density = f64::from(densities[n as usize]);
            f64::from(factor) * p(positions[n as usize]) / (density * density)
        };
        chunk.factors.iter().map(one).sum::<f64>() + f64::from(chunk.weights[0])
    }

    #[test]
    fn mls_reproduces_linear_pressure() {
        let linear = |x: DVec3| 3.0 + x.dot(DVec3::new(20.0, -98.0, 7.0));
        // Sites beside all fluid, too.
        for site in [DVec3::splat(0.06), DVec3::new(0.06, -0.01, 0.05), DVec3::new(-0.01, 0.09, 0.03)] {
            let p = extrapolated(BoundaryPressure::Mls, &places(120), site, linear);
            assert!((p - linear(site)).abs() < 2e-4, "{site}: {p} {}", linear(site));
        }
    }

    #[test]
    fn few_neighbours_leave_what_they_tell() {
        let mls =
            |at: &[DVec3], p: &dyn Fn(DVec3) -> f64| extrapolated(BoundaryPressure::Mls, at, DVec3::ZERO, p);
        let linear = |x: DVec3| 5.0 + x.dot(DVec3::new(10.0, 20.0, 30.0));
        // Of one its own pressure, Eq. 16; of a line or a plane no slope across it.
        let one = DVec3::new(0.02, 0.03, 0.01);
        assert!((mls(&[one], &linear) - linear(one)).abs() < 1e-5);
        let line: Vec<DVec3> = (0..6).map(|n| DVec3::new(0.015 * f64::from(n), 0.04, 0.0)).collect();
        assert!((mls(&line, &linear) - linear(DVec3::new(0.0, 0.04, 0.0))).abs() < 1e-4);
        let plane: Vec<DVec3> =
            (0..25).map(|n| DVec3::new(0.02 * f64::from(n % 5), 0.04, 0.02 * f64::from(n / 5))).collect();
        assert!((mls(&plane, &linear) - linear(DVec3::new(0.0, 0.04, 0.0))).abs() < 1e-4);
        assert_eq!(mls(&[DVec3::splat(1.0)], &linear), 0.0);
    }

    #[test]
    fn sph_reproduces_constants_and_adds_weight() {
        let site = DVec3::new(0.06, -0.02, 0.06);
        let p = |kind, p: f64| extrapolated(kind, &places(120), site, |_| p);
        // The same fluid without pressure is the weight alone: fluid above the site.
        let weight = p(BoundaryPressure::Sph, 0.0);
        assert!(weight > 0.0 && weight < 10.0 * RADIUS * 1.1);
        assert!((p(BoundaryPressure::Sph, 7.0) - weight - 7.0).abs() < 1e-5);
        assert!((p(BoundaryPressure::Mls, 7.0) - 7.0).abs() < 1e-5);
        // One particle right above: rho g h.
        let one = [DVec3::new(0.0, 0.05, 0.0)];
        let p = extrapolated(BoundaryPressure::Sph, &one, DVec3::ZERO, |_| 2.0);
        assert!((p - 2.0 - 0.9 * 10.0 * 0.05).abs() < 1e-5, "{p}");
    }

    #[test]
    fn inverses_leave_out_what_is_not_determined() {
        let matrix = DMat3::from_cols_array(&[4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0]);
        let vector = DVec3::new(1.0, -2.0, 3.0);
        assert!((matrix * solve_determined(matrix, vector, 1e-9) - vector).length() < 1e-12);
        let line = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        let flat = DMat3::from_cols(line * line.x, line * line.y, line * line.z) * 0.5;
        assert!((solve_determined(flat, vector, 1e-9) - 2.0 * line * line.dot(vector)).length() < 1e-12);
    }
}
