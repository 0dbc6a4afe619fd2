//! How much memory a run needs, before it begins: by its particles, those that emitters will add, and its maps.

use super::{EmitterSettings, Scene, nozzle};
use crate::error::Error;
use std::sync::Arc;
use volmap_fluid::lattice;
use volmap_formats::text::{bytes, thousands};
use volmap_runtime::VolumeMap;

/// Peak memory of a run per particle, measured at 60 thousand to 3 million particles (600 to 720:
/// solver/BENCHMARKS.md).
pub const BYTES_PER_PARTICLE: u64 = 700;
/// What each run takes besides.
pub const BYTES_OF_PROGRAM: u64 = 30 << 20;

/// What a run may need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Bytes.
    pub bytes: u64,
    /// End of the run, seconds: until then emitters add particles.
    pub end: f64,
}

impl Limit {
    /// Refuses what is known of a scene before anything is baked.
    pub(super) fn check_scene(&self, scene: &Scene) -> Result<(), Error> {
        let count = |corners| lattice::counts(corners, scene.spacing()).iter().product::<u64>();
        let particles = scene.blocks.iter().map(|block| count(block.region().corners())).sum();
        self.check(scene, particles, 0)
    }

    /// Refuses a scene with so many particles at the start, and so many bytes of maps.
    pub(super) fn check(&self, scene: &Scene, particles: u64, maps: u64) -> Result<(), Error> {
        let added = emitted(scene, self.end).min(u64::MAX - particles);
        let all = particles + added;
        let needed = all.saturating_mul(BYTES_PER_PARTICLE).saturating_add(maps + BYTES_OF_PROGRAM);
        if needed <= self.bytes {
            return Ok(());
        }
        let of_emitters = match added {
            0 => String::new(),
            _ => format!(", {} of them from emitters until {} s", thousands(added), self.end),
        };
        let reason = format!(
            "the run would need about {}, more than `max_memory`, {}: {} particles{of_emitters}, and {} of maps; take \
             a larger particle_radius, less fluid or larger cells (bake.cell_size), or allow more",
            bytes(needed),
            bytes(self.bytes),
            thousands(all),
            bytes(maps)
        );
        Err(Error::Scene { place: "particle_radius".into(), reason })
    }
}

/// Bytes of maps, each once.
pub fn of_maps<'a>(maps: impl Iterator<Item = &'a Arc<VolumeMap>>) -> u64 {
    let mut maps: Vec<_> = maps.collect();
    maps.sort_by_key(|map| Arc::as_ptr(map));
    maps.dedup_by(|a, b| Arc::ptr_eq(a, b));
    maps.iter().map(|map| map.memory_bytes() as u64).sum()
}

/// Particles that the emitters of a scene add until a time, seconds, at most.
pub fn emitted(scene: &Scene, end: f64) -> u64 {
    let of = |settings: &EmitterSettings| {
        let emitter = nozzle::emitter(settings, scene.rest_spacing());
        let seconds = (settings.stop.unwrap_or(end).min(end) - settings.start).max(0.0);
        // The first layer leaves at once.
        let most = seconds * emitter.particles_per_second() + emitter.particles_per_layer();
        (most.ceil() as u64).min(settings.max_particles)
    };
    scene.emitters.iter().map(of).fold(0, u64::saturating_add)
}
