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
//! gamma is not cut at 1: it grows on into the solid, as Eq. 11 says and as the authors' own programs do. So the density
//! of a half space is 1 - Phi / r wherever Phi <= -r, its gradient doesn't vanish there, and what a ball needs of Phi
//! reaches r deeper than the band.

mod cells;
pub mod cost;
pub mod oracle;

use crate::error::Error;
use crate::maps::{Maps, Stage, numbered};
use crate::plan::{self, Plan};
use crate::sdf::band::find_band;
use crate::sdf::field::{DistanceField, values};
use crate::sdf::{KnownDistance, SignedDistance};
use crate::volume_map::lattice::LatticeRule;
use crate::volume_map::quadrature::{Point, Rule};
use crate::work::Work;
use cells::{copy, without};
use glam::{DVec3, UVec3};
use volmap_formats::asset::{Array, DensityField, Exterior};
use volmap_runtime::layout::Nodes;
use volmap_runtime::{Grid, KernelKind};

/// The SPH kernels W that a density map can be baked for: those of the file's format.
pub const KERNELS: [KernelKind; 2] = [KernelKind::CubicSpline, KernelKind::WendlandC2];

/// One of [`KERNELS`] by its name, or `cubic` or `wendland` for short.
///
/// # Errors
/// Another name; the message has those that can be taken.
pub fn parse_kernel(text: &str) -> Result<KernelKind, String> {
    let known = text.parse().ok().filter(|kernel| KERNELS.contains(kernel));
    known.ok_or_else(|| {
        format!("`{text}` is no kernel of density maps; take {}", KERNELS.map(KernelKind::name).join(" or "))
    })
}

/// What a density map depends on beside the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensitySettings {
    /// The SPH kernel W, whose support radius is the map's.
    pub kernel: KernelKind,
    /// How the density is integrated. W vanishes at the edge of the ball, so the Gauss-Legendre rules, whose error
    /// comes from there, are better here than those made for the ball; and a gradient takes an exact rule.
    pub rule: Rule,
    /// Where gamma becomes 0, in support radii: 1 in Eq. 11; SPlisHSPlasH takes 1/5.
    pub extension: f64,
}

impl Default for DensitySettings {
    fn default() -> Self {
        DensitySettings { kernel: KernelKind::default(), rule: Rule::GaussLegendre(50), extension: 1.0 }
    }
}

impl DensitySettings {
    /// The rule's points in the unit ball, with W of unit support in their weights.
    pub fn points(&self) -> Vec<Point> {
        let weighted =
            |p: Point| Point { weight: p.weight * self.kernel.unit_value(p.position.length()), ..p };
        self.rule.points().into_iter().map(weighted).collect()
    }

    /// The largest density, over rest density, at points up to `depth` inside the solid (metres): that of a half space.
    pub fn largest(&self, depth: f64, support_radius: f64) -> f64 {
        1.0 + depth / (self.extension * support_radius)
    }

    /// What is stored of a density.
    pub fn field(&self, support_radius: f64, values: Array) -> DensityField {
        let points = self.points();
        DensityField {
            kernel: self.kernel.to_string(),
            extension_length: self.extension * support_radius,
            quadrature: self.rule.to_string(),
            degree: self.rule.degree(),
            points: points.len() as u64,
            kernel_integral: points.iter().map(|p| p.weight).sum(),
            values,
        }
    }
}

/// Boundary density over rest density at the nodes of the maps. `enter` is called at the beginning of each of three
/// stages: cells, distance, density.
///
/// # Errors
/// More cells or nodes than can be numbered.
pub fn compute_density(
    plan: &Plan,
    settings: &DensitySettings,
    phi: &impl SignedDistance,
    maps: &Maps,
    enter: &mut dyn FnMut(Stage),
) -> Result<Vec<f64>, Error> {
    let is_cut = plan.margin != UVec3::ZERO || plan.exterior == Exterior::Solid;
    let margin = if is_cut { plan::margin(&plan.grid, plan.support_radius)? } else { UVec3::ZERO };
    let length = settings.extension * plan.support_radius;
    let field = deep_field(plan, margin, length, &Known { phi, maps }, enter)?;
    let work = Work::new(maps.nodes.count() as u64);
    enter(Stage::Density(work.clone()));
    let rule = LatticeRule::for_density(&settings.points(), plan.support_radius, plan.grid.cell_size, length);
    Ok(rule.integrals(&field, &maps.nodes, margin, &work))
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
    enter: &mut dyn FnMut(Stage),
) -> Result<DistanceField, Error> {
    let grid = plan.grown(margin);
    let deep = deepest(&grid, plan.support_radius);
    let work = Work::new(grid.resolution.as_u64vec3().element_product());
    enter(Stage::Density(work.clone()));
    // The band -deep .. length is one around another surface.
    let moved = Moved { phi: known.phi, by: 0.5 * (deep - length) };
    let cells = find_band(&grid, 0.5 * (deep + length), &moved, &work);
    let nodes = numbered(grid.resolution, &cells)?;
    // On the map's own lattice only the cells beyond its band are new.
    let shared = margin == UVec3::ZERO;
    let new_cells = if shared { without(&cells.band, &known.maps.cells.band) } else { cells.band.clone() };
    let new_nodes = Nodes::new(grid.resolution, &new_cells).unwrap_or_else(|| unreachable!("fewer than all"));
    let work = Work::new(new_nodes.count() as u64);
    enter(Stage::Density(work.clone()));
    let mut all = vec![0.0; nodes.count()];
    copy(&new_nodes, &values(&grid, &new_nodes, known.phi, &work), &nodes, &mut all);
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
