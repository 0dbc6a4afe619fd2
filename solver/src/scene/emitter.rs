//! Nozzles: layers of a lattice that leave at the moments when the flow has moved on by one spacing.

use super::fluid::{EmitterSettings, Nozzle};
use super::lattice;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// A nozzle at work. It is deterministic and doesn't depend on the steps: layer k is due at start + k 2 rp /
/// speed, and lies where the flow has carried it since.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// Velocity of what leaves it, m/s.
    pub velocity: DVec3,
    /// How far it is; what a check-point has to keep.
    pub state: EmitterState,
    settings: EmitterSettings,
    direction: DVec3,
    /// Places of a layer in the nozzle.
    layer: Vec<DVec3>,
    spacing: f64,
}

/// How far an emitter is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EmitterState {
    /// Layers that left.
    pub layers: u64,
    /// Particles that left.
    pub particles: u64,
}

impl Emitter {
    /// Before its first layer. The settings must have been checked.
    pub fn new(settings: &EmitterSettings, particle_radius: f64) -> Emitter {
        let direction = DVec3::from(settings.direction).normalize_or(DVec3::NEG_Y);
        let spacing = 2.0 * particle_radius;
        Emitter {
            velocity: settings.speed * direction,
            state: EmitterState::default(),
            settings: settings.clone(),
            direction,
            layer: layer(settings, direction, spacing),
            spacing,
        }
    }

    /// Places of a layer in the nozzle, metres.
    pub fn layer(&self) -> &[DVec3] {
        &self.layer
    }

    /// Whether no more will come.
    pub fn is_done(&self) -> bool {
        let ended = self.settings.stop.is_some_and(|stop| self.due(self.state.layers) > stop);
        ended || self.state.particles + self.layer.len() as u64 > self.settings.max_particles
    }

    /// Where the particles are, at `time` (the end of a step, seconds), that left since the last call.
    pub fn emit(&mut self, time: f64) -> Vec<DVec3> {
        let mut out = Vec::new();
        while !self.is_done() && self.due(self.state.layers) <= time {
            let travelled =
                (time - self.settings.start) * self.settings.speed - self.state.layers as f64 * self.spacing;
            out.extend(self.layer.iter().map(|&place| place + travelled.max(0.0) * self.direction));
            self.state.layers += 1;
            self.state.particles += self.layer.len() as u64;
        }
        out
    }

    fn due(&self, layer: u64) -> f64 {
        self.settings.start + layer as f64 * self.spacing / self.settings.speed
    }
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
    // Particles keep within the opening.
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

    fn jet() -> EmitterSettings {
        EmitterSettings {
            position: [1.0, 2.0, 3.0],
            direction: [3.0, 0.0, 4.0],
            speed: 2.0,
            nozzle: Nozzle::Box { width: 0.2, height: 0.1 },
            start: 0.5,
            ..EmitterSettings::default()
        }
    }

    /// All layers, carried to `end` by the flow.
    fn run(settings: &EmitterSettings, steps: &[f64]) -> Vec<DVec3> {
        let mut emitter = Emitter::new(settings, 0.025);
        let end = steps[steps.len() - 1];
        let mut out = Vec::new();
        for &time in steps {
            let moved = (end - time) * emitter.velocity;
            out.extend(emitter.emit(time).into_iter().map(|at| at + moved));
        }
        out
    }

    #[test]
    fn layers_are_spaced_exactly_whatever_the_steps() {
        let even: Vec<f64> = (1..=1000).map(|i| f64::from(i) * 0.001).collect();
        let uneven: Vec<f64> = (1..=7).map(|i| f64::from(i * i) / 49.0).collect();
        let (a, b) = (run(&jet(), &even), run(&jet(), &uneven));
        // 0.5 s at 2 m/s: layers at 0, 0.05, .. 1 m; a layer has 4 x 2 particles.
        assert_eq!((a.len(), b.len()), (21 * 8, 21 * 8));
        assert!(a.iter().zip(&b).all(|(a, b)| a.distance(*b) < 1e-12));
        for (near, far) in a[8..].iter().zip(&a) {
            assert!((*far - *near - 0.05 * DVec3::new(0.6, 0.0, 0.8)).length() < 1e-12);
        }
    }

    #[test]
    fn a_nozzle_is_centred_and_across_its_direction() {
        for nozzle in [Nozzle::Circle { radius: 0.1 }, Nozzle::Box { width: 0.2, height: 0.1 }] {
            for direction in [[3.0, 0.0, 4.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]] {
                let settings = EmitterSettings { nozzle, direction, ..jet() };
                let emitter = Emitter::new(&settings, 0.025);
                let middle = emitter.layer().iter().sum::<DVec3>() / emitter.layer().len() as f64;
                assert!(middle.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-12);
                let across = |at: &DVec3| (*at - middle).dot(emitter.velocity).abs() < 1e-12;
                assert!(emitter.layer().iter().all(across));
            }
        }
    }

    #[test]
    fn it_ends_at_its_time_or_number() {
        let stopped = EmitterSettings { stop: Some(0.6), ..jet() };
        assert_eq!(run(&stopped, &[0.4, 9.0]).len(), 5 * 8);
        let limited = EmitterSettings { max_particles: 20, ..jet() };
        assert_eq!(run(&limited, &[0.4, 9.0]).len(), 2 * 8);
        assert_eq!(run(&jet(), &[0.4]).len(), 0);
    }
}
