//! Adaptive maps: cells of several sizes, as large as the errors that are asked for allow. Adaptive grids are what Bender
//! et al. 2020 name as future work; the volume is stored as its difference from a flat wall's if that is smoother.
//!
//! ```text
//! tree      Phi on a tree of cells of its own, as fine as Eq. 12 needs       (distance_tree)
//! V(x)      Eq. 12 on that tree, at any point                                (volume)
//! cells     split where Phi, V or the normal miss within                     (cells)
//! form      V as it is, or as its difference from a flat wall's               (choose)
//! settle    2:1 balance, constraints; split what misses in place             (settle, fit)
//! measure   the map as stored, against the exact distance; split where it misses   (stored, measure)
//! ```

mod cells;
mod choose;
mod distance_tree;
mod fit;
mod form;
mod in_place;
mod known;
mod lattice;
mod measure;
mod probes;
mod region;
mod samples;
mod sampling;
mod settle;
mod stored;
mod uniform;
mod volume;

pub use cells::DEPTH;
pub use in_place::Settled;
pub use measure::MapErrors;
pub use uniform::uniform;

use crate::error::Error;
use crate::plan::{Plan, plan, support_radius};
use crate::sdf::SignedDistance;
use crate::settings::{GridChoice, MapSettings, Tolerances};
use crate::stage::Stage;
use crate::storage::Rounding;
use crate::tolerance::{SearchProblem, check_rounding, fluid_points, no_fluid};
use crate::volume_map::anywhere::LineRule;
use crate::volume_map::quadrature::Rule;
use crate::watch::Watch;
use cells::{CellTree, Judge};
use distance_tree::{DistanceTree, TreeSettings};
use form::Form;
use glam::DVec3;
use known::Known;
use lattice::{FineLattice, LevelCell, indices};
use measure::Reference;
use sampling::polynomial_level;
use stored::adaptive_asset;
use volmap_formats::asset::Asset;
use volmap_runtime::VolumeMap;
use volmap_runtime::layout::FlatWall;
use volume::TreeIntegrator;

/// Cells of level 0, in support radii.
const COARSEST: f64 = 4.0;
/// The finest level: cells of a sixteenth of the support radius.
const FINEST: u32 = 6;
/// How often cells are split where the map as stored misses, at most.
const REPAIRS: usize = 5;
/// From this repair on distance and normal, if they still miss, are asked to be more exact everywhere: it isn't a matter of
/// places then.
const TIGHTENED_FROM: usize = 2;
/// Error of Phi on the tree, in support radii for each part of the ball: V on it is then wrong by less than
/// half of the tolerance, by a tenth as a rule.
const TREE: f64 = 0.5;
/// From this tolerance on the coarser reference is fine enough: its own error is 0.06 % of the ball, the other's 0.02 %.
const COARSE_FROM: f64 = 5e-3;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Adapted {
    /// What was asked for.
    pub tolerances: Tolerances,
    /// The errors of the map as it is stored.
    pub errors: MapErrors,
    /// Points among which they were looked for.
    pub points: usize,
    /// The volume is stored as its difference from a flat wall's.
    pub by_difference: bool,
    /// Edge of the cells of level 0, metres.
    pub coarsest: f64,
    /// Cells of each level.
    pub cells: Vec<u64>,
    /// Cells of the finest level that are still wrong by more than the tolerance.
    pub left: usize,
    /// The centre of one of them.
    pub left_at: Option<[f64; 3]>,
    /// The rule of the reference.
    pub reference: Rule,
}

/// A map and how exact it is.
pub struct AdaptiveMap {
    /// The grid of level 0.
    pub plan: Plan,
    /// Cells, nodes and fields.
    pub settled: Settled,
    /// The same as an asset, which says nothing of bake and source yet.
    pub asset: Asset,
    /// What rounding changed.
    pub rounding: Option<Rounding>,
    /// How exact it is.
    pub found: Adapted,
}

impl AdaptiveMap {
    /// The last level that has cells.
    pub fn finest_level(&self) -> u32 {
        self.settled.levels.len() as u32 - 1
    }
}

/// Finds the cells, and the map with them.
///
/// # Errors
/// As [`plan`]; a map that needs more memory than is allowed; cancelled.
pub fn adapt<D: SignedDistance>(
    problem: &SearchProblem<D>,
    settings: &MapSettings,
    tolerances: Tolerances,
    watch: &Watch,
) -> Result<AdaptiveMap, Error> {
    check_rounding(settings, tolerances.volume)?;
    let radius = support_radius(problem.extent, settings)?;
    let coarse = MapSettings { grid: GridChoice::CellSize(COARSEST * radius), ..settings.clone() };
    let plan = plan(problem.extent, &coarse)?;
    let lattice = lattice_of(&plan)?;
    watch.step(Stage::Reference.step())?;
    let points = fluid_points(problem, settings, &plan, measure::CANDIDATES);
    if points.is_empty() {
        return Err(no_fluid());
    }
    let search =
        Search { phi: problem.phi, settings, tolerances, plan: &plan, lattice, points: &points, watch };
    let (settled, asset, rounding, found) = search.run()?;
    Ok(AdaptiveMap { plan, settled, asset, rounding, found })
}

/// The lattice of all levels over the grid on which Phi is needed.
fn lattice_of(plan: &Plan) -> Result<FineLattice, Error> {
    let lattices = (1..=FINEST).rev().find_map(|finest| FineLattice::new(plan.distance_grid(), finest));
    lattices.ok_or_else(|| {
        let reason = "an axis has more cells than adaptive maps can have; take a smaller domain, a larger support radius, \
                      or equal cells (`cell_size`)";
        Error::setting("tolerance", reason)
    })
}

/// What a search needs.
struct Search<'a, D> {
    phi: &'a D,
    settings: &'a MapSettings,
    tolerances: Tolerances,
    plan: &'a Plan,
    lattice: FineLattice,
    /// Where the error is measured.
    points: &'a [DVec3],
    watch: &'a Watch,
}

/// What it finds.
type Searched = (Settled, Asset, Option<Rounding>, Adapted);

impl<D: SignedDistance> Search<'_, D> {
    /// Splits cells until the map, as it is stored, is as exact as asked for.
    fn run(&self) -> Result<Searched, Error> {
        let (radius, mut known) = (self.plan.support_radius, Known::default());
        let work = self.watch.begin(Stage::Distance.step(), 0)?;
        let tolerance = TREE * self.tolerances.volume * radius;
        let settings = TreeSettings { radius, tolerance, exterior: self.plan.exterior };
        let tree = DistanceTree::new(self.lattice, &settings, self.phi, &mut known.distance, &work)?;
        let work = self.watch.begin(Stage::Volume.step(), 0)?;
        let rule = LineRule::new(self.settings.rule.points());
        let ball = self.settings.rule.ball_volume(radius);
        let mut judge = Judge {
            lattice: self.lattice,
            radius,
            ball,
            wall: FlatWall::new(radius, ball),
            forms: self.forms(),
            tolerances: self.tolerances,
            of_surface: 1.0,
            phi: self.phi,
            integrator: &TreeIntegrator::new(&tree, &rule, radius),
            polynomial_level: polynomial_level(&self.lattice, radius, self.tolerances.volume),
            max_memory: self.settings.max_memory,
            work: &work,
        };
        let lines = LineRule::new(self.reference_rule().points());
        let mut cells = CellTree::default();
        judge.decide(self.roots(), &mut cells, &mut known)?;
        if judge.forms.len() > 1 {
            judge.choose(&mut cells, &mut known, self.plan)?;
            // Once more with that form alone: cells in which only the other would do cost more later.
            cells = CellTree::default();
            known.at_probes.clear();
            judge.decide(self.roots(), &mut cells, &mut known)?;
        }
        let mut settled = judge.settle(&mut cells, &mut known, self.plan)?;
        let mut reference = None;
        for repairs in 0.. {
            let (asset, rounding) = adaptive_asset(&settled, self.plan, self.settings)?;
            let work = self.watch.begin(Stage::Reference.step(), 0)?;
            let made = || self.reference(&TreeIntegrator::new(&tree, &lines, radius));
            let reference: &mut Reference<D> = reference.get_or_insert_with(made);
            let (errors, missed) = reference.errors(&opened(&asset)?, &self.tolerances, &work)?;
            if missed.is_empty() || repairs == REPAIRS {
                let found = self.found(errors, &asset, &settled);
                return Ok((settled, asset, rounding, found));
            }
            if repairs >= TIGHTENED_FROM {
                judge.of_surface *= (0.95 / self.surface_excess(&errors)).clamp(0.5, 1.0);
            }
            settled = judge.repair(&missed, &mut cells, &mut known, self.plan)?;
        }
        unreachable!("the last repair returns")
    }

    /// How the volume may be stored.
    fn forms(&self) -> &'static [Form] {
        match self.settings.plain_volume {
            true => &[Form::Plain],
            false => &[Form::Difference, Form::Plain],
        }
    }

    fn reference_rule(&self) -> Rule {
        Rule::Chord(if self.tolerances.volume >= COARSE_FROM { 12 } else { 20 })
    }

    /// `estimate` is by its rule.
    fn reference(&self, estimate: &TreeIntegrator) -> Reference<'_, D> {
        Reference::new(self.phi, self.plan.support_radius, self.reference_rule(), estimate, self.points)
    }

    /// The largest error of distance and normal as a part of what is allowed.
    fn surface_excess(&self, errors: &MapErrors) -> f64 {
        let of_normal = self.tolerances.normal.map_or(0.0, |normal| errors.normal.max / normal);
        of_normal.max(errors.distance.max / self.tolerances.distance)
    }

    /// The cells of the map's grid, on the lattice of the larger one on which Phi is needed.
    fn roots(&self) -> Vec<LevelCell> {
        let cell = |at| LevelCell { level: 0, at: self.plan.margin + at };
        indices(self.plan.grid.resolution).map(cell).collect()
    }

    fn found(&self, errors: MapErrors, asset: &Asset, settled: &Settled) -> Adapted {
        Adapted {
            tolerances: self.tolerances,
            errors,
            points: self.points.len(),
            by_difference: asset.plane_weight.is_some(),
            coarsest: self.plan.grid.cell_size.x,
            cells: asset.cells_by_level(),
            left: settled.left.len(),
            left_at: settled.left.first().map(|cell| self.lattice.center(*cell).to_array()),
            reference: self.reference_rule(),
        }
    }
}

fn opened(asset: &Asset) -> Result<VolumeMap, Error> {
    VolumeMap::from_asset(asset).map_err(|error| Error::setting("tolerance", error.to_string()))
}
