//! The two fields of a map, from any signed distance: the three steps of Bender et al. 2020, section 5, with the
//! third, sparsity, first, so that nothing is computed that is not kept.

use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;
use crate::sdf::band::{BandCells, cropped, find_band};
use crate::sdf::field::{DistanceField, values};
use crate::stage::Stage;
use crate::volume_map::lattice::LatticeRule;
use crate::volume_map::quadrature::Rule;
use crate::watch::{Watch, Work};
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

/// Computes both fields of the signed distance `phi` (metres, 1-Lipschitz, negative inside the solid).
///
/// # Errors
/// A band that is empty or too large to be numbered; cancelled.
pub fn compute_maps(
    plan: &Plan,
    rule: Rule,
    phi: &impl SignedDistance,
    watch: &Watch,
) -> Result<Maps, Error> {
    // Step 3, sparsity: the cells with a point of |Phi| <= 2 r.
    let distance_grid = plan.distance_grid();
    let all_cells = distance_grid.resolution.as_u64vec3().element_product();
    let work = watch.begin(Stage::Band.step(), all_cells)?;
    let found = find_band(&distance_grid, plan.band_width, phi, &work)?;
    let found_nodes = numbered(distance_grid.resolution, &found)?;

    // Step 1: Phi at the nodes.
    let work = watch.begin(Stage::Distance.step(), found_nodes.count() as u64)?;
    let distance = values(&distance_grid, &found_nodes, phi, &work)?;
    let field = DistanceField::new(distance_grid, &found, &found_nodes, plan.exterior, distance);
    let is_cut = plan.margin != UVec3::ZERO;
    let (cells, nodes) = if is_cut { cropped_cells(plan, &found)? } else { (found, found_nodes) };

    // Step 2: V at the nodes, Eq. 12 on the interpolated Phi.
    let work = watch.begin(Stage::Volume.step(), nodes.count() as u64)?;
    let lattice = LatticeRule::new(&rule.points(), plan.support_radius, plan.grid.cell_size);
    let volume = lattice.integrals(&field, &nodes, plan.margin, &work)?;
    let distance = if is_cut { values(&plan.grid, &nodes, phi, &Work::default())? } else { field.values };
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
