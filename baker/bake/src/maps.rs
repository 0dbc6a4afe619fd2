//! The two fields of a map, from any signed distance: the three steps of Bender et al. 2020, section 5, with the
//! third, sparsity, first, so that nothing is computed that is not kept.

use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;
use crate::sdf::band::{BandCells, cropped, find_band};
use crate::sdf::field::{DistanceField, values};
use crate::volume_map::lattice::LatticeRule;
use crate::volume_map::quadrature::Rule;
use crate::work::Work;
use glam::UVec3;
use volmap_runtime::layout::Nodes;

/// Phi and V at the nodes of the band.
#[derive(Clone, Debug)]
pub struct Maps {
    /// Cells of the band and of the solid.
    pub cells: BandCells,
    /// Numbers of the nodes.
    pub nodes: Nodes,
    /// Signed distance at the nodes, metres.
    pub distance: Vec<f64>,
    /// Boundary volume at the nodes, m^3 (Eq. 12).
    pub volume: Vec<f64>,
    /// Boundary density over rest density at the nodes (Eq. 9), if it is asked for.
    pub density: Option<Vec<f64>>,
}

/// A stage of the bake, for progress and timing.
#[derive(Clone, Debug)]
pub enum Stage {
    /// Integrating the volume on the exact distance, for a tolerance.
    Reference(Work),
    /// Finding the cells of the band, among so many.
    Band(Work),
    /// Sampling Phi at the nodes.
    Distance(Work),
    /// Integrating V at the nodes.
    Volume(Work),
    /// The density: finding and sampling what it needs beyond the band, and integrating it.
    Density(Work),
}

impl Stage {
    /// Name for a list of times.
    pub fn name(&self) -> &'static str {
        match self {
            Stage::Reference(_) => "reference",
            Stage::Band(_) => "band",
            Stage::Distance(_) => "distance",
            Stage::Volume(_) => "volume",
            Stage::Density(_) => "density",
        }
    }
}

/// Computes both fields of the signed distance `phi` (metres, 1-Lipschitz, negative inside the solid). `enter` is
/// called at the beginning of each stage.
///
/// # Errors
/// A band that is empty or too large to be numbered.
pub fn compute_maps(
    plan: &Plan,
    rule: Rule,
    phi: &impl SignedDistance,
    enter: &mut dyn FnMut(Stage),
) -> Result<Maps, Error> {
    let distance_grid = plan.distance_grid();
    let work = Work::new(distance_grid.resolution.as_u64vec3().element_product());
    enter(Stage::Band(work.clone()));
    let found = find_band(&distance_grid, plan.band_width, phi, &work);
    let found_nodes = numbered(distance_grid.resolution, &found)?;

    let work = Work::new(found_nodes.count() as u64);
    enter(Stage::Distance(work.clone()));
    let field = DistanceField::new(
        distance_grid,
        &found,
        &found_nodes,
        plan.exterior,
        values(&distance_grid, &found_nodes, phi, &work),
    );
    let (cells, nodes) = match plan.margin == UVec3::ZERO {
        true => (found, found_nodes),
        false => cropped_cells(plan, &found)?,
    };

    let work = Work::new(nodes.count() as u64);
    enter(Stage::Volume(work.clone()));
    let lattice = LatticeRule::new(&rule.points(), plan.support_radius, plan.grid.cell_size);
    let volume = lattice.integrals(&field, &nodes, plan.margin, &work);
    let distance = match plan.margin == UVec3::ZERO {
        true => field.values,
        false => values(&plan.grid, &nodes, phi, &Work::new(0)),
    };
    Ok(Maps { cells, nodes, distance, volume, density: None })
}

pub(crate) fn numbered(resolution: UVec3, cells: &BandCells) -> Result<Nodes, Error> {
    if cells.band.is_empty() {
        let reason = "no surface is within 2 support radii of the domain; move or enlarge it, or, if nothing of the \
                      solid is left, take another `thickness`";
        return Err(Error::setting("domain", reason));
    }
    let too_many = || Error::setting("resolution", "the band has more than 2^32 nodes; take larger cells");
    Nodes::new(resolution, &cells.band).ok_or_else(too_many)
}

fn cropped_cells(plan: &Plan, found: &BandCells) -> Result<(BandCells, Nodes), Error> {
    let (low, high) = (plan.margin, plan.margin + plan.grid.resolution);
    let cells = BandCells { band: cropped(&found.band, low, high), solid: cropped(&found.solid, low, high) };
    let nodes = numbered(plan.grid.resolution, &cells)?;
    Ok((cells, nodes))
}
