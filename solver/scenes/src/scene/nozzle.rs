//! From the emitter in a scene to the emitter of a simulation: the layers of particles across the flow.
//!
//! A nozzle gives speed times area. Each layer is a square lattice of the fluid's spacing a across the flow, and layers
//! are a apart along it, so that no particles are closer than in the lattice at rest. A lattice that stays in one place
//! would give a whole number of particles in every layer, mostly too few: so it is shifted from layer to layer, to
//! where the particles of all layers so far are the volume that has flowed so far, to the nearest particle. After some
//! layers the sum is exact to 0.2 %, and they begin again. An opening of whole spacings has one layer.

use super::fluid::{EmitterSettings, Nozzle};
use glam::{DVec2, DVec3};
use serde::Serialize;
use volmap_fluid::emitter::{Emitter, Jet};

/// What a nozzle gives, m^3/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Flow {
    /// Speed times area.
    pub asked: f64,
    /// Particles times their volume, if there is room for all.
    pub given: f64,
}

/// Part by which the particles of all layers may differ from the area times the speed.
const EXACT: f64 = 0.002;
/// Layers at most until they repeat.
const MOST_LAYERS: usize = 512;
/// Shifts that are tried for a layer.
const SHIFTS: u32 = 64;

/// An emitter that hasn't emitted yet, for a fluid of this spacing at rest, metres. The settings must have been
/// checked.
pub fn emitter(settings: &EmitterSettings, spacing: f64) -> Emitter {
    let direction = DVec3::from(settings.direction).normalize_or(DVec3::NEG_Y);
    let right = direction.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    let up = right.cross(direction);
    let place = |at: DVec2| DVec3::from(settings.position) + at.x * right + at.y * up;
    let layers = layers(settings.nozzle, spacing);
    Emitter::new(Jet {
        direction,
        speed: settings.speed,
        layers: layers.into_iter().map(|layer| layer.into_iter().map(place).collect()).collect(),
        spacing,
        start: settings.start,
        stop: settings.stop,
        max_particles: settings.max_particles,
    })
}

/// What an emitter is asked for, and what it gives.
pub fn flow(settings: &EmitterSettings, spacing: f64, emitter: &Emitter) -> Flow {
    Flow {
        asked: settings.speed * area(settings.nozzle),
        given: emitter.particles_per_second() * spacing.powi(3),
    }
}

fn area(nozzle: Nozzle) -> f64 {
    match nozzle {
        Nozzle::Circle { radius } => std::f64::consts::PI * radius * radius,
        Nozzle::Box { width, height } => width * height,
    }
}

/// Layers that together hold as many particles as belong into the opening times their number.
fn layers(nozzle: Nozzle, spacing: f64) -> Vec<Vec<DVec2>> {
    let wanted = area(nozzle) / (spacing * spacing);
    let (mut layers, mut total) = (Vec::new(), 0.0);
    loop {
        let due = wanted * (layers.len() as f64 + 1.0);
        let missing = |count: usize| (total + count as f64 - due).abs();
        let first = layers.len() as u32 * SHIFTS;
        let mut best = Vec::new();
        for n in 0..SHIFTS {
            let layer = layer(nozzle, spacing, shift(first + n));
            if n == 0 || missing(layer.len()) < missing(best.len()) - 1e-9 {
                best = layer;
            }
            if missing(best.len()) <= 0.5_f64.max(0.5 * EXACT * wanted) {
                break;
            }
        }
        total += best.len() as f64;
        layers.push(best);
        if (total - due).abs() <= EXACT * due || layers.len() >= MOST_LAYERS {
            return layers;
        }
    }
}

/// Shifts of the lattice from one that has the nozzle's middle between four of its points, in spacings: the middle of a
/// cell, an edge, a point, then evenly spread (R2, Roberts 2018: powers of 1 over the plastic number).
fn shift(n: u32) -> DVec2 {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    match n {
        0 => DVec2::ZERO,
        1 => DVec2::new(0.5, 0.0),
        2 => DVec2::new(0.0, 0.5),
        3 => DVec2::new(0.5, 0.5),
        _ => (f64::from(n) * STEP).fract(),
    }
}

/// The points of a square lattice in the opening. Along an edge of whole spacings it stays where it fills the edge.
fn layer(nozzle: Nozzle, spacing: f64, shift: DVec2) -> Vec<DVec2> {
    let half = match nozzle {
        Nozzle::Circle { radius } => DVec2::splat(radius),
        Nozzle::Box { width, height } => 0.5 * DVec2::new(width, height),
    };
    let along = |axis: usize| -> Vec<f64> {
        let edge = 2.0 * half[axis] / spacing;
        let is_whole = (edge - edge.round()).abs() < 1e-6 * edge.max(1.0);
        if is_whole && matches!(nozzle, Nozzle::Box { .. }) {
            let count = edge.round();
            return (0..count as u32).map(|n| spacing * (f64::from(n) + 0.5 - 0.5 * count)).collect();
        }
        let reach = (0.5 * edge).ceil() as i32 + 1;
        let points = (-reach..reach).map(|n| spacing * (f64::from(n) + 0.5 + shift[axis]));
        points.filter(|x| *x >= -half[axis] && *x < half[axis]).collect()
    };
    let (across, up) = (along(0), along(1));
    let fits = |at: &DVec2| match nozzle {
        Nozzle::Circle { radius } => at.length_squared() <= radius * radius,
        Nozzle::Box { .. } => true,
    };
    up.iter().flat_map(|&y| across.iter().map(move |&x| DVec2::new(x, y))).filter(fits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RP: f64 = 0.025;

    fn with(nozzle: Nozzle) -> EmitterSettings {
        EmitterSettings { nozzle, ..EmitterSettings::default() }
    }

    /// The layers that leave in so many layers' time, each where the flow has carried it.
    fn jet(nozzle: Nozzle, layers: usize) -> Vec<DVec3> {
        let all = super::layers(nozzle, 2.0 * RP);
        let layer = |k: usize| all[k % all.len()].iter().map(move |at| at.extend(-2.0 * RP * k as f64));
        (0..layers).flat_map(layer).collect()
    }

    fn openings() -> Vec<Nozzle> {
        let circle = |radii: f64| Nozzle::Circle { radius: radii * RP };
        let mut all: Vec<Nozzle> = (4..=48).map(|n| circle(0.25 * f64::from(n))).collect();
        for width in [2.0, 2.9, 3.0, 3.1, 7.2, 11.0, 16.0] {
            for height in [2.0, 3.99, 4.0, 7.2, 13.7] {
                all.push(Nozzle::Box { width: width * RP, height: height * RP });
            }
        }
        all
    }

    #[test]
    fn nozzles_give_speed_times_area() {
        for nozzle in openings() {
            let settings = with(nozzle);
            let Flow { asked, given } = flow(&settings, 2.0 * RP, &emitter(&settings, 2.0 * RP));
            assert!((given / asked - 1.0).abs() < 0.003, "{nozzle:?}: {given} {asked}");
            // At any time to half a row of particles, which a shift of a box gives or takes as a whole.
            let row = match nozzle {
                Nozzle::Circle { .. } => 1.5,
                Nozzle::Box { width, height } => 1.0 + 0.25 * width.max(height) / RP,
            };
            let volume = (2.0 * RP).powi(3);
            for layers in [1, 5, 17, 40, 200] {
                let due = area(nozzle) * 2.0 * RP * layers as f64 / volume;
                let error = (jet(nozzle, layers).len() as f64 - due).abs();
                assert!(error <= row.max(0.004 * due), "{nozzle:?}, {layers} layers: {error} of {due}");
            }
        }
    }

    #[test]
    fn particles_are_in_the_opening_and_no_closer_than_the_lattice() {
        for nozzle in openings() {
            let all = jet(nozzle, 8);
            let half = match nozzle {
                Nozzle::Circle { radius } => {
                    assert!(all.iter().all(|at| at.truncate().length() <= radius));
                    [radius; 2]
                }
                Nozzle::Box { width, height } => [0.5 * width, 0.5 * height],
            };
            assert!(all.iter().all(|at| at.x.abs() <= half[0] && at.y.abs() <= half[1]));
            for (n, a) in all.iter().enumerate() {
                assert!(all[..n].iter().all(|b| a.distance(*b) > 2.0 * RP * (1.0 - 1e-9)), "{nozzle:?}");
            }
        }
    }

    #[test]
    fn a_nozzle_lies_across_its_direction() {
        for direction in [[3.0, 0.0, 4.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]] {
            let position = [1.0, 2.0, 3.0];
            let settings = EmitterSettings { position, direction, ..EmitterSettings::default() };
            let emitter = emitter(&settings, 2.0 * RP);
            let across = |at: DVec3| (at - DVec3::from(position)).dot(emitter.velocity()).abs() < 1e-12;
            assert!(emitter.places().all(across));
        }
    }

    #[test]
    fn a_box_of_whole_spacings_has_one_layer() {
        let emitter = emitter(&with(Nozzle::Box { width: 0.2, height: 0.1 }), 2.0 * RP);
        assert_eq!(emitter.places().count(), 4 * 2);
        let middle = emitter.places().sum::<DVec3>() / 8.0;
        assert!(middle.length() < 1e-12);
    }
}
