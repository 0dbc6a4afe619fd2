//! How Phi and V are found at the points of the lattice: Phi exactly, V by Eq. 12 of Bender et al. 2020 where that must be.
//!
//! V is the convolution of the ball with gamma*, which both change over lengths of r only, whatever edges, corners and thin
//! walls the distance has. So in cells that are small enough the cubic through V at their 32 nodes is V, and no smaller
//! ones need integrals. The error is at most 0.33 % of the ball in cells of r/2 (the test below: a flat wall, edges, a corner,
//! a thin plate, a small ball), and a sixteenth of that from one level to the next.

use super::cells::Judge;
use super::known::Known;
use super::lattice::{FineLattice, Key, LevelCell};
use super::probes;
use super::samples::Samples;
use crate::sdf::SignedDistance;
use crate::watch::Cancelled;
use rayon::prelude::*;
use volmap_runtime::layout::serendipity::{NODES, shape};

/// From this tolerance on cells of half of the support radius are small enough: V's error there, where fluid can be, is at
/// most 0.33 % of the ball, which leaves more than half of the tolerance to the fit.
const HALF_FROM: f64 = 8e-3;

/// The level of the largest cells in which the cubic through V at the nodes is exact enough for a tolerance (part of the
/// ball).
pub fn polynomial_level(lattice: &FineLattice, radius: f64, tolerance: f64) -> u32 {
    let half = 0.5 * radius * (1.0 + 1e-9);
    let largest = half * (tolerance / HALF_FROM).powf(0.25).min(1.0);
    let is_small = |level: &u32| lattice.cell_size(*level).max_element() <= largest;
    (0..lattice.finest()).find(is_small).unwrap_or(lattice.finest())
}

impl<D: SignedDistance> Judge<'_, D> {
    /// Makes the distance known at the nodes and probes of cells.
    pub(super) fn ask_distances(&self, cells: &[LevelCell], known: &mut Known) -> Result<(), Cancelled> {
        let of_cell = |&cell| self.lattice.nodes(cell).into_iter().chain(self.lattice.probes(cell));
        let points = cells.par_iter().flat_map_iter(of_cell);
        known.distance.ask_distance(points, &self.lattice, self.phi, self.work)
    }

    /// Makes the volume known at the nodes and probes of cells whose distances are known, and of those that will be `split`
    /// what their children need.
    pub(super) fn ask_volumes(
        &self,
        cells: &[LevelCell],
        split: &[LevelCell],
        known: &mut Known,
    ) -> Result<(), Cancelled> {
        let level = self.polynomial_level;
        let own = cells.par_iter().filter(|cell| cell.level <= level);
        let holders = split.par_iter().filter(|cell| cell.level == level);
        let of_holder = |&cell: &LevelCell| self.lattice.nodes(cell);
        let keys = own.flat_map_iter(|&cell| self.integrated(cell)).chain(holders.flat_map_iter(of_holder));
        self.integrate(keys, known)?;
        let interpolated = cells.par_iter().filter(|cell| cell.level >= level);
        let values: Vec<Vec<(Key, f64)>> =
            interpolated.map(|&cell| self.interpolated(cell, &known.volume)).collect();
        values.into_iter().flatten().for_each(|(key, value)| known.volume.insert_new(key, value));
        Ok(())
    }

    /// Where a cell's V is integrated.
    fn integrated(&self, cell: LevelCell) -> impl Iterator<Item = Key> + use<D> {
        let probes = (cell.level < self.polynomial_level).then(|| self.lattice.probes(cell));
        self.lattice.nodes(cell).into_iter().chain(probes.into_iter().flatten())
    }

    fn integrate(&self, keys: impl ParallelIterator<Item = Key>, known: &mut Known) -> Result<(), Cancelled> {
        let missing = known.volume.missing(keys);
        let volume = |&key: &Key| {
            self.work.check()?;
            Ok(self.volume(key, known.distance.at(key)))
        };
        let volumes = missing.par_iter().map(volume).collect::<Result<_, Cancelled>>()?;
        known.volume.insert(&missing, volumes);
        Ok(())
    }

    /// Eq. 12; without any work where the ball is all fluid or all solid.
    fn volume(&self, key: Key, phi: f64) -> f64 {
        match phi / self.radius {
            q if q >= 2.0 => 0.0,
            q if q <= -1.0 => self.ball,
            _ => self.integrator.volume(self.lattice.position(key)),
        }
    }

    /// V at the points of a cell at which it isn't known, by the polynomial of the cell that holds it.
    fn interpolated(&self, cell: LevelCell, volume: &Samples) -> Vec<(Key, f64)> {
        let levels = cell.level - self.polynomial_level;
        let holder = LevelCell { level: self.polynomial_level, at: cell.at >> levels };
        let nodes = self.lattice.nodes(holder).map(|key| volume.at(key));
        let unknown = |key: &Key| volume.get(*key).is_none();
        if levels == 0 {
            let keys = self.lattice.probes(cell).into_iter().zip(probes::values(&nodes));
            return keys.filter(|(key, _)| unknown(key)).collect();
        }
        let (center, size) = (self.lattice.center(holder), self.lattice.cell_size(holder.level));
        let value = |key: Key| {
            let parts: [f64; NODES] = shape((self.lattice.position(key) - center) / (0.5 * size));
            (key, parts.iter().zip(&nodes).map(|(part, value)| part * value).sum())
        };
        let keys = self.lattice.nodes(cell).into_iter().chain(self.lattice.probes(cell));
        keys.filter(unknown).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::cells::DEPTH;
    use super::*;
    use crate::sdf::Neighbours;
    use crate::volume_map::oracle::volume_on_exact_distance;
    use crate::volume_map::quadrature::Rule;
    use glam::DVec3;
    use std::f64::consts::PI;
    use volmap_runtime::layout::serendipity::node;

    /// A name and a signed distance; r = 1.
    type Shape = (&'static str, fn(DVec3) -> f64);

    const SHAPES: [Shape; 6] = [
        ("wall", |x| x.dot(DVec3::new(0.48, 0.6, 0.64))),
        ("convex edge", |x| outside(DVec3::new(x.x, x.y, -9.0))),
        ("concave edge", |x| -outside(DVec3::new(-x.x, -x.y, -9.0))),
        ("corner", outside),
        ("plate of r / 8", |x| x.dot(DVec3::new(0.48, 0.6, 0.64)).abs() - 1.0 / 16.0),
        ("ball of r / 2", |x| x.length() - 0.5),
    ];

    /// To the octant of negative coordinates.
    fn outside(x: DVec3) -> f64 {
        x.max(DVec3::ZERO).length() + x.max_element().min(0.0)
    }

    #[test]
    fn volumes_are_cubics_in_cells_of_half_of_the_support_radius() {
        let rule = Rule::Chord(20).points();
        let size = 0.5;
        for (name, phi) in SHAPES {
            let volume = |x: DVec3| volume_on_exact_distance(&phi, &rule, 1.0, x, &mut Neighbours::default());
            let mut largest = 0.0f64;
            for at in (0..12)
                .map(|n| DVec3::new(0.13, 0.29, 0.07) + 0.17 * f64::from(n) * DVec3::new(1.0, 0.5, 0.3))
            {
                let place = |xi: DVec3| at + 0.5 * size * xi;
                let nodes: [f64; NODES] = std::array::from_fn(|a| volume(place(node(a))));
                for (probe, found) in probes::values(&nodes).iter().enumerate() {
                    let x = place(probes::place(probe));
                    // Where fluid can be.
                    if phi(x) < -DEPTH {
                        continue;
                    }
                    let miss = (found - volume(x)).abs();
                    largest = largest.max(miss / (4.0 / 3.0 * PI));
                }
            }
            assert!(largest < 3.3e-3 && largest > 1e-4, "{name}: {largest}");
        }
    }
}
