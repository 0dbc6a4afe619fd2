//! From the emitter in a scene to the emitter of a simulation: the lattice of a layer's particles across the flow.

use super::fluid::{EmitterSettings, Nozzle};
use glam::{DVec2, DVec3};
use volmap_fluid::emitter::{Emitter, Jet};
use volmap_fluid::lattice;

/// An emitter that hasn't emitted yet. The settings must have been checked.
pub fn emitter(settings: &EmitterSettings, particle_radius: f64) -> Emitter {
    let direction = DVec3::from(settings.direction).normalize_or(DVec3::NEG_Y);
    let spacing = 2.0 * particle_radius;
    Emitter::new(Jet {
        direction,
        speed: settings.speed,
        layer: layer(settings, direction, spacing),
        spacing,
        start: settings.start,
        stop: settings.stop,
        max_particles: settings.max_particles,
    })
}

/// A square lattice across the direction, centred.
fn layer(settings: &EmitterSettings, direction: DVec3, spacing: f64) -> Vec<DVec3> {
    let right = direction.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    let up = right.cross(direction);
    let [width, height] = match settings.nozzle {
        Nozzle::Circle { radius } => [2.0 * radius; 2],
        Nozzle::Box { width, height } => [width, height],
    };
    let counts = [width, height].map(|edge| ((edge / spacing + 1e-6).floor()).max(1.0) as u64);
    let first = -0.5 * spacing * DVec2::new(counts[0] as f64 - 1.0, counts[1] as f64 - 1.0);
    let grid = lattice::points(first.extend(0.0), spacing, [counts[0], counts[1], 1]);
    // Particles lie within the opening.
    let fits = |at: &DVec3| match settings.nozzle {
        Nozzle::Circle { radius } => at.length() <= radius - 0.5 * spacing * (1.0 - 1e-6),
        Nozzle::Box { .. } => true,
    };
    let inside: Vec<DVec3> = grid.filter(fits).collect();
    let inside = if inside.is_empty() { vec![DVec3::ZERO] } else { inside };
    inside.into_iter().map(|at| DVec3::from(settings.position) + at.x * right + at.y * up).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nozzle_is_centred_and_across_its_direction() {
        for nozzle in [Nozzle::Circle { radius: 0.1 }, Nozzle::Box { width: 0.2, height: 0.1 }] {
            for direction in [[3.0, 0.0, 4.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]] {
                let position = [1.0, 2.0, 3.0];
                let settings = EmitterSettings { position, nozzle, direction, ..EmitterSettings::default() };
                let emitter = emitter(&settings, 0.025);
                let middle = emitter.layer().iter().sum::<DVec3>() / emitter.layer().len() as f64;
                assert!(middle.distance(position.into()) < 1e-12);
                let across = |at: &DVec3| (*at - middle).dot(emitter.velocity()).abs() < 1e-12;
                assert!(emitter.layer().iter().all(across));
            }
        }
    }

    #[test]
    fn a_box_holds_whole_spacings() {
        let nozzle = Nozzle::Box { width: 0.2, height: 0.1 };
        let settings = EmitterSettings { nozzle, ..EmitterSettings::default() };
        assert_eq!(emitter(&settings, 0.025).layer().len(), 4 * 2);
    }
}
