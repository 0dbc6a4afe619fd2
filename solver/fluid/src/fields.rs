//! What a step computes of the particles. Made anew in every step; only [`crate::particles::Particles`] lasts.

use crate::boundary::Boundary;
use crate::pairs::{Density, Quad};
use crate::particles::{CHUNK, Particles};
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// One value for each particle, in their order. The fourth number of a quad is 0.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Places in support radii from the first particle.
    pub places: Vec<Quad>,
    /// What the fluid neighbours amount to.
    pub neighbourhoods: Vec<Density>,
    /// P = p / (rho_0 D^2), m^2/s^2.
    pub pressures: Vec<f32>,
    /// Where a Jacobi step writes.
    pub(crate) next_pressures: Vec<f32>,
    /// Velocities, m/s.
    pub velocities: Vec<Quad>,
    /// Accelerations, m/s^2.
    pub accelerations: Vec<Quad>,
    /// Ways by which particles that are too dense go apart without getting a velocity, metres; none where velocities do
    /// it.
    pub(crate) shifts: Vec<Quad>,
    /// grad D, V times the sum of grad W and the boundary's part, 1/m.
    pub gradients: Vec<Quad>,
    /// Relative densities D = rho / rho_0, the boundary's part included.
    pub densities: Vec<f32>,
    /// alpha of Band et al. 2018, Algorithm 1, of the other sign: by how much P lowers what compresses its own
    /// particle, 1/m^2.
    pub factors: Vec<f32>,
    /// The bodies' velocities times the boundary's gradients, 1/s.
    pub(crate) wall_rates: Vec<f32>,
    /// What is to be cancelled: the density's error or the velocity's divergence, 1/s^2.
    pub(crate) sources: Vec<f32>,
    /// Relaxation / factor; 0 where a particle takes no part.
    pub(crate) steps: Vec<f32>,
    /// Free bodies' accelerations times the boundary's gradients, 1/s^2, and what their giving way adds to the
    /// factors, 1/m^2; empty where none is near.
    pub(crate) body_flux: Vec<f32>,
    pub(crate) body_factors: Vec<f32>,
    /// p_b / rho_0 where the boundary's pressure is extrapolated to, m^2/s^2.
    pub(crate) site_pressures: Vec<f32>,
}

impl Fields {
    /// Takes places and velocities from the particles.
    pub fn place(&mut self, particles: &Particles, support_radius: f64) {
        let origin = particles.positions.first().copied().unwrap_or_default();
        let per = 1.0 / support_radius;
        let place = |&x: &DVec3| {
            let [x, y, z] = ((x - origin) * per).as_vec3().to_array();
            [x, y, z, 0.0]
        };
        particles.positions.par_iter().with_min_len(CHUNK).map(place).collect_into_vec(&mut self.places);
        let velocity = |&[x, y, z]: &[f32; 3]| [x, y, z, 0.0];
        let velocities = particles.velocities.par_iter().with_min_len(CHUNK);
        velocities.map(velocity).collect_into_vec(&mut self.velocities);
        self.accelerations.resize(self.len(), [0.0; 4]);
        self.shifts.clear();
    }

    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let all = 4 * size_of::<Quad>() + size_of::<Density>() + 9 * size_of::<f32>();
        self.places.capacity() * all + self.shifts.capacity() * size_of::<Quad>()
    }

    /// Density and factor of all particles: Band et al. 2018, Algorithm 1, lines 4 and 5.
    pub fn compute_density(&mut self, boundary: &Boundary) {
        self.densities.resize(self.len(), 0.0);
        self.factors.resize(self.len(), 0.0);
        self.gradients.resize(self.len(), [0.0; 4]);
        self.wall_rates.clear();
        self.wall_rates.extend(boundary.of_particle.iter().map(|wall| wall.flux));
        let out = self.densities.par_iter_mut().zip(&mut self.factors).zip(&mut self.gradients);
        let of = self.neighbourhoods.par_iter().zip(&boundary.of_particle);
        out.zip(of).with_min_len(CHUNK).for_each(|(((density, factor), gradient), (fluid, wall))| {
            let [x, y, z]: [f32; 3] = std::array::from_fn(|axis| fluid.gradient[axis] + wall.gradient[axis]);
            *density = fluid.density + wall.density;
            *factor = x * x + y * y + z * z + fluid.squares;
            *gradient = [x, y, z, 0.0];
        });
    }

    /// Begins with a part of the pressures of the last step.
    pub fn set_pressures(&mut self, pressures: &[f32], part: f32) {
        self.pressures.clear();
        self.pressures.extend(pressures.iter().map(|pressure| part * pressure));
    }
}

/// v <- v + dt a.
pub(crate) fn accelerate(velocities: &mut [Quad], accelerations: &[Quad], dt: f64) {
    let dt = dt as f32;
    velocities.par_iter_mut().zip(accelerations).with_min_len(CHUNK).for_each(|(v, a)| {
        for axis in 0..3 {
            v[axis] += dt * a[axis];
        }
    });
}
