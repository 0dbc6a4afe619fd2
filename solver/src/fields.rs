//! What a step computes of the particles. Made anew in every step; only [`crate::particles::Particles`] lasts.

use crate::boundary::Boundary;
use crate::neighbours::{CHUNK, Neighbours};
use crate::pairs::lanes::Quad;
use crate::pairs::{Density, Pairs};
use crate::particles::Particles;
use rayon::prelude::*;
use volmap_runtime::{DVec3, Dimension, KernelKind};

/// What the sums over neighbours are made with.
#[derive(Clone, Copy, Debug)]
pub struct Discretization {
    /// The kernel.
    pub kernel: KernelKind,
    /// Its support radius r, metres.
    pub support_radius: f64,
    /// Volume V of a particle, m^3; in two dimensions as [`World::volume_in_sums`](crate::settings::World::volume_in_sums) has it.
    pub volume: f64,
    /// In how many dimensions: of the Laplacian.
    pub dimension: Dimension,
}

impl Discretization {
    /// The sums over neighbours at these places.
    pub fn pairs(self, places: &[Quad]) -> Pairs<'_> {
        Pairs { with: self, places }
    }
}

/// One value for each particle, in their order. Quads have one more, far away and at rest, of pressure zero.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Places in support radii from the first particle, and P = p / (rho_0 D^2), m^2/s^2.
    pub places: Vec<Quad>,
    /// Where a Jacobi step writes.
    pub(crate) next_places: Vec<Quad>,
    /// Velocities, m/s.
    pub velocities: Vec<Quad>,
    /// Accelerations, m/s^2.
    pub accelerations: Vec<Quad>,
    /// Relative densities D = rho / rho_0, the boundary's part included.
    pub densities: Vec<f32>,
    /// alpha of Band et al. 2018, Algorithm 1, of the other sign: by how much P lowers what compresses its own
    /// particle, 1/m^2.
    pub factors: Vec<f32>,
    /// What is to be cancelled: the density's error or the velocity's divergence, 1/s^2.
    pub(crate) sources: Vec<f32>,
    /// Relaxation / factor; 0 where a particle takes no part.
    pub(crate) steps: Vec<f32>,
    /// Free bodies' accelerations times the boundary's gradients, 1/s^2, and what their giving way adds to the factors, 1/m^2;
    /// empty where none is near.
    pub(crate) body_flux: Vec<f32>,
    pub(crate) body_factors: Vec<f32>,
    /// p_b / rho_0 where the boundary's pressure is extrapolated to, m^2/s^2.
    pub(crate) site_pressures: Vec<f32>,
}

/// Farther than any particle, in support radii; its square is still a number.
const FAR: f32 = 1e15;

impl Fields {
    /// Takes places and velocities from the particles.
    pub fn place(&mut self, particles: &Particles, support_radius: f64) {
        let origin = particles.positions.first().copied().unwrap_or_default();
        let per = 1.0 / support_radius;
        let place = |&x: &DVec3| {
            let [x, y, z] = ((x - origin) * per).as_vec3().to_array();
            [x, y, z, 0.0]
        };
        particles.positions.par_iter().map(place).collect_into_vec(&mut self.places);
        self.places.push([FAR, FAR, FAR, 0.0]);
        let velocity = |&[x, y, z]: &[f32; 3]| [x, y, z, 0.0];
        particles.velocities.par_iter().map(velocity).collect_into_vec(&mut self.velocities);
        self.velocities.push([0.0; 4]);
        self.accelerations.resize(self.places.len(), [0.0; 4]);
        self.accelerations[particles.len()] = [0.0; 4];
    }

    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.places.len().saturating_sub(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.places.capacity() * (4 * size_of::<Quad>() + 4 * size_of::<f32>())
    }

    /// Density and factor of all particles: Band et al. 2018, Algorithm 1, lines 4 and 5.
    pub fn compute_density(
        &mut self,
        with: Discretization,
        neighbours: &mut Neighbours,
        boundary: &Boundary,
    ) {
        self.densities.resize(self.len(), 0.0);
        self.factors.resize(self.len(), 0.0);
        let pairs = with.pairs(&self.places);
        let chunks = self.densities.par_chunks_mut(CHUNK).zip(self.factors.par_chunks_mut(CHUNK));
        chunks.zip(neighbours.chunks_mut()).for_each(|((densities, factors), lists)| {
            let mut sums = [Density::default(); CHUNK];
            let sums = &mut sums[..densities.len()];
            pairs.density(lists, sums);
            for (within, sum) in sums.iter().enumerate() {
                let wall = boundary.of_particle[lists.first + within];
                let [x, y, z]: [f32; 3] =
                    std::array::from_fn(|axis| sum.gradient[axis] + wall.gradient[axis]);
                densities[within] = sum.density + wall.density;
                factors[within] = x * x + y * y + z * z + sum.squares;
            }
        });
    }

    /// Begins with a part of the pressures of the last step.
    pub fn set_pressures(&mut self, pressures: &[f32], part: f32) {
        self.places.par_iter_mut().zip(pressures).for_each(|(place, pressure)| place[3] = part * pressure);
    }

    /// Keeps the pressures for the next step.
    pub fn keep_pressures(&self, pressures: &mut [f32]) {
        pressures.par_iter_mut().zip(&self.places).for_each(|(pressure, place)| *pressure = place[3]);
    }

    /// v <- v + dt a.
    pub fn accelerate(&mut self, dt: f64) {
        let dt = dt as f32;
        self.velocities.par_iter_mut().zip(&self.accelerations).with_min_len(CHUNK).for_each(|(v, a)| {
            for axis in 0..3 {
                v[axis] += dt * a[axis];
            }
        });
    }
}
