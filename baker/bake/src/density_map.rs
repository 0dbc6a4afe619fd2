//! Density maps: Koschier and Bender 2017, *Density Maps for Improved SPH Boundary Handling*; Bender et al. 2020,
//! section 4.2.
//!
//! - [`oracle`]: Eq. 9 at any point, plain and slow;
//! - [`cost`]: what a density map costs beside a volume map;
//! - here: Eq. 9 at the nodes of a volume map, by the lattice of [`crate::volume_map`].
//!
//! ```text
//! rho_B(x) / rho0 = integral over |xi| <= r of gamma(Phi(x + xi)) W(|xi|) d xi                        (Eq. 9)
//! gamma(Phi) = 1 - Phi / r for Phi < r, else 0                                                        (Eq. 11)
//! ```
//! gamma is not cut at 1: it grows on into the solid, as Eq. 11 says and as the authors' own programs do. So the
//! density of a half space is 1 - Phi / r wherever Phi <= -r, its gradient doesn't vanish there, and what a ball needs
//! of Phi reaches r deeper than the band.

mod cells;
pub mod cost;
pub mod oracle;

use crate::error::Error;
use crate::maps::{Maps, numbered};
use crate::plan::{self, Plan};
use crate::sdf::band::find_band;
use crate::sdf::field::{DistanceField, values};
use crate::sdf::{KnownDistance, SignedDistance};
pub use crate::settings::density::{DensitySettings, KERNELS, parse_kernel};
use crate::stage::Stage;
use crate::volume_map::lattice::LatticeRule;
use crate::watch::Watch;
use cells::{copy, without};
use glam::{DVec3, UVec3};
use volmap_formats::asset::Exterior;
use volmap_runtime::Grid;
use volmap_runtime::layout::Nodes;

/// Boundary density over rest density at the nodes of the maps, in three steps: cells, distance, density.
///
/// # Errors
/// More cells or nodes than can be numbered; cancelled.
pub fn compute_density(
    plan: &Plan,
    settings: &DensitySettings,
    phi: &impl SignedDistance,
    maps: &Maps,
    watch: &Watch,
) -> Result<Vec<f64>, Error> {
    let is_cut = plan.margin != UVec3::ZERO || plan.exterior == Exterior::Solid;
    let margin = if is_cut { plan::margin(&plan.grid, plan.support_radius)? } else { UVec3::ZERO };
    let length = settings.extension * plan.support_radius;
    let field = deep_field(plan, margin, length, &Known { phi, maps }, watch)?;
    let work = watch.begin(Stage::Density.step(), maps.nodes.count() as u64)?;
    let rule = LatticeRule::for_density(&settings.points(), plan.support_radius, plan.grid.cell_size, length);
    Ok(rule.integrals(&field, &maps.nodes, margin, &work)?)
}

/// A distance, and what is known of it.
struct Known<'a, D> {
    phi: &'a D,
    maps: &'a Maps,
}

/// Phi wherever a ball around a node of the band needs it: gamma > 0, and r deeper than the band.
fn deep_field(
    plan: &Plan,
    margin: UVec3,
    length: f64,
    known: &Known<impl SignedDistance>,
    watch: &Watch,
) -> Result<DistanceField, Error> {
    let grid = plan.grown(margin);
    let deep = deepest(&grid, plan.support_radius);
    let work = watch.begin(Stage::Density.step(), grid.resolution.as_u64vec3().element_product())?;
    // The band -deep .. length is one around another surface.
    let moved = Moved { phi: known.phi, by: 0.5 * (deep - length) };
    let cells = find_band(&grid, 0.5 * (deep + length), &moved, &work)?;
    let nodes = numbered(grid.resolution, &cells)?;
    // On the map's own lattice only the cells beyond its band are new.
    let shared = margin == UVec3::ZERO;
    let new_cells = if shared { without(&cells.band, &known.maps.cells.band) } else { cells.band.clone() };
    let new_nodes = Nodes::new(grid.resolution, &new_cells).unwrap_or_else(|| unreachable!("fewer than all"));
    let work = watch.begin(Stage::Density.step(), new_nodes.count() as u64)?;
    let mut all = vec![0.0; nodes.count()];
    copy(&new_nodes, &values(&grid, &new_nodes, known.phi, &work)?, &nodes, &mut all);
    if shared {
        copy(&known.maps.nodes, &known.maps.distance, &nodes, &mut all);
    }
    Ok(DistanceField::new(grid, &cells, &nodes, plan.exterior, all))
}

/// No ball around a node of the band reaches deeper, metres: 2 r to the band's edge, at most 1.3 diagonals of a cell to
/// the node, r of the ball.
fn deepest(grid: &Grid, support_radius: f64) -> f64 {
    3.0 * support_radius + 1.5 * grid.cell_size.length()
}

/// The surface moved into the solid.
struct Moved<'a, D> {
    phi: &'a D,
    by: f64,
}

impl<D: SignedDistance> SignedDistance for Moved<'_, D> {
    fn near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64 {
        self.phi.near(point, known) + self.by
    }
}
