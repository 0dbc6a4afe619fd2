//! The tree of a map's cells: split where measured errors are too large, and balanced.

use super::fit::Targets;
use super::lattice::{FineLattice, Key, LevelCell, PROBES, SHAPES, probe_place};
use super::measure::exact_normal;
use super::samples::Samples;
use super::volume::TreeIntegrator;
use crate::error::Error;
use crate::sdf::SignedDistance;
use crate::settings::Tolerances;
use crate::watch::{Cancelled, Work};
use glam::{DVec3, IVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::LazyLock;
use volmap_runtime::layout::FlatWall;
use volmap_runtime::layout::serendipity::{NODES, shape_and_gradient};

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Its children are in the tree.
    Split,
    /// In the band, with this wish for the form of its volume.
    Band(Wish),
    /// Deeper in the solid than the band.
    Solid,
    /// Farther from the solid than the band.
    Fluid,
}

/// Which form of the volume is good enough in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// The difference from a flat wall's.
    Plane,
    /// The volume itself.
    Plain,
    /// Either of them.
    Either,
}

/// What the cells are judged by.
pub struct Judge<'a, D> {
    /// All nodes and probes.
    pub lattice: FineLattice,
    /// Support radius, metres.
    pub radius: f64,
    /// Volume of the full ball by the rule, m^3.
    pub ball: f64,
    /// V_plane.
    pub wall: FlatWall,
    /// What a cell's errors may be.
    pub tolerances: Tolerances,
    /// What they may be in place, as a part of the tolerances.
    pub in_place: f64,
    /// The exact distance.
    pub phi: &'a D,
    /// Eq. 12.
    pub integrator: &'a TreeIntegrator<'a>,
    /// Bytes that cells and samples may take.
    pub max_memory: u64,
    /// Who may stop it.
    pub work: &'a Work,
}

/// What is known at the points of the lattice.
#[derive(Default)]
pub struct Known {
    /// Phi, metres.
    pub distance: Samples,
    /// V, m^3.
    pub volume: Samples,
}

/// All cells.
#[derive(Default)]
pub struct CellTree {
    /// Those of all levels, split ones too.
    pub cells: FxHashMap<LevelCell, State>,
}

/// Smaller cells aren't split for the normal, in support radii: beside a kink of the distance it is never right.
const NORMALS_DOWN_TO: f64 = 0.25;
/// Part of the support radius that points may lie in the solid and still count.
pub const DEPTH: f64 = 0.1;
/// Errors of a cubic through the nodes that a fit brings below the tolerance.
const BY_FIT: f64 = 3.0;
/// How much a place counts in a fit where no fluid is.
pub const REST: f64 = 0.05;
/// About: of a sample, and of a cell.
const BYTES_PER_SAMPLE: u64 = 40;
const BYTES_PER_CELL: u64 = 600;

impl<D: SignedDistance> Judge<'_, D> {
    /// Decides cells and, where they are split, all below them.
    ///
    /// # Errors
    /// More memory than is allowed; cancelled.
    pub fn decide(
        &self,
        mut cells: Vec<LevelCell>,
        tree: &mut CellTree,
        known: &mut Known,
    ) -> Result<(), Error> {
        while !cells.is_empty() {
            let states = self.states(&cells, known)?;
            let mut next = Vec::new();
            for (cell, state) in cells.into_iter().zip(states) {
                tree.cells.insert(cell, state);
                if state == State::Split {
                    next.extend(cell.children());
                }
            }
            self.check_memory(tree, known)?;
            cells = next;
        }
        Ok(())
    }

    fn check_memory(&self, tree: &CellTree, known: &Known) -> Result<(), Error> {
        let samples = (known.distance.count() + known.volume.count()) as u64;
        let needed = samples * BYTES_PER_SAMPLE + tree.cells.len() as u64 * BYTES_PER_CELL;
        match needed <= self.max_memory {
            true => Ok(()),
            false => Err(Error::Memory { needed, allowed: self.max_memory }),
        }
    }

    fn states(&self, cells: &[LevelCell], known: &mut Known) -> Result<Vec<State>, Error> {
        let lattice = self.lattice;
        let centers = cells.par_iter().map(|&cell| lattice.center_key(cell));
        known.distance.ask_distance(centers, &lattice, self.phi, self.work)?;
        let beyond = |&cell: &LevelCell| {
            let reach = lattice.reach(cell.level);
            match known.distance.at(lattice.center_key(cell)) {
                phi if phi - reach > 2.0 * self.radius => Some(State::Fluid),
                phi if phi + reach < -2.0 * self.radius => Some(State::Solid),
                _ => None,
            }
        };
        let states: Vec<Option<State>> = cells.par_iter().map(beyond).collect();
        let in_band = cells.iter().zip(&states).filter(|(_, state)| state.is_none());
        let band: Vec<LevelCell> = in_band.map(|(cell, _)| *cell).collect();
        self.measure(&band, known)?;
        let known = &*known;
        let judged = |(&cell, state): (_, Option<State>)| state.unwrap_or_else(|| self.judged(cell, known));
        Ok(cells.par_iter().zip(states).map(judged).collect())
    }

    /// Makes distance and volume known at the nodes and probes of cells of the band.
    fn measure(&self, cells: &[LevelCell], known: &mut Known) -> Result<(), Cancelled> {
        let lattice = self.lattice;
        let of_cell = |&cell| lattice.nodes(cell).into_iter().chain(lattice.probes(cell));
        let points = cells.par_iter().flat_map_iter(of_cell);
        known.distance.ask_distance(points.clone(), &lattice, self.phi, self.work)?;
        let missing = known.volume.missing(points);
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

    /// A cell of the band, by itself.
    fn judged(&self, cell: LevelCell, known: &Known) -> State {
        let nodes = self.lattice.nodes(cell);
        let distance = nodes.map(|key| known.distance.at(key));
        let volume = nodes.map(|key| known.volume.at(key));
        let difference = std::array::from_fn(|a| volume[a] - self.wall.volume(distance[a]));
        let plain = self.errors(cell, &CellFields { distance, volume, weights: [0.0; 8] }, known);
        let plane = self.errors(cell, &CellFields { distance, volume: difference, weights: [1.0; 8] }, known);
        let can_split = cell.level < self.lattice.finest();
        if plain.surface > 1.0 && can_split {
            return State::Split;
        }
        State::Band(match (plane.volume <= BY_FIT, plain.volume <= BY_FIT) {
            (true, true) => Wish::Either,
            (true, false) => Wish::Plane,
            (false, true) => Wish::Plain,
            _ if can_split => return State::Split,
            _ if plane.volume < plain.volume => Wish::Plane,
            _ => Wish::Plain,
        })
    }

    /// Largest errors of a cell with these fields at its probes.
    pub fn errors(&self, cell: LevelCell, fields: &CellFields, known: &Known) -> Errors {
        let mut errors = Errors::default();
        for (at, key) in self.lattice.probes(cell).into_iter().enumerate() {
            let exact = known.distance.at(key);
            if !self.counts(exact) {
                continue;
            }
            let shape = &SHAPES[at];
            let sum = |values: &[f64; NODES]| shape.iter().zip(values).map(|(n, v)| n * v).sum::<f64>();
            let distance = sum(&fields.distance);
            let plane = self.of_wall(part_of(&WEIGHTS[at], &fields.weights), distance);
            let miss = (plane + sum(&fields.volume) - known.volume.at(key)).abs();
            errors.volume = errors.volume.max(miss / (self.tolerances.volume * self.ball));
            if exact <= self.radius {
                let miss = (distance - exact).abs() / (self.tolerances.distance * self.radius);
                errors.surface = errors.surface.max(miss).max(self.normal_error(cell, at, fields));
            }
        }
        errors
    }

    /// w V_plane(Phi), m^3.
    pub fn of_wall(&self, weight: f64, distance: f64) -> f64 {
        if weight == 0.0 { 0.0 } else { weight * self.wall.volume(distance) }
    }

    /// Whether fluid can be where Phi is this.
    pub fn counts(&self, phi: f64) -> bool {
        (-DEPTH * self.radius..=2.0 * self.radius).contains(&phi)
    }

    /// What the stored volume should be at a cell's probes.
    pub fn targets(
        &self,
        cell: LevelCell,
        distance: &[f64; NODES],
        weights: &[f64; 8],
        known: &Known,
    ) -> Targets {
        let mut targets = Targets { values: [0.0; PROBES.len()], weights: [1.0; PROBES.len()] };
        for (at, key) in self.lattice.probes(cell).into_iter().enumerate() {
            let phi = SHAPES[at].iter().zip(distance).map(|(n, phi)| n * phi).sum();
            targets.values[at] = known.volume.at(key) - self.of_wall(part_of(&WEIGHTS[at], weights), phi);
            if !self.counts(known.distance.at(key)) {
                targets.weights[at] = REST;
            }
        }
        targets
    }

    /// Error of the normal at a probe as a part of the tolerance; 0 if that isn't asked for, or at a kink.
    fn normal_error(&self, cell: LevelCell, probe: usize, fields: &CellFields) -> f64 {
        let Some(tolerance) = self.tolerances.normal else { return 0.0 };
        if self.lattice.cell_size(cell.level).max_element() <= NORMALS_DOWN_TO * self.radius {
            return 0.0;
        }
        let place = self.lattice.position(self.lattice.probes(cell)[probe]);
        let Some(exact) = exact_normal(self.phi, place, self.radius) else { return 0.0 };
        let (_, slopes) = shape_and_gradient(probe_place(probe));
        let gradient: DVec3 = slopes.iter().zip(&fields.distance).map(|(slope, phi)| *slope * *phi).sum();
        exact.angle_between(gradient / self.lattice.cell_size(cell.level)) / tolerance
    }
}

/// The values of a cell's fields.
#[derive(Clone, Copy, Debug)]
pub struct CellFields {
    /// Phi at the nodes, metres.
    pub distance: [f64; NODES],
    /// V - w V_plane(Phi) at the nodes, m^3.
    pub volume: [f64; NODES],
    /// w at the corners.
    pub weights: [f64; 8],
}

/// Largest errors of a cell, as parts of the tolerances.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// Of the volume.
    pub volume: f64,
    /// Of distance and normal.
    pub surface: f64,
}

impl Errors {
    /// The larger one.
    pub fn largest(&self) -> f64 {
        self.volume.max(self.surface)
    }
}

/// Trilinear weights of the corners at the probes.
static WEIGHTS: LazyLock<[[f64; 8]; PROBES.len()]> =
    LazyLock::new(|| std::array::from_fn(|probe| trilinear(probe_place(probe))));

/// The trilinear value of these corners.
pub fn part_of(parts: &[f64; 8], corners: &[f64; 8]) -> f64 {
    parts.iter().zip(corners).map(|(n, w)| n * w).sum()
}

/// The parts that the corners' values have in the trilinear value at a place in [-1, 1]^3.
pub fn trilinear(xi: DVec3) -> [f64; 8] {
    std::array::from_fn(|corner| {
        let side = |axis: usize| 0.5 * (1.0 + xi[axis] * (2.0 * (corner >> axis & 1) as f64 - 1.0));
        side(0) * side(1) * side(2)
    })
}

impl CellTree {
    /// Cells that must be split so that cells of the band that touch differ by one level at most.
    pub fn unbalanced(&self, finest: u32, resolution: UVec3) -> Vec<LevelCell> {
        for level in (1..finest).rev() {
            let mut found: Vec<LevelCell> = Vec::new();
            for (cell, state) in &self.cells {
                if cell.level != level || *state != State::Split {
                    continue;
                }
                found.extend(self.larger_neighbours(*cell, resolution));
            }
            if !found.is_empty() {
                LevelCell::sort(&mut found);
                return found;
            }
        }
        Vec::new()
    }

    /// Cells of the band that a cell touches and that are larger.
    pub fn larger_neighbours(
        &self,
        cell: LevelCell,
        resolution: UVec3,
    ) -> impl Iterator<Item = LevelCell> + '_ {
        let size = (resolution << cell.level).as_ivec3();
        let around =
            (0..27).map(move |n| cell.at.as_ivec3() + IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
        let inside = around.filter(move |at| at.cmpge(IVec3::ZERO).all() && at.cmplt(size).all());
        inside.filter_map(move |at| self.coarser_at(LevelCell { level: cell.level, at: at.as_uvec3() }))
    }

    /// The cell of the band that holds a place where the tree ends at a coarser level.
    fn coarser_at(&self, place: LevelCell) -> Option<LevelCell> {
        let mut near = place;
        while !self.cells.contains_key(&near) {
            if near.level == 0 {
                return None;
            }
            near = near.parent();
        }
        (near.level < place.level && matches!(self.cells[&near], State::Band(_))).then_some(near)
    }
}
