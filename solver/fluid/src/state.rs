//! What a simulation keeps from one step to the next: with it, one of the same setup goes on with the same bits.

use crate::emitter::EmitterState;
use crate::error::Error;
use crate::particles::Particles;
use crate::simulation::Simulation;

/// The state after a step, as [`Simulation::particles`], [`Simulation::densities`] and so on give it.
#[derive(Clone, Debug)]
pub struct State {
    /// The fluid.
    pub particles: Particles,
    /// Relative densities of the last step.
    pub densities: Vec<f32>,
    /// How far each emitter is.
    pub emitters: Vec<EmitterState>,
    /// The bodies: [`Bodies::snapshot`](crate::bodies::Bodies::snapshot).
    pub bodies: Vec<u8>,
    /// Time simulated, seconds.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// [`Simulation::body_speed`].
    pub body_speed: f64,
}

impl Simulation {
    /// The state after the last step.
    ///
    /// # Errors
    /// As [`Bodies::snapshot`](crate::bodies::Bodies::snapshot).
    pub fn state(&self) -> Result<State, Error> {
        Ok(State {
            particles: self.particles.clone(),
            densities: self.densities().to_vec(),
            emitters: self.emitters.iter().map(|emitter| emitter.state.clone()).collect(),
            bodies: self.bodies.snapshot()?,
            time: self.time,
            step: self.step,
            body_speed: self.body_speed,
        })
    }

    /// Takes a state of a simulation of the same setup.
    ///
    /// # Errors
    /// What is wrong with it; the simulation is of no use then.
    pub fn restore(&mut self, state: State) -> Result<(), String> {
        let State { particles, densities, emitters, bodies, time, step, body_speed } = state;
        if !particles.is_even() || densities.len() != particles.len() || emitters.len() != self.emitters.len()
        {
            return Err("its lists have different lengths".into());
        }
        if !particles.channels.are_those_of(&self.particles.channels) {
            return Err("its particles carry what other forces need".into());
        }
        // Cells are laid around all places: those of no number or out of all bounds must not get there.
        if !time.is_finite() || !particles.positions.iter().all(|&x| self.is_in_domain(x)) {
            return Err("its numbers are out of range".into());
        }
        if !self.emitters.iter().zip(&emitters).all(|(emitter, state)| emitter.can_be_in(state)) {
            return Err("its emitters have other nozzles".into());
        }
        self.bodies.restore(&bodies)?;
        for (emitter, state) in self.emitters.iter_mut().zip(emitters) {
            emitter.state = state;
        }
        self.particles = particles;
        self.fields.densities = densities;
        (self.time, self.step, self.body_speed) = (time, step, body_speed);
        Ok(())
    }
}
