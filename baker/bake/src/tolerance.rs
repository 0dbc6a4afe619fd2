//! The coarsest cells whose map is as exact as asked for, found by measuring.
//!
//! At random points of the fluid near the surface, Eq. 12 of Bender et al. 2020 is integrated once on the exact
//! distance by a rule far finer than the tolerance. Maps of ever smaller cells are then compared with it there. So
//! the error is that of the whole map: of Phi and V on the elements, and of the rule.

use crate::error::Error;
use crate::maps::{Maps, compute_maps};
use crate::plan::{Extent, Plan, plan, support_radius};
use crate::random::Random;
use crate::sdf::thin::ThinPlaces;
use crate::sdf::{Neighbours, SignedDistance};
use crate::settings::{GridChoice, MapSettings, Precision};
use crate::stage::Stage;
use crate::volume_map::oracle;
use crate::volume_map::quadrature::{Point, Rule, along_curve};
use crate::watch::{Cancelled, Watch, Work};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use volmap_formats::asset::{Exterior, Rounded};
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::{percent, significant};
use volmap_runtime::layout::serendipity::shape;
use volmap_runtime::layout::{Cell, CellIndex};

/// Points at which the error is measured.
const POINTS: usize = 1000;
/// Points that are tried for each, at most.
const TRIES: usize = 100;
/// The coarsest cells that are tried, in support radii.
const COARSEST: f64 = 2.0;
/// Cells of one try to the next.
const STEP: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Of cells a third as large the error must be less than this part, or there is no use in going on.
const STALLED: f64 = 0.8;
/// From this tolerance on the coarser reference is fine enough: its own error is 0.06 % of the ball, the other's 0.02
/// %.
const COARSE_FROM: f64 = 5e-3;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What was asked for, as a part of the full ball.
    pub tolerance: f64,
    /// Edge of the cells, metres.
    pub cell_size: f64,
    /// Measured error at these cells.
    pub error: MeasuredError,
    /// Cells that were tried and their largest error, in order.
    pub tried: Vec<(f64, f64)>,
    /// The rule of the reference.
    pub reference: Rule,
}

/// Error of a map's volume as parts of the full ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredError {
    /// Largest of all points.
    pub max: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// Number of points.
    pub points: usize,
}

impl MeasuredError {
    /// The largest of some errors, and the root mean square of those that were taken at random.
    pub(crate) fn of(all: &[f64], random: &[f64]) -> MeasuredError {
        let squares: f64 = random.iter().map(|error| error * error).sum();
        let rms = (squares / random.len().max(1) as f64).sqrt();
        MeasuredError { max: all.iter().copied().fold(0.0, f64::max), rms, points: all.len() }
    }

    /// Of the points of both.
    fn and(&self, other: &MeasuredError) -> MeasuredError {
        let squares = |of: &MeasuredError| of.rms * of.rms * of.points as f64;
        let points = self.points + other.points;
        let rms = ((squares(self) + squares(other)) / points as f64).sqrt();
        MeasuredError { max: self.max.max(other.max), rms, points }
    }
}

/// A solid whose cells are to be chosen.
pub struct SearchProblem<'a, D> {
    /// The surface.
    pub mesh: &'a TriangleMesh,
    /// Its box and area.
    pub extent: &'a Extent,
    /// Its signed distance.
    pub phi: &'a D,
}

/// Finds the cells, and the maps with them.
///
/// # Errors
/// A tolerance that the rule or the memory can't reach; otherwise as [`plan`] and [`compute_maps`].
pub fn search<D: SignedDistance>(
    problem: &SearchProblem<D>,
    settings: &MapSettings,
    tolerance: f64,
    watch: &Watch,
) -> Result<(Plan, Maps, Found), Error> {
    check_rounding(settings, tolerance)?;
    let radius = support_radius(problem.extent, settings)?;
    let coarse = with_cells(problem, settings, COARSEST * radius)?;
    let work = watch.begin(Stage::Reference.step(), 2 * POINTS as u64)?;
    let reference = Reference::new(problem, settings, &coarse, tolerance, &work)?;
    reference.check_rule(problem.phi, settings.rule, tolerance, &work)?;
    let tries = Tries { problem, settings, tolerance, reference: &reference, watch };
    let (best, tried) = tries.search(coarse)?;
    let Try { cell_size, plan, maps, error } = best;
    Ok((plan, maps, Found { tolerance, cell_size, error, tried, reference: reference.rule }))
}

pub(crate) fn check_rounding(settings: &MapSettings, tolerance: f64) -> Result<(), Error> {
    match settings.precision {
        Precision::Rounded(part) if part >= tolerance => {
            let reason = format!(
                "rounding by {} of the ball leaves nothing of `tolerance`; round less",
                percent(part)
            );
            Err(Error::setting("max_rounding", reason))
        }
        _ => Ok(()),
    }
}

/// The plan with cubes of this edge, metres.
fn with_cells<D>(problem: &SearchProblem<D>, settings: &MapSettings, edge: f64) -> Result<Plan, Error> {
    let settings = MapSettings { grid: GridChoice::CellSize(edge), ..settings.clone() };
    plan(problem.extent, &settings)
}

/// All that tries share.
struct Tries<'a, D> {
    problem: &'a SearchProblem<'a, D>,
    settings: &'a MapSettings,
    tolerance: f64,
    reference: &'a Reference,
    watch: &'a Watch,
}

/// Maps with cells of some edge (metres), and their error.
struct Try {
    cell_size: f64,
    plan: Plan,
    maps: Maps,
    error: MeasuredError,
}

impl<D: SignedDistance> Tries<'_, D> {
    /// From the coarsest cells down to the first that do, and then between the last two. Cells that were tried and
    /// their largest errors come too.
    fn search(&self, coarse: Plan) -> Result<(Try, Vec<(f64, f64)>), Error> {
        let mut tried = Vec::new();
        let mut next = Ok(coarse);
        let best = loop {
            let found = next.and_then(|plan| self.bake(plan));
            let found = found.map_err(|error| out_of_reach(error, self.tolerance, &tried))?;
            tried.push((found.cell_size, found.error.max));
            if found.error.max <= self.tolerance {
                break found;
            }
            if let [.., before, _, _, last] = tried[..]
                && last.1 > STALLED * before.1
            {
                return Err(stalled(self.tolerance, last.0, last.1));
            }
            next = with_cells(self.problem, self.settings, found.cell_size * STEP);
        };
        // Between the last failure and the first success there may be coarser cells that do.
        if tried.len() > 1 {
            let between = with_cells(self.problem, self.settings, best.cell_size / STEP.sqrt())?;
            let found = self.bake(between)?;
            tried.push((found.cell_size, found.error.max));
            if found.error.max <= self.tolerance {
                return Ok((found, tried));
            }
        }
        Ok((best, tried))
    }

    fn bake(&self, plan: Plan) -> Result<Try, Error> {
        let maps = compute_maps(&plan, self.settings.rule, self.problem.phi, self.watch)?;
        let error = self.reference.error(&plan, &maps, self.settings)?;
        let at_thin = self.at_thin_places(&plan, &maps)?;
        let error = at_thin.map_or(error, |thin| error.and(&thin));
        Ok(Try { cell_size: plan.grid.cell_size.x, plan, maps, error })
    }

    /// The error beside walls and gaps thinner than the cells, if there are any: random points seldom meet them.
    fn at_thin_places(&self, plan: &Plan, maps: &Maps) -> Result<Option<MeasuredError>, Error> {
        let phi = self.problem.phi;
        let Some(boundary) = phi.of_mesh() else { return Ok(None) };
        let thin = ThinPlaces::find(&plan.grid, &maps.nodes, &maps.distance, boundary);
        let places = thin.walls.places.iter().chain(&thin.gaps.places);
        let near = places.flat_map(|&place| beside(DVec3::from(place), plan.support_radius));
        let points: Vec<DVec3> = near.filter(|x| (0.0..plan.band_width).contains(&phi.at(*x))).collect();
        if points.is_empty() {
            return Ok(None);
        }
        let reference =
            Reference::at(points, phi, self.reference.rule, self.reference.radius, &Work::default())?;
        reference.error(plan, maps, self.settings).map(Some)
    }
}

/// Points around one of the surface, a quarter of the support radius away.
fn beside(place: DVec3, radius: f64) -> impl Iterator<Item = DVec3> {
    DVec3::AXES.into_iter().flat_map(move |axis| [place - 0.25 * radius * axis, place + 0.25 * radius * axis])
}

/// The error doesn't fall as it should.
fn stalled(tolerance: f64, cell: f64, max: f64) -> Error {
    let reason = format!(
        "smaller cells don't bring the error to {}: it stays at {} at cells of {} m. Walls and gaps \
         thinner than the cells stay as wrong until cells are as thin: see `thickness`. Where a mesh is open the sign \
         jumps, which no cell follows: close it. Or take a finer `quadrature` or a larger tolerance",
        percent(tolerance),
        percent(max),
        significant(cell, 4)
    );
    Error::setting("tolerance", reason)
}

/// What keeps smaller cells from being tried, in words of the tolerance.
fn out_of_reach(error: Error, tolerance: f64, tried: &[(f64, f64)]) -> Error {
    let Some((cell, max)) = tried.last() else { return error };
    let limit = match error {
        Error::Memory { needed, allowed } => format!(
            "the next would need {} MiB, more than `max_memory` {} MiB; allow more",
            needed >> 20,
            allowed >> 20
        ),
        Error::Setting { reason, .. } => format!("the next are not possible ({reason}); move the mesh"),
        other => return other,
    };
    let reason = format!(
        "{} needs cells smaller than {} m, which leave an error of {}; {limit}, or take a larger tolerance",
        percent(tolerance),
        significant(*cell, 4),
        percent(*max)
    );
    Error::setting("tolerance", reason)
}

/// Points and the volume there, on the exact distance.
struct Reference {
    rule: Rule,
    radius: f64,
    points: Vec<DVec3>,
    volumes: Vec<f64>,
}

impl Reference {
    fn new<D: SignedDistance>(
        problem: &SearchProblem<D>,
        settings: &MapSettings,
        plan: &Plan,
        tolerance: f64,
        work: &Work,
    ) -> Result<Reference, Error> {
        let points = fluid_points(problem, settings, plan, POINTS);
        if points.is_empty() {
            return Err(no_fluid());
        }
        let rule = Rule::Chord(if tolerance >= COARSE_FROM { 12 } else { 20 });
        Reference::at(points, problem.phi, rule, plan.support_radius, work)
    }

    fn at(
        points: Vec<DVec3>,
        phi: &impl SignedDistance,
        rule: Rule,
        radius: f64,
        work: &Work,
    ) -> Result<Reference, Error> {
        let volumes = integrals(phi, &along_curve(rule.points()), radius, &points, work)?;
        Ok(Reference { rule, radius, points, volumes })
    }

    /// Refuses a tolerance below the error that the rule makes on the exact distance already.
    fn check_rule(
        &self,
        phi: &impl SignedDistance,
        rule: Rule,
        tolerance: f64,
        work: &Work,
    ) -> Result<(), Error> {
        let volumes = integrals(phi, &along_curve(rule.points()), self.radius, &self.points, work)?;
        let error = self.measured(volumes.into_iter());
        if error.max <= tolerance {
            return Ok(());
        }
        let reason = format!(
            "the quadrature {rule} itself is wrong by up to {} of the ball; take a finer one (chord12, chord16, \
            chord20), \
             or a larger tolerance. Where a mesh is open the sign jumps, which no rule follows: close it, or give the \
             cells by `cell_size`",
            percent(error.max)
        );
        Err(Error::setting("tolerance", reason))
    }

    /// Of the map as it will be stored.
    fn error(&self, plan: &Plan, maps: &Maps, settings: &MapSettings) -> Result<MeasuredError, Error> {
        let ball = settings.rule.ball_volume(self.radius);
        let volume = match settings.precision {
            Precision::Rounded(part) => {
                let rounded = Rounded::new(&maps.volume, ball, part);
                rounded.map_err(|error| Error::setting("max_rounding", error.to_string()))?.values().collect()
            }
            Precision::F32 | Precision::F64 => maps.volume.clone(),
        };
        let cells = CellIndex::new(plan.grid.resolution, &maps.cells.band, &maps.cells.solid, &maps.nodes);
        let value = |x: &DVec3| {
            let Some(at) = plan.grid.locate(*x) else {
                return if plan.exterior == Exterior::Solid { ball } else { 0.0 };
            };
            match cells.find(at.cell) {
                Cell::Fluid => 0.0,
                Cell::Solid => ball,
                Cell::Band(numbers) => {
                    let terms = shape(at.xi).into_iter().zip(numbers.all());
                    terms.map(|(n, number)| n * volume[number as usize]).sum()
                }
            }
        };
        Ok(self.measured(self.points.iter().map(value)))
    }

    fn measured(&self, volumes: impl Iterator<Item = f64>) -> MeasuredError {
        let ball = 4.0 / 3.0 * PI * self.radius.powi(3);
        let errors = volumes.zip(&self.volumes).map(|(found, exact)| (found - exact).abs() / ball);
        let (max, squares) =
            errors.fold((0.0f64, 0.0), |(max, sum), error| (max.max(error), sum + error * error));
        MeasuredError { max, rms: (squares / self.points.len() as f64).sqrt(), points: self.points.len() }
    }
}

/// Nothing to measure the error at.
pub(crate) fn no_fluid() -> Error {
    let reason = "no fluid was found near the surface to measure the error in; check `invert` and `domain`";
    Error::setting("tolerance", reason)
}

/// Eq. 12 on the exact distance; each point counts as work.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn integrals(
    phi: &impl SignedDistance,
    rule: &[Point],
    radius: f64,
    points: &[DVec3],
    work: &Work,
) -> Result<Vec<f64>, Cancelled> {
    let integral = |near: &mut Neighbours, x: &DVec3| {
        work.check()?;
        let volume = oracle::volume_on_exact_distance(phi, rule, radius, *x, near);
        work.add(1);
        Ok(volume)
    };
    points.par_iter().map_init(Neighbours::default, integral).collect()
}

/// So many points with 0 < Phi < 2 r, or fewer, in any direction from points spread over the surface by area.
pub(crate) fn fluid_points<D: SignedDistance>(
    problem: &SearchProblem<D>,
    settings: &MapSettings,
    plan: &Plan,
    count: usize,
) -> Vec<DVec3> {
    let reach = plan.band_width + settings.thickness.abs();
    let mut surroundings = Surroundings::new(problem.mesh);
    let candidates: Vec<DVec3> = (0..TRIES * count).map(|_| surroundings.point(reach)).collect();
    // All grids hold the domain that was asked for; they differ in how far they grow beyond it.
    let (low, high) = match settings.domain {
        Some(corners) => {
            (DVec3::from(corners[0]) - settings.padding, DVec3::from(corners[1]) + settings.padding)
        }
        None => (plan.grid.origin, plan.grid.max_corner()),
    };
    let is_near = |x: &&DVec3| {
        let phi = || problem.phi.at(**x);
        x.cmpge(low).all() && x.cmple(high).all() && (0.0..plan.band_width).contains(&phi())
    };
    let mut points = Vec::with_capacity(2 * count);
    for some in candidates.chunks(count) {
        points.par_extend(some.par_iter().filter(is_near).copied());
        if points.len() >= count {
            break;
        }
    }
    points.truncate(count);
    points
}

/// Random points around a surface.
struct Surroundings<'a> {
    mesh: &'a TriangleMesh,
    /// Twice the areas of the triangles up to each.
    summed: Vec<f64>,
    random: Random,
}

impl Surroundings<'_> {
    fn new(mesh: &TriangleMesh) -> Surroundings<'_> {
        let mut sum = 0.0;
        let add = |[a, b, c]: [DVec3; 3]| {
            sum += (b - a).cross(c - a).length();
            sum
        };
        let summed = mesh.triangles.iter().map(|triangle| corners(mesh, triangle)).map(add).collect();
        Surroundings { mesh, summed, random: Random::new(1) }
    }

    /// A point of the surface, any by area, and up to `reach` metres from it in any direction.
    fn point(&mut self, reach: f64) -> DVec3 {
        let Surroundings { mesh, summed, random } = self;
        let area = random.unit() * summed.last().copied().unwrap_or(0.0);
        let triangle = summed.partition_point(|&s| s <= area).min(summed.len() - 1);
        let [a, b, c] = corners(mesh, &mesh.triangles[triangle]);
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let cosine = 2.0 * random.unit() - 1.0;
        let (sin, cos) = (2.0 * PI * random.unit()).sin_cos();
        let across = (1.0 - cosine * cosine).sqrt();
        let direction = DVec3::new(across * cos, across * sin, cosine);
        a + (b - a) * u + (c - a) * v + direction * (reach * random.unit())
    }
}

fn corners(mesh: &TriangleMesh, triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|vertex| DVec3::from(mesh.vertices[vertex as usize]))
}
