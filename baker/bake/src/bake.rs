//! The whole bake: Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 5.
//!
//! ```text
//! examine   mesh -> diagnosis, repair                          (mesh)
//! plan      settings, box and area -> support radius r, grid   (plan)
//! Phi(x)    signed distance to the solid, Eq. 10               (sdf)
//! cells     those with a point of |Phi| <= 2 r: step 3         (maps, sdf::band)
//! Phi       at the nodes of the cells: step 1                  (maps, sdf::field)
//! V(x)      = integral over |xi| <= r of g(Phi(x + xi)) d xi,
//!           Eq. 12 with g of Eq. 13, at the nodes: step 2      (maps, volume_map)
//! rho_B(x)  Eq. 9 with gamma of Eq. 11, if it is asked for     (density_map)
//! ```
//! [`plan_bake`] is the first two lines, [`PlannedBake::run`] the others. [`bake`] does both; [`bake_distance`] begins
//! with a signed distance instead of a mesh.

use crate::adaptive::adapt;
use crate::clock::Clock;
use crate::density_map::compute_density;
use crate::describe;
use crate::doubt::compare_at_nodes;
use crate::error::Error;
use crate::fields::Fields;
use crate::input::{Input, bounds};
use crate::maps::compute_maps;
use crate::mesh::topology::Topology;
use crate::mesh::{Diagnosis, OrientationRepair, Prepared, prepare};
use crate::plan::{Extent, Plan, plan};
pub use crate::recipe::BakeSettings;
use crate::sdf::sign::SignChoice;
use crate::sdf::thin::ThinPlaces;
use crate::sdf::{BoundaryDistance, ChangedDistance, MeshDistance, SignComparison, SignedDistance};
use crate::settings::{FileSize, GridChoice, MapSettings, Tolerances};
use crate::sized::least_error;
use crate::stage::Stage;
use crate::storage::stored_asset;
pub use crate::summary::{CellCounts, Rounding, Sized, Summary};
use crate::tolerance::{Found, SearchProblem, search};
use crate::units::Lengths;
use crate::warnings;
use crate::watch::Watch;
use volmap_formats::asset::{Asset, encode};

/// A baked asset and what there is to say of it.
#[derive(Clone, Debug)]
pub struct Bake {
    /// The asset.
    pub asset: Asset,
    /// What there is to say.
    pub summary: Summary,
}

/// Bakes a mesh: [`plan_bake`], then [`PlannedBake::run`].
///
/// # Errors
/// Settings that can't be used with this mesh, or a bake over the memory limit; cancelled.
pub fn bake(input: Input, settings: &BakeSettings, watch: &Watch) -> Result<Bake, Error> {
    plan_bake(input, settings, watch)?.run(watch)
}

/// A mesh that was examined and turned to run one way round, and the plan of its bake.
#[derive(Clone, Debug)]
pub struct PlannedBake {
    input: Input,
    settings: BakeSettings,
    repair: OrientationRepair,
    diagnosis: Diagnosis,
    topology: Topology,
    extent: Extent,
    cells: Cells,
    /// Bytes that the file may have, if the cells are searched for by that.
    limit: Option<u64>,
    clock: Clock,
}

/// How the cells are known.
#[derive(Clone, Debug)]
enum Cells {
    Planned(Plan),
    /// By measuring, for these tolerances.
    Measured(Tolerances),
    /// By measuring, for a file of this size.
    Sized(FileSize),
}

/// Examines a mesh and plans its bake, before anything large is computed.
///
/// # Errors
/// Settings that can't be used with this mesh, or a bake over the memory limit; cancelled.
pub fn plan_bake(mut input: Input, settings: &BakeSettings, watch: &Watch) -> Result<PlannedBake, Error> {
    let clock = Clock::default();
    clock.beside(watch).step(Stage::Mesh.step())?;
    let Prepared { topology, repair, mut diagnosis } = prepare(&mut input.mesh, settings.keep_orientation);
    if let Some(shape) = input.placed_shape.filter(|placed| !placed.shape().is_unbounded()) {
        (diagnosis.volume, diagnosis.area) = (shape.shape().volume(), shape.area());
    }
    clock.stop();
    let ([min, max], area) = match &input.placed_shape {
        Some(shape) => (shape.bounds(), shape.area()),
        None => (bounds(&input.mesh), diagnosis.area),
    };
    let extent = Extent { min, max, area };
    let cells = match settings.map.grid {
        GridChoice::Tolerance(tolerances) => Cells::Measured(tolerances),
        GridChoice::Bytes(size) => Cells::Sized(size),
        _ => {
            let lengths = Lengths::of(&input, &extent, settings);
            Cells::Planned(plan(&extent, &settings.map).map_err(|error| lengths.explain(error))?)
        }
    };
    let settings = settings.clone();
    Ok(PlannedBake { input, settings, repair, diagnosis, topology, extent, cells, limit: None, clock })
}

impl PlannedBake {
    /// The grid, and what the bake will cost. None if a tolerance is asked for: then the cells are found by measuring.
    pub fn plan(&self) -> Option<&Plan> {
        match &self.cells {
            Cells::Planned(plan) => Some(plan),
            Cells::Measured(_) | Cells::Sized(_) => None,
        }
    }

    /// Box and area of the mesh.
    pub fn extent(&self) -> &Extent {
        &self.extent
    }

    /// The mesh's length, and what it is compared with.
    pub fn lengths(&self) -> Lengths {
        Lengths::of(&self.input, &self.extent, &self.settings)
    }

    /// The mesh as it will be baked.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// What is wrong with the mesh, after the repair.
    pub fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }

    /// Bakes.
    ///
    /// # Errors
    /// A tolerance or a size that can't be reached; a band that is empty or too large; cancelled.
    pub fn run(self, watch: &Watch) -> Result<Bake, Error> {
        match self.cells {
            Cells::Sized(size) => self.run_sized(size, watch),
            _ => self.run_once(watch),
        }
    }

    /// Bakes for the least error in a file of this size.
    fn run_sized(self, FileSize { bytes, compression }: FileSize, watch: &Watch) -> Result<Bake, Error> {
        let planned = PlannedBake { limit: Some(bytes), ..self };
        let baked = |tolerances| planned.for_tolerances(tolerances).run_once(watch);
        let size = |bake: &Bake| Ok(encode(&bake.asset, compression)?.len() as u64);
        let (mut best, tried) = least_error(bytes, baked, size)?;
        best.summary.seconds = planned.clock.seconds();
        best.summary.sized = Some(Sized { limit: bytes, tried });
        Ok(best)
    }

    /// The same bake with cells for these errors.
    fn for_tolerances(&self, tolerances: Tolerances) -> PlannedBake {
        let mut planned = self.clone();
        planned.settings.map.grid = GridChoice::Tolerance(tolerances);
        planned.cells = Cells::Measured(tolerances);
        planned
    }

    fn run_once(mut self, watch: &Watch) -> Result<Bake, Error> {
        let map = &self.settings.map;
        let watch = &self.clock.beside(watch);
        // Phi, Eq. 10.
        watch.step(Stage::Tree.step())?;
        let (sign, topology) = (self.settings.sign, std::mem::take(&mut self.topology));
        let mesh = MeshDistance::with_topology(&self.input.mesh, &topology, sign, &self.diagnosis);
        drop(topology);
        let shape = self.input.placed_shape;
        let phi = BoundaryDistance { mesh, shape, invert: map.invert, thickness: map.thickness };
        // The cells of the band, Phi and V there: section 5, Eq. 12.
        let (plan, fields, tolerance) = self.volume_map(&phi, watch)?;
        let (count, all) = (fields.distance().len(), self.settings.check_sign);
        let sign_comparison = compare_at_nodes(&phi, count, fields.places(&plan), all, watch)?;
        self.clock.stop();
        let thin = fields.thin(&plan, &phi);
        self.described(BakedMaps { phi, plan, fields, tolerance, sign_comparison, thin })
    }

    /// The grid and the fields on it, and how uniform cells were found if they were searched for.
    fn volume_map(
        &self,
        phi: &BoundaryDistance,
        watch: &Watch,
    ) -> Result<(Plan, Fields, Option<Found>), Error> {
        let map = &self.settings.map;
        let problem = SearchProblem { mesh: &self.input.mesh, extent: &self.extent, phi };
        let (plan, mut maps, found) = match &self.cells {
            Cells::Planned(plan) => (plan.clone(), compute_maps(plan, map.rule, phi, watch)?, None),
            // A density has no adaptive form.
            Cells::Measured(tolerances) if map.density.is_some() => {
                let (plan, maps, found) = search(&problem, map, tolerances.volume, watch)?;
                (plan, maps, Some(found))
            }
            Cells::Sized(_) => unreachable!("run takes tolerances"),
            Cells::Measured(tolerances) => {
                let adapted = adapt(&problem, map, *tolerances, watch);
                let adapted = adapted.map_err(|error| self.lengths().explain(error))?;
                return Ok((adapted.plan.clone(), Fields::Adaptive(Box::new(adapted)), None));
            }
        };
        // Eq. 9.
        if let Some(density) = &map.density {
            maps.density = Some(compute_density(&plan, density, phi, &maps, watch)?);
        }
        Ok((plan, Fields::Uniform(Box::new(maps)), found))
    }

    /// The asset, and what there is to say of it.
    fn described(self, baked: BakedMaps) -> Result<Bake, Error> {
        let BakedMaps { phi, plan, fields, tolerance, sign_comparison, thin } = baked;
        let lengths = self.lengths();
        let PlannedBake { input, settings, repair, mut diagnosis, extent, limit, clock, .. } = self;
        if phi.mesh.union_surface().is_some() && diagnosis.balanced {
            diagnosis.volume = phi.mesh.volume();
        }
        let mut summary = Summary {
            bounds: [extent.min, extent.max],
            diagnosis,
            repair,
            sign: sign_choice(&phi),
            has_exact_sign: phi.mesh.has_integer_winding(),
            leaks: fields.leaks(&plan),
            sign_comparison,
            overlaps: phi.mesh.overlaps().clone(),
            thin,
            coordinate_step: input.coordinate_step,
            cells: fields.cells(&plan),
            nodes: fields.distance().len(),
            tolerance,
            adapted: fields.adapted().cloned(),
            sized: limit.map(|limit| Sized { limit, tried: Vec::new() }),
            field_bytes: fields.bytes(&plan, &settings.map),
            density: settings.map.density,
            rounding: None,
            seconds: clock.seconds(),
            warnings: Vec::new(),
            shape: phi.shape,
            source: input.source.clone(),
            cleaning: input.cleaning.clone(),
            placement: input.placement,
            plan,
        };
        summary.warnings = warnings::warnings(&summary, fields.distance(), &settings, &lengths);
        let (asset, rounding) = fields.into_asset(&summary.plan, &settings.map)?;
        summary.rounding = rounding;
        let asset = Asset {
            bake: describe::parameters(&input, &summary, &settings),
            source: describe::source(&input, &summary),
            diagnosis: describe::diagnosis(&summary),
            ..asset
        };
        Ok(Bake { asset, summary })
    }
}

fn sign_choice(phi: &BoundaryDistance) -> SignChoice {
    let choice = phi.mesh.sign_choice().clone();
    match phi.shape {
        Some(_) => SignChoice { reason: "closed form: exact".into(), ..choice },
        None => choice,
    }
}

/// What was computed of a mesh.
struct BakedMaps {
    phi: BoundaryDistance,
    plan: Plan,
    fields: Fields,
    tolerance: Option<Found>,
    sign_comparison: Option<SignComparison>,
    thin: ThinPlaces,
}

/// Bakes any signed distance `phi`: metres, 1-Lipschitz, negative inside the solid. Its zero surface lies in the box of
/// `extent`, whose area serves the estimate of the cost only. The settings invert it and move it, as they do a mesh.
/// What an asset says of its bake and source is left empty.
///
/// # Errors
/// Settings that can't be used with this surface, a tolerance among them, which needs a mesh; a bake over the memory
/// limit; a band that is empty or too large; cancelled.
pub fn bake_distance(
    phi: &impl SignedDistance,
    extent: &Extent,
    settings: &MapSettings,
    watch: &Watch,
) -> Result<Asset, Error> {
    let searched = match settings.grid {
        GridChoice::Tolerance(_) => Some("tolerance"),
        GridChoice::Bytes(_) => Some("max_bytes"),
        _ => None,
    };
    if let Some(parameter) = searched {
        return Err(Error::setting(parameter, "is searched for on a mesh; choose the cells in another way"));
    }
    let plan = plan(extent, settings)?;
    let phi = ChangedDistance { phi, invert: settings.invert, thickness: settings.thickness };
    let mut maps = compute_maps(&plan, settings.rule, &phi, watch)?;
    if let Some(density) = &settings.density {
        maps.density = Some(compute_density(&plan, density, &phi, &maps, watch)?);
    }
    let (asset, _) = stored_asset(maps, &plan, settings)?;
    Ok(asset)
}
