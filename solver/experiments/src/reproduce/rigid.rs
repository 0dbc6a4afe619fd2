//! Particles that move as one rigid body, in place of the elastic solids of Bender et al. 2020 (Figs. 8, 9 and 14).
//!
//! The solver does its step as for a fluid. The body takes over the momentum and the angular momentum of the resulting
//! velocities, which pressures among particles don't change; so the forces of the boundaries on the particles add up.
//! Then all particles are moved with the body.

use glam::DMat3;
use volmap_fluid::Error;
use volmap_fluid::simulation::{Simulation, StepReport};
use volmap_runtime::{DQuat, DVec3};

/// Iterations of the implicit midpoint rule; each reduces the error by the angle of a step.
const ITERATIONS: usize = 4;

/// A rigid body. Its mass is that of its particles.
pub struct Rigid {
    /// Offset of each particle from the centre, in the body's axes, by the particles' ids.
    offsets: Vec<DVec3>,
    /// Inertia over a particle's mass, in the body's axes, m^2.
    inertia: DMat3,
    /// Centre of mass, metres.
    pub centre: DVec3,
    /// Rotation from the body's axes to the world's.
    pub rotation: DQuat,
    /// Velocity of the centre, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
}

impl Rigid {
    /// A body at rest of particles at these positions, metres.
    pub fn new(places: &[DVec3], velocity: DVec3, angular_velocity: DVec3) -> Rigid {
        let centre = places.iter().sum::<DVec3>() / places.len() as f64;
        let offsets: Vec<DVec3> = places.iter().map(|&x| x - centre).collect();
        let square = |x: DVec3| DMat3::from_cols(x * x.x, x * x.y, x * x.z);
        let inertia = |x: &DVec3| DMat3::from_diagonal(DVec3::splat(x.length_squared())) - square(*x);
        Rigid {
            inertia: offsets.iter().map(inertia).fold(DMat3::ZERO, |sum, next| sum + next),
            offsets,
            centre,
            rotation: DQuat::IDENTITY,
            velocity,
            angular_velocity,
        }
    }

    /// Positions and velocities of the particles, ordered by id.
    pub fn particles(&self) -> (Vec<DVec3>, Vec<[f32; 3]>) {
        (0..self.offsets.len()).map(|n| (self.centre + self.arm(n), self.velocity_of(n))).unzip()
    }

    /// One step of a simulation whose fluid is the body.
    ///
    /// # Errors
    /// As [`Simulation::step`], and if particles left the domain.
    pub fn step(&mut self, simulation: &mut Simulation) -> Result<StepReport, Error> {
        let report = simulation.step()?;
        if simulation.particles().len() != self.offsets.len() {
            let (step, time) = (simulation.steps(), simulation.time());
            let reason = "particles of a rigid body left the domain".into();
            return Err(Error::Simulation { step, time, reason });
        }
        let [mut push, mut turn] = [DVec3::ZERO; 2];
        let particles = simulation.particles();
        for (velocity, &id) in particles.velocities.iter().zip(&particles.ids) {
            let before = self.velocity_of(id as usize);
            let change = DVec3::from_array([0, 1, 2].map(|axis| f64::from(velocity[axis] - before[axis])));
            push += change;
            turn += self.arm(id as usize).cross(change);
        }
        self.velocity += push / self.offsets.len() as f64;
        self.turn(turn, report.dt);
        self.centre += report.dt * self.velocity;
        self.place(simulation);
        Ok(report)
    }

    /// Moves the particles to where the body is.
    pub fn place(&self, simulation: &mut Simulation) {
        simulation.place(|id| (self.centre + self.arm(id as usize), self.velocity_of(id as usize)));
    }

    /// Rotates the body by the implicit midpoint rule, which conserves angular momentum.
    fn turn(&mut self, gained: DVec3, dt: f64) {
        let momentum = self.inertia_at(self.rotation) * self.angular_velocity + gained;
        let velocity_at = |rotation: DQuat| self.inertia_at(rotation).inverse() * momentum;
        let mut middle = velocity_at(self.rotation);
        for _ in 0..ITERATIONS {
            middle = velocity_at(DQuat::from_scaled_axis(0.5 * dt * middle) * self.rotation);
        }
        let rotation = (DQuat::from_scaled_axis(dt * middle) * self.rotation).normalize();
        self.angular_velocity = velocity_at(rotation);
        self.rotation = rotation;
    }

    fn inertia_at(&self, rotation: DQuat) -> DMat3 {
        let axes = DMat3::from_quat(rotation);
        axes * self.inertia * axes.transpose()
    }

    fn arm(&self, n: usize) -> DVec3 {
        self.rotation * self.offsets[n]
    }

    fn velocity_of(&self, n: usize) -> [f32; 3] {
        (self.velocity + self.angular_velocity.cross(self.arm(n))).as_vec3().to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::super::boundaries::VOLUME_MAP;
    use super::*;

    #[test]
    fn free_flight_keeps_momentum_and_angular_momentum() {
        let places: Vec<DVec3> = (0..60)
            .map(|n| 0.05 * DVec3::new(f64::from(n % 5), f64::from(n / 5 % 4), f64::from(n / 20)))
            .collect();
        let mut rigid = Rigid::new(&places, DVec3::new(1.0, 2.0, 0.0), DVec3::new(3.0, -1.0, 4.0));
        let mut setup = VOLUME_MAP.setup(0.025, Vec::new()).unwrap();
        let (positions, velocities) = rigid.particles();
        setup.particles.add(&positions, &velocities);
        let mut simulation = Simulation::new(setup).unwrap();
        let momentum = |rigid: &Rigid| rigid.inertia_at(rigid.rotation) * rigid.angular_velocity;
        let (start, before) = (rigid.centre, momentum(&rigid));
        while simulation.time() < 1.0 {
            rigid.step(&mut simulation).unwrap();
        }
        let time = simulation.time();
        let exact = start + time * DVec3::new(1.0, 2.0, 0.0) - DVec3::Y * 0.5 * 9.81 * time * time;
        // Steps of 2 ms, of first order.
        assert!(rigid.centre.distance(exact) < 0.5 * 9.81 * 2.1e-3, "{} {exact}", rigid.centre);
        assert!((momentum(&rigid) - before).length() < 1e-5 * before.length());
        assert!(rigid.rotation.angle_between(DQuat::IDENTITY) > 0.1);
        let particles = simulation.particles();
        for (&x, &id) in particles.positions.iter().zip(&particles.ids) {
            let apart = (places[id as usize] - places[0]).length();
            let first = particles.ids.iter().position(|&id| id == 0).unwrap();
            assert!((x.distance(particles.positions[first]) - apart).abs() < 1e-12);
        }
    }
}
