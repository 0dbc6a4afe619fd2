//! A force of a program's own, with a vector that every particle carries: a block of fluid that shears, and the
//! vortices in it.
//!
//! ```text
//! cargo run --release -p volmap-fluid --example vortex_force
//! ```
//! Particles that spin (Bender et al. 2018, *Turbulent Micropolar SPH Fluids with Foam*) take spin from the curl of the
//! velocity and give it back:
//! ```text
//! dv/dt = nu curl w,   theta dw/dt = nu (curl v - 2 w)
//! ```

use volmap_fluid::Error;
use volmap_fluid::bodies::Bodies;
use volmap_fluid::channels::{ChannelDeclaration, Channels, Initial};
use volmap_fluid::forces::{Defect, Force, ForceStep};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::neighbours::Neighbour;
use volmap_fluid::observe;
use volmap_fluid::pairs::Quad;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::World;
use volmap_fluid::setup::Setup;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{}", run(200)?);
    Ok(())
}

/// The force: its settings, and room to work in.
pub struct Vortices {
    /// Transfer nu, m^2/s.
    pub transfer: f64,
    /// Inertia theta of a particle's spin for each of its masses, m^2.
    pub inertia: f64,
    /// Of each particle the curl of the velocity, and of the spin.
    curls: Vec<[[f32; 3]; 2]>,
}

/// The spins w of the particles, 1/s: reordered, kept in checkpoints and written into frames with them.
const SPIN: ChannelDeclaration =
    ChannelDeclaration { name: "spin", initial: Initial::Vector([0.0; 3]), in_frames: true };

impl Vortices {
    /// With this transfer (m^2/s) and inertia (m^2).
    pub fn new(transfer: f64, inertia: f64) -> Vortices {
        Vortices { transfer, inertia, curls: Vec::new() }
    }
}

impl Force for Vortices {
    fn name(&self) -> &'static str {
        "vortices"
    }

    fn check(&self) -> Result<(), Defect> {
        if self.transfer >= 0.0 && self.inertia > 0.0 {
            return Ok(());
        }
        Err(Defect { key: "inertia", reason: "a spin needs an inertia above 0 m^2".into() })
    }

    fn channels(&self) -> Vec<ChannelDeclaration> {
        vec![SPIN]
    }

    /// A spin that is left alone decays with the rate 2 nu / theta.
    fn longest_step(&self) -> f64 {
        0.5 * self.inertia / self.transfer
    }

    fn accelerate(
        &mut self,
        step: &ForceStep,
        velocities: &[Quad],
        channels: &mut Channels,
        accelerations: &mut [Quad],
    ) {
        let spins = channels.vectors_mut(SPIN.name);
        self.curls.resize(velocities.len(), [[0.0; 3]; 2]);
        step.neighbours.each(&mut self.curls, |own, neighbours, curls| {
            let of = |at: usize| [velocities[at][0], velocities[at][1], velocities[at][2]];
            *curls = [curl(own, neighbours, of), curl(own, neighbours, |at| spins[at])];
        });
        let rate = (step.dt * self.transfer / self.inertia) as f32;
        let all = spins.iter_mut().zip(accelerations).zip(&self.curls);
        for ((spin, acceleration), [of_velocity, of_spin]) in all {
            for axis in 0..3 {
                acceleration[axis] += self.transfer as f32 * of_spin[axis];
                spin[axis] += rate * (of_velocity[axis] - 2.0 * spin[axis]);
            }
        }
    }
}

/// The sum of V (u_i - u_j) x grad W_ij.
fn curl(own: usize, neighbours: &[Neighbour], of: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let (mut sum, u) = ([0.0; 3], of(own));
    for neighbour in neighbours {
        let (v, g) = (of(neighbour.particle), neighbour.gradient);
        let [x, y, z] = [u[0] - v[0], u[1] - v[1], u[2] - v[2]];
        sum = [sum[0] + y * g[2] - z * g[1], sum[1] + z * g[0] - x * g[2], sum[2] + x * g[1] - y * g[0]];
    }
    sum
}

/// A block of fluid in free space, whose layers move past each other.
///
/// # Errors
/// None here: as [`Simulation::new`].
pub fn shear(forces: Vec<Box<dyn Force>>) -> Result<Simulation, Error> {
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    let places: Vec<DVec3> =
        fill_box([DVec3::ZERO, DVec3::splat(0.5)], 2.0 * world.particle_radius).collect();
    let velocities: Vec<[f32; 3]> = places.iter().map(|x| [2.0 * (x.y - 0.25) as f32, 0.0, 0.0]).collect();
    let mut particles = Particles::default();
    particles.add(&places, &velocities);
    let bodies = Bodies::new(Vec::new(), world.gravity)?;
    Simulation::new(Setup { own_forces: forces, ..Setup::new(world, particles, bodies) })
}

/// Simulates some steps, and says what came of the spins.
///
/// # Errors
/// As [`Simulation::step`].
pub fn run(steps: u64) -> Result<String, Error> {
    let mut simulation = shear(vec![Box::new(Vortices::new(0.05, 1e-3))])?;
    for _ in 0..steps {
        simulation.step()?;
    }
    let [momentum, _] = observe::momenta(&simulation);
    Ok(format!(
        "after {:.3} s: mean spin {:.3} 1/s (half of the curl of the shear is -1), momentum {:.1e} kg m/s",
        simulation.time(),
        mean_spin(&simulation),
        momentum.length()
    ))
}

/// Mean of the spins about z, 1/s.
pub fn mean_spin(simulation: &Simulation) -> f64 {
    let mut channels = simulation.particles().channels.clone();
    let spins = channels.vectors_mut(SPIN.name);
    spins.iter().map(|spin| f64::from(spin[2])).sum::<f64>() / spins.len() as f64
}
