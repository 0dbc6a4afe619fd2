//! The tree of a map's cells: split where measured errors are too large, and balanced.

use super::form::Form;
use super::known::{Exact, Known};
use super::lattice::{FineLattice, LevelCell};
use super::measure::exact_normal;
use super::probes;
use super::volume::TreeIntegrator;
use crate::error::Error;
use crate::sdf::SignedDistance;
use crate::settings::Tolerances;
use crate::watch::Work;
use glam::{DVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use volmap_runtime::layout::FlatWall;
use volmap_runtime::layout::serendipity::{NODES, shape_and_gradient};

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Its children are in the tree.
    Split,
    /// In the band.
    Band,
    /// Deeper in the solid than the band.
    Solid,
    /// Farther from the solid than the band.
    Fluid,
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
    /// How the volume may be stored: cells are good where one of the forms is. One, once it is chosen.
    pub forms: &'static [Form],
    /// What a cell's errors may be.
    pub tolerances: Tolerances,
    /// What those of distance and normal may be in place, as a part of the tolerances.
    pub of_surface: f64,
    /// The exact distance.
    pub phi: &'a D,
    /// Eq. 12.
    pub integrator: &'a TreeIntegrator<'a>,
    /// Level from which on V is the polynomial through its values at a cell's nodes: that of `sampling`.
    pub polynomial_level: u32,
    /// Bytes that cells and samples may take.
    pub max_memory: u64,
    /// Who may stop it.
    pub work: &'a Work,
}

/// All cells.
#[derive(Default)]
pub struct CellTree {
    /// Those of all levels, split ones too.
    pub cells: FxHashMap<LevelCell, State>,
    /// Those of the band that were added since the last fit.
    pub new: Vec<LevelCell>,
}

/// Smaller cells aren't split for the normal, in support radii: beside a kink of the distance it is never right.
const NORMALS_DOWN_TO: f64 = 0.25;
/// Part of the support radius that points may lie in the solid and still count.
pub const DEPTH: f64 = 0.1;
/// Errors of a cubic through the nodes that a fit brings below the tolerance. Where more is left to later rounds, they
/// split more.
const BY_FIT: f64 = 1.3;
/// Error of the volume that cells may have at their probes, in place, as a part of the tolerance: the worst of all probes
/// is the worst of many more points than anybody measures, and what is measured is mended.
const IN_PLACE: f64 = 1.2;
/// About: of a sample, and of a cell.
const BYTES_PER_SAMPLE: u64 = 40;
const BYTES_PER_CELL: u64 = 600;

impl<D: SignedDistance> Judge<'_, D> {
    /// How the volume is stored, or may be.
    pub fn form(&self) -> Form {
        self.forms[0]
    }

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
            for (cell, (state, exact)) in cells.into_iter().zip(states) {
                tree.cells.insert(cell, state);
                if state == State::Band {
                    tree.new.push(cell);
                }
                exact.map(|exact| known.at_probes.insert(cell, exact));
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

    fn states(&self, cells: &[LevelCell], known: &mut Known) -> Result<Vec<Judged>, Error> {
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
        let mut judged = self.judged(&band, known)?.into_iter();
        let of_band = |state: Option<State>| match state {
            Some(state) => (state, None),
            None => judged.next().unwrap_or((State::Fluid, None)),
        };
        Ok(states.into_iter().map(of_band).collect())
    }

    /// Cells of the band, each by itself: first by distance and normal, which are had for less than the volume.
    fn judged(&self, cells: &[LevelCell], known: &mut Known) -> Result<Vec<Judged>, Error> {
        self.ask_distances(cells, known)?;
        let distances = &known.distance;
        let is_split = |cell: &LevelCell| {
            let nodes = self.lattice.nodes(*cell).map(|key| distances.at(key));
            let exact = self.lattice.probes(*cell).map(|key| distances.at(key) as f32);
            cell.level < self.lattice.finest() && self.surface_error(*cell, &exact, &nodes) > 1.0
        };
        let split: Vec<bool> = cells.par_iter().map(is_split).collect();
        let of_kind = |kind| cells.iter().zip(&split).filter(move |(_, split)| **split == kind);
        let [left, split_cells] =
            [false, true].map(|kind| of_kind(kind).map(|(cell, _)| *cell).collect::<Vec<_>>());
        self.ask_volumes(&left, &split_cells, known)?;
        let known = &*known;
        let judged = |(cell, split): (&LevelCell, &bool)| match split {
            true => (State::Split, None),
            false => self.judged_by_volume(*cell, known),
        };
        Ok(cells.par_iter().zip(&split).map(judged).collect())
    }

    fn judged_by_volume(&self, cell: LevelCell, known: &Known) -> Judged {
        let exact = self.exact(cell, known);
        let nodes = self.lattice.nodes(cell);
        let distance = nodes.map(|key| known.distance.at(key));
        let volume = nodes.map(|key| known.volume.at(key));
        let error = |&form: &Form| {
            let volume = std::array::from_fn(|a| volume[a] - form.of_wall(&self.wall, distance[a]));
            self.volume_error(&exact, &CellFields { distance, volume, form })
        };
        let smallest = self.forms.iter().map(error).fold(f64::INFINITY, f64::min);
        match smallest > BY_FIT && cell.level < self.lattice.finest() {
            true => (State::Split, None),
            false => (State::Band, Some(exact)),
        }
    }

    /// What is known at a cell's probes.
    fn exact(&self, cell: LevelCell, known: &Known) -> Exact {
        let keys = self.lattice.probes(cell);
        Exact {
            distance: keys.map(|key| known.distance.at(key) as f32),
            volume: keys.map(|key| known.volume.at(key) as f32),
        }
    }

    /// Largest error of a cell with these fields at its probes, as a part of what it may be in place.
    pub fn error(&self, cell: LevelCell, fields: &CellFields, known: &Known) -> f64 {
        let exact = &known.at_probes[&cell];
        (self.volume_error(exact, fields) / IN_PLACE).max(self.surface_error(
            cell,
            &exact.distance,
            &fields.distance,
        ))
    }

    /// Of the volume.
    fn volume_error(&self, exact: &Exact, fields: &CellFields) -> f64 {
        let mut volume = probes::values(&fields.volume);
        self.of_wall(fields.form, &fields.distance, |probe, wall| volume[probe] += wall);
        let places = volume.iter().zip(&exact.volume).zip(&exact.distance);
        let fluid = places.filter(|(_, phi)| self.counts(f64::from(**phi)));
        let misses = fluid.map(|((found, exact), _)| (found - f64::from(*exact)).abs());
        misses.fold(0.0, f64::max) / (self.tolerances.volume * self.ball)
    }

    /// Of distance and normal.
    fn surface_error(&self, cell: LevelCell, exact: &[f32; probes::COUNT], distance: &[f64; NODES]) -> f64 {
        let mut largest = 0.0f64;
        for (probe, (found, exact)) in probes::values(distance).iter().zip(exact).enumerate() {
            let exact = f64::from(*exact);
            if self.counts(exact) && exact <= self.radius {
                let miss = (found - exact).abs() / (self.tolerances.distance * self.radius);
                largest = largest.max(miss).max(self.normal_error(cell, probe, distance));
            }
        }
        largest
    }

    /// w V_plane(Phi) at the probes where that isn't 0, m^3.
    fn of_wall(&self, form: Form, distance: &[f64; NODES], mut each: impl FnMut(usize, f64)) {
        if form == Form::Plain {
            return;
        }
        for (probe, phi) in probes::values(distance).into_iter().enumerate() {
            each(probe, form.of_wall(&self.wall, phi));
        }
    }

    /// Whether fluid can be where Phi is this; beyond the band, too, where the cells that hold its edge reach.
    pub fn counts(&self, phi: f64) -> bool {
        phi >= -DEPTH * self.radius
    }

    /// What the stored volume should be at a cell's probes, m^3.
    pub fn targets(&self, cell: LevelCell, distance: &[f64; NODES], known: &Known) -> [f64; probes::COUNT] {
        let mut values = known.at_probes[&cell].volume.map(f64::from);
        self.of_wall(self.form(), distance, |probe, wall| values[probe] -= wall);
        values
    }

    /// At which of a cell's probes fluid can be, bit by bit.
    pub fn in_fluid(&self, cell: LevelCell, known: &Known) -> u32 {
        let probes = known.at_probes[&cell].distance.iter().enumerate();
        probes.map(|(probe, phi)| u32::from(self.counts(f64::from(*phi))) << probe).sum()
    }

    /// Error of the normal at a probe as a part of the tolerance; 0 if that isn't asked for, or at a kink.
    fn normal_error(&self, cell: LevelCell, probe: usize, distance: &[f64; NODES]) -> f64 {
        let Some(tolerance) = self.tolerances.normal else { return 0.0 };
        if self.lattice.cell_size(cell.level).max_element() <= NORMALS_DOWN_TO * self.radius {
            return 0.0;
        }
        let place = self.lattice.position(self.lattice.probes(cell)[probe]);
        let Some(exact) = exact_normal(self.phi, place, self.radius) else { return 0.0 };
        let (_, slopes) = shape_and_gradient(probes::place(probe));
        let gradient: DVec3 = slopes.iter().zip(distance).map(|(slope, phi)| *slope * *phi).sum();
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
    /// How the volume is stored.
    pub form: Form,
}

/// What a cell is, and what is known of it if it is one of the band.
type Judged = (State, Option<Exact>);

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
        cell.around(resolution).filter_map(|(_, place)| self.coarser_at(place))
    }

    /// The cell of the band that holds a place where the tree ends at a coarser level.
    pub fn coarser_at(&self, place: LevelCell) -> Option<LevelCell> {
        let mut near = place;
        while !self.cells.contains_key(&near) {
            if near.level == 0 {
                return None;
            }
            near = near.parent();
        }
        (near.level < place.level && self.cells[&near] == State::Band).then_some(near)
    }
}
