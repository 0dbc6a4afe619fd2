//! The fluid's particles: structure of arrays, in the order of the cells.

use crate::channels::{Channels, reorder};
use volmap_runtime::DVec3;

/// Particles that are worked on together where only their own values count.
pub(crate) const CHUNK: usize = 1024;

/// The state that one step hands to the next. All arrays are of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Centres, metres.
    pub positions: Vec<DVec3>,
    /// Velocities, m/s.
    pub velocities: Vec<[f32; 3]>,
    /// p / (rho_0 D^2) of the density solve, m^2/s^2, D the relative density: where the next solve begins.
    pub pressures: Vec<f32>,
    /// What forces have each particle carry.
    pub channels: Channels,
    /// Names of the particles: the order in which they came.
    pub ids: Vec<u32>,
    /// The next name.
    pub next_id: u32,
}

impl Particles {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Adds particles at rest pressure.
    pub fn add(&mut self, positions: &[DVec3], velocities: &[[f32; 3]]) {
        let count = self.len() + positions.len();
        self.positions.extend_from_slice(positions);
        self.velocities.extend_from_slice(velocities);
        self.pressures.resize(count, 0.0);
        self.channels.resize(count);
        self.ids.extend((0..positions.len() as u32).map(|i| self.next_id + i));
        self.next_id += positions.len() as u32;
    }

    /// Whether all lists have one length.
    pub fn is_even(&self) -> bool {
        let count = self.len();
        let others = [self.velocities.len(), self.pressures.len(), self.ids.len()];
        others.iter().all(|&other| other == count) && self.channels.are_of(count)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let own = size_of::<DVec3>() + size_of::<[f32; 3]>() + 2 * size_of::<f32>();
        self.positions.capacity() * (own + self.channels.bytes_of_particle())
    }

    /// Keeps the particles for which `is_kept` says so of their numbers, with their densities; how many are removed.
    pub(crate) fn retain(
        &mut self,
        densities: &mut Vec<f32>,
        is_kept: impl Fn(&Particles, usize) -> bool,
    ) -> usize {
        let count = self.len();
        if (0..count).all(|n| is_kept(self, n)) {
            return 0;
        }
        let kept: Vec<u32> = (0..count).filter(|&n| is_kept(self, n)).map(|n| n as u32).collect();
        self.reorder(&kept, &mut Particles::default());
        *densities = kept.iter().map(|&old| densities[old as usize]).collect();
        count - kept.len()
    }

    /// Puts the particles into a new order, which may leave some out: old indices. `spare` is room, which becomes
    /// what was.
    pub fn reorder(&mut self, order: &[u32], spare: &mut Particles) {
        reorder(&self.positions, order, &mut spare.positions);
        reorder(&self.velocities, order, &mut spare.velocities);
        reorder(&self.pressures, order, &mut spare.pressures);
        self.channels.reorder_into(order, &mut spare.channels);
        reorder(&self.ids, order, &mut spare.ids);
        spare.next_id = self.next_id;
        std::mem::swap(self, spare);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::{ChannelDeclaration, Initial};

    #[test]
    fn everything_goes_with_its_particle() {
        let declare = |name, initial| ChannelDeclaration { name, initial, in_frames: true };
        let mut particles = Particles::default();
        let at = |n: u32| DVec3::new(f64::from(n), 0.0, 0.0);
        particles.add(&[at(0), at(1), at(2)], &[[0.0; 3], [1.0; 3], [2.0; 3]]);
        particles.channels.declare(declare("mark", Initial::Number(9.0)), 3).unwrap();
        particles.channels.declare(declare("spin", Initial::Vector([9.0; 3])), 3).unwrap();
        particles.channels.numbers_mut("mark").copy_from_slice(&[0.0, 1.0, 2.0]);
        particles.channels.vectors_mut("spin").copy_from_slice(&[[0.0; 3], [1.0; 3], [2.0; 3]]);
        let mut spare = Particles::default();
        for order in [&[2, 0, 1][..], &[1, 2, 0], &[2, 0]] {
            particles.reorder(order, &mut spare);
            let ids: Vec<f32> = particles.ids.iter().map(|&id| id as f32).collect();
            assert!(particles.positions.iter().map(|x| x.x as f32).eq(ids.iter().copied()));
            assert!(particles.velocities.iter().map(|v| v[0]).eq(ids.iter().copied()));
            assert_eq!(particles.channels.numbers_mut("mark"), ids);
            assert!(particles.channels.vectors_mut("spin").iter().map(|s| s[2]).eq(ids.iter().copied()));
        }
        particles.add(&[at(3)], &[[3.0; 3]]);
        assert_eq!(particles.channels.numbers_mut("mark")[2], 9.0, "a new one begins as declared");
        assert!(particles.is_even());
    }
}
