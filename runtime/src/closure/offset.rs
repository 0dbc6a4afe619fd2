//! Closure `offset`: what SPlisHSPlasH computes up to version 2.18, x* = x - max(Phi + rp/2, 2 rp) n, with 0.8 V.
//!
//! At a flat wall and r = 4 rp 4 to 12 times the integral of W over the solid.

use super::model::{BoundaryDensity, Model, Particle, Setup};
use std::sync::Arc;

/// The factor on V: in those versions particles had 0.8 (2 rp)^3 instead of the cube's volume, and so boundaries had
/// less as well. Since 2.19 both have all of it.
const FACTOR: f64 = 0.8;

#[derive(Debug)]
struct Offset {
    setup: Setup,
}

pub(super) fn new(setup: &Setup) -> Arc<dyn Model> {
    Arc::new(Offset { setup: *setup })
}

impl Model for Offset {
    #[inline]
    fn density(&self, particle: Particle) -> Option<BoundaryDensity> {
        let (surface, Setup { kernel, particle_radius }) = (particle.seen.surface, &self.setup);
        let distance = (surface.distance + 0.5 * particle_radius).max(2.0 * particle_radius);
        let volume = FACTOR * surface.volume;
        (distance < kernel.support_radius()).then(|| BoundaryDensity {
            density: volume * kernel.value(distance),
            gradient: volume * kernel.derivative(distance) * surface.normal,
            point: particle.position - distance * surface.normal,
        })
    }
}
