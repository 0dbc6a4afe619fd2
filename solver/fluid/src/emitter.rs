//! Nozzles at work: layers of particles that leave at the moments when the flow has moved on by one spacing.
//!
//! A particle only leaves where there is room for it ([`Room`]). One for which there is none waits in its place until
//! the next layer is due; if there is still none, it is held back for good and counted.

use crate::room::Room;
use serde::{Deserialize, Serialize};
use volmap_runtime::DVec3;

/// What a nozzle gives, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Jet {
    /// Where it flows; of length 1.
    pub direction: DVec3,
    /// Speed, m/s.
    pub speed: f64,
    /// Places of the particles in the nozzle, metres, of one layer after the other; after the last comes the first
    /// again. At least one layer.
    pub layers: Vec<Vec<DVec3>>,
    /// Distance of a layer from the next, metres: the fluid's spacing at rest.
    pub spacing: f64,
    /// When the first layer leaves, seconds.
    pub start: f64,
    /// No layer from this on, seconds.
    pub stop: Option<f64>,
    /// No layer that would exceed this number.
    pub max_particles: u64,
}

/// A nozzle at work. It is deterministic and doesn't depend on the steps: layer k is due at start + k spacing /
/// speed, and lies where the flow has carried it since.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// How far it is; what a checkpoint has to keep.
    pub state: EmitterState,
    jet: Jet,
}

/// How far an emitter is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EmitterState {
    /// Layers that were due.
    pub layers: u64,
    /// Particles that left.
    pub particles: u64,
    /// Particles for which there was no room.
    #[serde(default)]
    pub held: u64,
    /// Particles of the last layer that wait for room: their numbers in it.
    #[serde(default)]
    pub waiting: Vec<u32>,
}

/// Part of a layer's distance that rounding may take from the end.
const SLACK: f64 = 1e-9;

impl Emitter {
    /// Before its first layer.
    pub fn new(jet: Jet) -> Emitter {
        Emitter { state: EmitterState::default(), jet }
    }

    /// Velocity of what leaves it, m/s.
    pub fn velocity(&self) -> DVec3 {
        self.jet.speed * self.jet.direction
    }

    /// Places in the nozzle from which particles leave, metres; of all layers until they repeat.
    pub fn places(&self) -> impl Iterator<Item = DVec3> {
        self.jet.layers.iter().flatten().copied()
    }

    /// Particles of a layer, in the mean.
    pub fn particles_per_layer(&self) -> f64 {
        self.places().count() as f64 / self.jet.layers.len().max(1) as f64
    }

    /// Particles in a second, if there is room for all.
    pub fn particles_per_second(&self) -> f64 {
        self.particles_per_layer() * self.jet.speed / self.jet.spacing
    }

    /// Whether no more will come.
    pub fn is_done(&self) -> bool {
        self.state.waiting.is_empty() && self.has_no_layer()
    }

    /// Whether no layer will come after the last.
    fn has_no_layer(&self) -> bool {
        let layers = |seconds: f64| seconds * self.jet.speed / self.jet.spacing;
        let ended = self
            .jet
            .stop
            .is_some_and(|stop| self.state.layers as f64 >= layers(stop - self.jet.start) - SLACK);
        let EmitterState { particles, waiting, .. } = &self.state;
        ended || particles + waiting.len() as u64 + self.next().len() as u64 > self.jet.max_particles
    }

    /// Where the particles are, at `time` (the end of a step, seconds), that leave now: those that waited and those
    /// that are due since the last call. `room` says what is near their places. Layers come one after the other.
    pub fn emit(&mut self, time: f64, room: impl Fn(&[DVec3]) -> Room) -> Vec<DVec3> {
        let mut out = Vec::new();
        if self.due(self.state.layers) > time {
            self.leave(DVec3::ZERO, &room, &mut out);
        }
        while self.due(self.state.layers) <= time {
            // Its place belongs to the next one now.
            self.state.held += std::mem::take(&mut self.state.waiting).len() as u64;
            if self.has_no_layer() {
                break;
            }
            let Jet { direction, speed, spacing, start, .. } = self.jet;
            let travelled = (time - start) * speed - self.state.layers as f64 * spacing;
            self.state.waiting = (0..self.next().len() as u32).collect();
            self.state.layers += 1;
            self.leave(travelled.max(0.0) * direction, &room, &mut out);
        }
        out
    }

    /// Places in the nozzle whose particles wait for room, metres.
    pub fn waiting(&self) -> Vec<DVec3> {
        let layer = self.last(self.state.layers);
        self.state.waiting.iter().map(|&n| layer[n as usize]).collect()
    }

    /// Adds to `out` those that wait for which there is room, moved from their places in the nozzle.
    fn leave(&mut self, moved: DVec3, room: impl Fn(&[DVec3]) -> Room, out: &mut Vec<DVec3>) {
        if self.state.waiting.is_empty() {
            return;
        }
        let places: Vec<DVec3> = self.waiting().into_iter().map(|place| place + moved).collect();
        let waiting = std::mem::take(&mut self.state.waiting);
        let (mut room, mut still) = (room(&places), Vec::new());
        for (&n, &place) in waiting.iter().zip(&places) {
            if room.take(place) {
                out.push(place);
            } else {
                still.push(n);
            }
        }
        self.state.particles += (waiting.len() - still.len()) as u64;
        self.state.waiting = still;
    }

    fn next(&self) -> &[DVec3] {
        self.layer(self.state.layers)
    }

    fn layer(&self, number: u64) -> &[DVec3] {
        let count = self.jet.layers.len().max(1) as u64;
        self.jet.layers.get((number % count) as usize).map_or(&[], Vec::as_slice)
    }

    /// The last of so many layers.
    fn last(&self, layers: u64) -> &[DVec3] {
        self.layer(layers.wrapping_sub(1))
    }

    /// Whether a state can be one of this emitter.
    pub(crate) fn can_be_in(&self, state: &EmitterState) -> bool {
        let layer = self.last(state.layers);
        state.waiting.iter().all(|&n| (n as usize) < layer.len())
    }

    fn due(&self, layer: u64) -> f64 {
        self.jet.start + layer as f64 * self.jet.spacing / self.jet.speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jet() -> Jet {
        Jet {
            direction: DVec3::new(0.6, 0.0, 0.8),
            speed: 2.0,
            layers: vec![(0..8_u32).map(|n| DVec3::new(0.0, 0.05 * f64::from(n), 0.0)).collect()],
            spacing: 0.05,
            start: 0.5,
            stop: None,
            max_particles: 1_000_000,
        }
    }

    /// All layers, carried to the last of the times by the flow.
    fn run(jet: Jet, times: &[f64]) -> Vec<DVec3> {
        let mut emitter = Emitter::new(jet);
        let end = times[times.len() - 1];
        let mut out = Vec::new();
        for &time in times {
            let moved = (end - time) * emitter.velocity();
            out.extend(emitter.emit(time, |_| Room::default()).into_iter().map(|at| at + moved));
        }
        out
    }

    #[test]
    fn layers_are_spaced_exactly_whatever_the_steps() {
        let even: Vec<f64> = (1..=1000).map(|i| f64::from(i) * 0.001).collect();
        let uneven: Vec<f64> = (1..=7).map(|i| f64::from(i * i) / 49.0).collect();
        let (a, b) = (run(jet(), &even), run(jet(), &uneven));
        // 0.5 s at 2 m/s: layers at 0, 0.05, .. 1 m.
        assert_eq!((a.len(), b.len()), (21 * 8, 21 * 8));
        assert!(a.iter().zip(&b).all(|(a, b)| a.distance(*b) < 1e-12));
        for (near, far) in a[8..].iter().zip(&a) {
            assert!((*far - *near - 0.05 * jet().direction).length() < 1e-12);
        }
    }

    #[test]
    fn it_ends_at_its_time_or_number() {
        // 0.1 s at 2 m/s are four layers' distances.
        assert_eq!(run(Jet { stop: Some(0.6), ..jet() }, &[0.4, 9.0]).len(), 4 * 8);
        assert_eq!(run(Jet { max_particles: 20, ..jet() }, &[0.4, 9.0]).len(), 2 * 8);
        assert_eq!(run(jet(), &[0.4]).len(), 0);
    }

    #[test]
    fn layers_take_turns() {
        let [one, two] = [vec![DVec3::ZERO], vec![DVec3::Y, 2.0 * DVec3::Y]];
        let emitter = Emitter::new(Jet { layers: vec![one, two], ..jet() });
        assert_eq!(emitter.particles_per_layer(), 1.5);
        assert_eq!(emitter.particles_per_second(), 60.0);
        assert_eq!(run(Jet { layers: emitter.jet.layers, stop: Some(1.0), ..jet() }, &[9.0]).len(), 30);
    }
}
