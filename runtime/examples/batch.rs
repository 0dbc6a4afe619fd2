//! Thousands of particles at once, from distance and volume to the density of a wall:
//!
//! ```text
//! cargo run --release -p volmap-runtime --example batch
//! ```

mod ball;

use std::error::Error;
use volmap_runtime::{
    ClosureKind, DVec3, Kernel, KernelKind, Sample, SurfaceWithGradient, Values, VolumeMap,
};

/// Particle radius and support radius of the kernel, metres.
const PARTICLE_RADIUS: f64 = 0.025;
const SUPPORT_RADIUS: f64 = 0.1;

/// The program.
pub fn main() -> Result<(), Box<dyn Error>> {
    // `mirror` takes a map of a quarter of the kernel's support radius, and checks that it got one.
    let kind = ClosureKind::Mirror;
    let map = VolumeMap::from_asset(&ball::asset(kind.map_radius(SUPPORT_RADIUS)))?;
    let closure = map.closure(kind, Kernel::new(KernelKind::CubicSpline, SUPPORT_RADIUS), PARTICLE_RADIUS)?;

    // Sorted by place, as a solver keeps its particles.
    let along = |n: u32| -0.3 + 2.0 * PARTICLE_RADIUS * f64::from(n);
    let mut particles: Vec<DVec3> =
        (0..12 * 12 * 12).map(|n| DVec3::new(along(n % 12), along(n / 12 % 12), along(n / 144))).collect();

    // The type of the answers is the question: distance and volume are enough to find who is in the ball.
    let mut values: Vec<Values> = Vec::new();
    map.sample_batch(&particles, &mut values);
    let mut values = values.iter();
    particles.retain(|_| values.next().is_some_and(|at| at.distance > 0.0));

    // And all that a closure needs.
    let mut samples: Vec<Sample<SurfaceWithGradient>> = Vec::new();
    map.sample_batch(&particles, &mut samples);
    let mut touching = 0;
    for (particle, sample) in particles.iter().zip(&samples) {
        let Sample::Near(near) = sample else { continue };
        let Some(at) = closure.density(near, *particle) else { continue };
        assert!(at.density > 0.0 && at.gradient.dot(near.surface.normal) <= 0.0);
        touching += 1;
    }
    println!("{} particles outside of the ball, {touching} feel it", particles.len());
    assert!(touching > 50);
    Ok(())
}
