//! How long the stages of a step take.

use std::time::{Duration, Instant};

/// Wall-clock time of each stage of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stages {
    /// Sorting the particles by cells, with emitters and the choice of the time step.
    pub sort: Duration,
    /// Pairs of neighbours, with the kernel's sums.
    pub neighbours: Duration,
    /// Asking the maps.
    pub boundary: Duration,
    /// Density and factor, of these sums and the boundary's.
    pub density: Duration,
    /// The divergence solve.
    pub divergence: Duration,
    /// Viscosity and gravity.
    pub non_pressure: Duration,
    /// The density solve.
    pub pressure: Duration,
    /// New velocities and places.
    pub advance: Duration,
    /// Bodies.
    pub rigid: Duration,
    last: Option<Instant>,
}

impl Stages {
    /// A step begins.
    pub(crate) fn begin(&mut self) {
        *self = Stages { last: Some(Instant::now()), ..Stages::default() };
    }

    /// A stage ends: since the last one, its time has passed.
    pub(crate) fn end(&mut self, stage: impl Fn(&mut Stages) -> &mut Duration) {
        let now = Instant::now();
        let passed = self.last.map_or(Duration::ZERO, |last| now - last);
        *stage(self) += passed;
        self.last = Some(now);
    }

    /// All stages together.
    pub fn total(&self) -> Duration {
        self.sort
            + self.neighbours
            + self.boundary
            + self.density
            + self.divergence
            + self.non_pressure
            + self.pressure
            + self.advance
            + self.rigid
    }
}
