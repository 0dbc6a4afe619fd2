//! Boundaries by particles: Akinci et al. 2012, *Versatile Rigid-Fluid Coupling for Incompressible SPH*.
//!
//! A body's surface is sampled by particles ([`super::sampling`]). Each stands for the volume that it has among its
//! own kind, psi_b = rho_0 V_b with V_b = 1 / sum over k of W_bk (Eq. 4 and 5; k runs over the same body's), and a
//! fluid particle sees rho_0 V_b W_ib of it: a contact for each boundary particle in reach. At a plane the sum is
//! rho_0 W_1(d) / W_1(0), W_1 being the kernel integrated over a sheet.
//!
//! Samples, volumes and cells are of the body's own frame: made once, they move with its pose.

use super::sampling;
use super::{Contact, Pairing};
use crate::bodies::Bodies;
use crate::cells::Cells;
use crate::error::Error;
use crate::settings::{FluidSettings, World};
use glam::IVec3;
use std::sync::Arc;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, Kernel};

/// Distance of a body's particles in fluid particles' radii. At 2, the fluid's own spacing, a turning ball gives
/// water eight times as much energy as at this, and blue noise had holes in which particles of water at rest were
/// found.
const SPACING: f64 = 1.5;
/// Particles of a body at most.
pub const MOST: u64 = 20_000_000;

/// The particles of a body.
#[derive(Clone, Debug)]
pub struct BodyParticles {
    /// In the body's frame, metres, in the order of the cells.
    positions: Vec<DVec3>,
    /// V_b, m^3.
    volumes: Vec<f64>,
    cells: Cells,
    /// The box within which a fluid particle may be in reach.
    bounds: [DVec3; 2],
    /// Number of its first one among those of all bodies.
    first: u32,
}

/// How many particles a body of this mesh gets.
pub fn count(mesh: &TriangleMesh, particle_radius: f64) -> u64 {
    sampling::count(mesh, SPACING * particle_radius)
}

/// What is wrong with a mesh that is to be sampled, if anything.
pub fn defect(mesh: &TriangleMesh, particle_radius: f64) -> Option<String> {
    match count(mesh, particle_radius) {
        0 => Some("its mesh has no area, so it gets no boundary particles".into()),
        count if count > MOST => Some(format!(
            "its mesh would get {count} boundary particles, more than {MOST}; check its scale and particle_radius"
        )),
        _ => None,
    }
}

/// The particles of every body; bodies of one mesh have the same ones.
pub(super) fn of_bodies(
    bodies: &Bodies,
    world: &World,
    kernel: &Kernel,
) -> Result<Vec<Arc<BodyParticles>>, Error> {
    let mut all: Vec<Arc<BodyParticles>> = Vec::new();
    let mut first = 0;
    for body in 0..bodies.posed().len() {
        let refuse = |reason| Error::Setup { place: format!("body `{}`", bodies.name(body)), reason };
        let mesh = bodies.mesh(body).ok_or_else(|| {
            refuse("boundary = \"particles\" needs its mesh, and it has a map only; give the mesh".into())
        })?;
        if let Some(defect) = defect(mesh, world.particle_radius) {
            return Err(refuse(defect));
        }
        let made = (0..body).find(|&other| bodies.mesh(other).is_some_and(|other| Arc::ptr_eq(other, mesh)));
        let mut particles = match made {
            Some(other) => (*all[other]).clone(),
            None => {
                let places = sampling::sample(mesh, SPACING * world.particle_radius, world.sampling);
                BodyParticles::new(places, kernel)
            }
        };
        particles.first = first;
        first += particles.len() as u32;
        all.push(Arc::new(particles));
    }
    Ok(all)
}

impl BodyParticles {
    /// From places in the body's frame.
    pub fn new(positions: Vec<DVec3>, kernel: &Kernel) -> BodyParticles {
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(&positions, kernel.support_radius(), &mut order);
        let positions: Vec<DVec3> = order.iter().map(|&old| positions[old as usize]).collect();
        let reach = DVec3::splat(kernel.support_radius());
        let low = positions.iter().fold(DVec3::INFINITY, |low, &x| low.min(x)) - reach;
        let high = positions.iter().fold(DVec3::NEG_INFINITY, |high, &x| high.max(x)) + reach;
        let mut particles =
            BodyParticles { positions, volumes: Vec::new(), cells, bounds: [low, high], first: 0 };
        particles.volumes = particles.positions.iter().map(|&x| particles.volume_at(x, kernel)).collect();
        particles
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Their volumes V_b, m^3.
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// 1 / sum of W, Eq. 4.
    fn volume_at(&self, point: DVec3, kernel: &Kernel) -> f64 {
        let mut sum = 0.0;
        self.near(point, kernel.support_radius(), |_, _, distance| sum += kernel.value(distance));
        1.0 / sum
    }

    /// Calls `f` with every particle within `radius` of a point of the body's frame, the vector to the point, and its
    /// length.
    fn near(&self, point: DVec3, radius: f64, mut f: impl FnMut(usize, DVec3, f64)) {
        if point.cmplt(self.bounds[0]).any() || point.cmpgt(self.bounds[1]).any() {
            return;
        }
        let cell = self.cells.cell(point);
        for n in 0..27 {
            for i in self.cells.particles(cell + IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) {
                let way = point - self.positions[i];
                let square = way.length_squared();
                if square < radius * radius {
                    f(i, way, square.sqrt());
                }
            }
        }
    }
}

/// The kernel of densities, and that of gradients with what these are multiplied by: [`World::gradient_scale`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernels {
    density: Kernel,
    gradient: Kernel,
    scale: f64,
}

impl Kernels {
    pub fn new(density: Kernel, world: &World, fluid: &FluidSettings) -> Kernels {
        let gradient = Kernel::new(density.kind().of_gradients(), density.support_radius());
        Kernels { density, gradient, scale: world.gradient_scale(fluid) }
    }
}

/// Adds the contacts of a block: density V_b W_ib and gradient V_b grad W_ib of each boundary particle in reach.
pub(super) fn touch(
    pairing: Pairing,
    kernels: &Kernels,
    particles: &BodyParticles,
    contacts: &mut Vec<Contact>,
) {
    let pose = pairing.map().pose;
    for (within, &position) in pairing.positions.iter().enumerate() {
        particles.near(pose.to_map(position), kernels.density.support_radius(), |i, way, distance| {
            let (volume, point) = (particles.volumes[i], pose.to_world(particles.positions[i]));
            let direction = pose.rotation * (way / distance.max(f64::MIN_POSITIVE));
            let gradient = kernels.scale * volume * kernels.gradient.derivative(distance) * direction;
            let contact = pairing.contact(within, volume * kernels.density.value(distance), gradient, point);
            contacts.push(Contact { site: particles.first + i as u32, ..contact });
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::BoundarySampling;
    use volmap_runtime::KernelKind;

    /// Density and gradient over rho_0 at a point.
    fn density(particles: &BodyParticles, kernel: &Kernel, point: DVec3) -> (f64, DVec3) {
        let mut out = (0.0, DVec3::ZERO);
        particles.near(point, kernel.support_radius(), |i, way, distance| {
            out.0 += particles.volumes[i] * kernel.value(distance);
            out.1 += particles.volumes[i] * kernel.derivative(distance) * way / distance;
        });
        out
    }

    #[test]
    fn a_plane_has_the_density_of_a_sheet() {
        // W_1 of the cubic spline at q r: 1.4 / r at 0, and what an integral by the trapezoid rule says.
        let kernel = Kernel::new(KernelKind::CubicSpline, 0.1);
        let sheet = |z: f64| {
            let steps = 2000;
            let width = (0.1 - z) / f64::from(steps);
            let at = |n: i32| z + (f64::from(n) + 0.5) * width;
            (0..steps).map(|n| std::f64::consts::TAU * kernel.value(at(n)) * at(n) * width).sum::<f64>()
        };
        assert!((sheet(0.0) - 14.0).abs() < 1e-4);
        // A regular sheet, fine enough for the sum to be the integral.
        let places = (0..101 * 101).map(|n| 0.005 * DVec3::new(f64::from(n % 101), 0.0, f64::from(n / 101)));
        let regular = BodyParticles::new(places.collect(), &kernel);
        // And blue noise at a particle's spacing.
        let plate = crate::shapes::cuboid(DVec3::new(0.0, -0.5, 0.0), DVec3::new(0.5, 0.0, 0.5));
        let noise = BodyParticles::new(sampling::sample(&plate, 0.05, BoundarySampling::BlueNoise), &kernel);
        for d in [0.01, 0.025, 0.05, 0.075] {
            let exact = sheet(d) / sheet(0.0);
            let (value, gradient) = density(&regular, &kernel, DVec3::new(0.25, d, 0.25));
            assert!((value / exact - 1.0).abs() < 2e-3, "{d}: {value} {exact}");
            assert!(gradient.y < 0.0 && gradient.x.abs() + gradient.z.abs() < 1e-3 * gradient.y.abs());
            let mut mean = 0.0;
            for n in 0..64 {
                let at = DVec3::new(0.15 + 0.025 * f64::from(n % 8), d, 0.15 + 0.025 * f64::from(n / 8));
                mean += density(&noise, &kernel, at).0 / 64.0;
            }
            assert!((mean / exact - 1.0).abs() < 0.05, "{d}: {mean} {exact}");
        }
    }

    /// What drags fluid along where the wall moves: the gradient's part along the wall, over the part across it.
    #[test]
    fn even_walls_are_smooth() {
        let kernel = Kernel::new(KernelKind::CubicSpline, 0.1);
        let plate = crate::shapes::cuboid(DVec3::new(0.0, -0.5, 0.0), DVec3::new(0.8, 0.0, 0.8));
        let bumps = |kind| {
            let particles = BodyParticles::new(sampling::sample(&plate, 1.5 * 0.025, kind), &kernel);
            let mut sums = [0.0; 2];
            for n in 0..400 {
                // At 2 rp, where the first layer lies, away from the edges.
                let at = DVec3::new(0.2 + 0.02 * f64::from(n % 20), 0.05, 0.2 + 0.02 * f64::from(n / 20));
                let gradient = density(&particles, &kernel, at).1;
                sums[0] += gradient.with_y(0.0).length_squared();
                sums[1] += gradient.y * gradient.y;
            }
            (sums[0] / sums[1]).sqrt()
        };
        let [noise, even] = [BoundarySampling::BlueNoise, BoundarySampling::Even].map(bumps);
        assert!(even < 0.05 && even < 0.4 * noise, "{even} {noise}");
    }
}
