//! Volume maps and density maps in two dimensions: Bender et al. 2020, sections 4.2, 4.3 and 5, as its Fig. 11 compares
//! them.
//!
//! - [`outline`]: the distance to closed lines, and the bake of a file;
//! - [`disc`]: quadrature over the disc;
//! - here: both integrals at the nodes of a band of cubic Serendipity quadrilaterals, from any signed distance.
//!
//! ```text
//! V(x)            = integral over |xi| <= r of g(Phi(x + xi)) d xi                     (Eq. 12; an area, m^2)
//! rho_B(x) / rho0 = integral over |xi| <= r of gamma(Phi(x + xi)) W(|xi|) d xi         (Eq. 9)
//! ```
//! g is Eq. 13, gamma Eq. 11 ([`crate::density_map`]), W is normalised in the plane. As in space, Phi in the integrals
//! is the interpolated field, by the runtime's own element. Maps in two dimensions are small: nothing here is fast but
//! what is simple.

mod crossings;
pub mod disc;
pub mod outline;

use crate::density_map::oracle::extension as gamma;
use crate::error::Error;
use crate::plan::{self, Extent};
use crate::rows::NodeRow;
use crate::settings::{self, GridChoice, Precision};
use crate::stage::Stage;
use crate::storage::stored;
use crate::volume_map::extension::extension;
use crate::watch::{Cancelled, Watch, Work};
use disc::{DiscPoint, DiscRule};
use glam::{DVec2, DVec3, UVec3};
use rayon::prelude::*;
use volmap_formats::asset::{
    Array, Asset, Attributes, CellRun, DensityField, Dimension, Exterior, QuadratureSpec,
};
use volmap_runtime::layout::{Family, Nodes};
use volmap_runtime::{Grid, KernelKind, Values, VolumeMap};

/// What the programs that draw and measure maps say of one in two dimensions.
///
/// # Errors
/// The map is in two dimensions.
pub fn require_space(asset: &Asset, command: &'static str) -> Result<(), Error> {
    match asset.dimension {
        Dimension::Three => Ok(()),
        Dimension::Two => Err(Error::setting(
            command,
            "the map is in two dimensions, of which only `volmap info` and `volmap query` know so far",
        )),
    }
}

/// What a map depends on beside the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaSettings {
    /// Support radius r, metres; by default a twentieth of the box's diagonal, rounded to 1, 2 or 5 times a power of
    /// ten.
    pub support_radius: Option<f64>,
    /// How the cells are chosen; a resolution's third number plays no part, and a tolerance isn't searched for.
    pub grid: GridChoice,
    /// Lowest and highest corner of the domain, metres; by default all of |Phi| <= 2 r.
    pub domain: Option<[[f64; 2]; 2]>,
    /// Length added to the domain on every side, metres.
    pub padding: f64,
    /// Solid and fluid change places: for containers.
    pub invert: bool,
    /// Moves the zero line out of the solid by this, metres.
    pub thickness: f64,
    /// How the area is integrated.
    pub rule: DiscRule,
    /// How the density is computed, if it is to be.
    pub density: Option<AreaDensity>,
    /// Precision of the stored fields.
    pub precision: Precision,
}

impl Default for AreaSettings {
    fn default() -> Self {
        AreaSettings {
            support_radius: None,
            grid: GridChoice::default(),
            domain: None,
            padding: 0.0,
            invert: false,
            thickness: 0.0,
            rule: DiscRule::default(),
            density: None,
            precision: Precision::default(),
        }
    }
}

/// What a density map depends on beside the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaDensity {
    /// The SPH kernel W.
    pub kernel: KernelKind,
    /// How the density is integrated.
    pub rule: DiscRule,
    /// Where gamma becomes 0, in support radii: 1 in Eq. 11.
    pub extension: f64,
}

impl Default for AreaDensity {
    fn default() -> Self {
        AreaDensity { kernel: KernelKind::default(), rule: DiscRule::GaussLegendre(50), extension: 1.0 }
    }
}

impl AreaDensity {
    /// The rule's points with W of unit support in their weights.
    fn points(&self) -> Vec<DiscPoint> {
        let weight = |p: &DiscPoint| p.weight * self.kernel.unit_value_in_plane(p.position.length());
        self.rule.points().iter().map(|p| DiscPoint { weight: weight(p), ..*p }).collect()
    }

    fn field(&self, radius: f64, values: Array) -> DensityField {
        let points = self.points();
        DensityField {
            kernel: self.kernel.to_string(),
            extension_length: self.extension * radius,
            quadrature: self.rule.to_string(),
            degree: self.rule.degree(),
            points: points.len() as u64,
            kernel_integral: points.iter().map(|p| p.weight).sum(),
            values,
        }
    }
}

/// Cells of a grid, at most: all of them are asked for their distance.
const MAX_CELLS: u64 = 1 << 24;

/// Bakes a signed distance (metres, 1-Lipschitz, negative inside the solid) whose zero line lies in the box `bounds`.
/// Already inverted and moved by the thickness; what the file says of bake and source is left empty.
///
/// # Errors
/// Settings that contradict each other or the surface; cancelled.
pub fn bake(
    bounds: [DVec2; 2],
    phi: &(impl Fn(DVec2) -> f64 + Sync),
    settings: &AreaSettings,
    watch: &Watch,
) -> Result<Asset, Error> {
    let (grid, radius) = grid(bounds, settings)?;
    let field = distance_field(&grid, radius, phi, watch)?;
    let work = watch.begin(Stage::Band.step(), grid.resolution.y.into())?;
    let [band_cells, solid_cells] = cells_within(&grid, 2.0 * radius, phi, &work)?;
    let places = places(&grid, &numbered(&grid, &band_cells)?);
    let distance = distances(&places, phi, &watch.begin(Stage::Distance.step(), places.len() as u64)?)?;
    // Eq. 12.
    let work = watch.begin(Stage::Volume.step(), places.len() as u64)?;
    let disc = Disc { field: &field, points: &settings.rule.points(), radius };
    let area = disc.integrals(&places, |value| extension(value, 1.0 / radius), &work)?;
    let area = area.into_iter().map(|sum| radius * radius * sum).collect();
    let disc_area = settings.rule.disc_area(radius);
    let density = match settings.density {
        Some(density) => Some(density_field(&field, &places, density, settings, watch)?),
        None => None,
    };
    Ok(Asset {
        dimension: Dimension::Two,
        grid: grid.into(),
        support_radius: radius,
        exterior: if settings.invert { Exterior::Solid } else { Exterior::Fluid },
        quadrature: quadrature(settings.rule, radius),
        band_cells,
        solid_cells,
        finer: Vec::new(),
        signed_distance: stored(distance, radius, settings.precision)?.0,
        volume: stored(area, disc_area, settings.precision)?.0,
        density,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    })
}

fn quadrature(rule: DiscRule, radius: f64) -> QuadratureSpec {
    QuadratureSpec {
        name: rule.to_string(),
        degree: rule.degree(),
        points: rule.points().len() as u64,
        ball_volume: rule.disc_area(radius),
    }
}

/// Eq. 9.
fn density_field(
    field: &VolumeMap,
    places: &[DVec2],
    density: AreaDensity,
    settings: &AreaSettings,
    watch: &Watch,
) -> Result<DensityField, Error> {
    let radius = field.support_radius();
    let length = density.extension * radius;
    let work = watch.begin(Stage::Density.step(), places.len() as u64)?;
    let disc = Disc { field, points: &density.points(), radius };
    let values = disc.integrals(places, |value| gamma(value, length), &work)?;
    Ok(density.field(radius, stored(values, 1.0, settings.precision)?.0))
}

/// The grid of the map, and the support radius.
fn grid(bounds: [DVec2; 2], settings: &AreaSettings) -> Result<(Grid, f64), Error> {
    let [min, max] = bounds.map(|corner| corner.extend(0.0));
    let in_space =
        settings::MapSettings { support_radius: settings.support_radius, ..settings::MapSettings::default() };
    let radius = plan::support_radius(&Extent { min, max, area: 0.0 }, &in_space)?;
    let reach = 2.0 * radius + settings.thickness.abs() + settings.padding;
    if !(reach.is_finite() && settings.padding >= 0.0) {
        return Err(Error::setting(
            "padding",
            "this and `thickness` must be finite lengths, this one from 0",
        ));
    }
    let needed = [bounds[0] - reach, bounds[1] + reach];
    let given = |[low, high]: [[f64; 2]; 2]| {
        [DVec2::from(low) - settings.padding, DVec2::from(high) + settings.padding]
    };
    let [low, high] = settings.domain.map_or(needed, given);
    if !(low.is_finite() && high.is_finite() && low.cmplt(high).all()) {
        return Err(Error::setting("domain", format!("{low} to {high} is no box; give xmin,ymin,xmax,ymax")));
    }
    let grid = layer(low, high, radius, settings)?;
    plan::check_precision(&grid)?;
    Ok((grid, radius))
}

/// One layer of cells; their thickness has no meaning, their length is as good as any.
fn layer(low: DVec2, high: DVec2, radius: f64, settings: &AreaSettings) -> Result<Grid, Error> {
    let size = high - low;
    let (cell, cells) = match settings.grid {
        GridChoice::Resolution([x, y, _]) => {
            let cells = DVec2::new(x.into(), y.into());
            (size / cells, cells)
        }
        GridChoice::CellSize(edge) => (DVec2::splat(edge), (size / edge - 1e-9).ceil().max(DVec2::ONE)),
        GridChoice::FromRadius | GridChoice::Tolerance(_) | GridChoice::Bytes(_) => {
            (DVec2::splat(0.5 * radius), (size / (0.5 * radius) - 1e-9).ceil().max(DVec2::ONE))
        }
    };
    let is_possible = cell.is_finite() && cell.cmpgt(DVec2::ZERO).all() && cells.cmpge(DVec2::ONE).all();
    if !is_possible || cells.x * cells.y > MAX_CELLS as f64 {
        let parameter =
            if matches!(settings.grid, GridChoice::Resolution(_)) { "resolution" } else { "cell_size" };
        let reason = format!("{} x {} cells: it must be 1 to 16,777,216 in all", cells.x, cells.y);
        return Err(Error::setting(parameter, reason));
    }
    let origin = low - 0.5 * (cells * cell - size);
    Ok(Grid {
        origin: origin.extend(0.0),
        cell_size: cell.extend(cell.x),
        resolution: cells.as_uvec2().extend(1),
    })
}

/// Phi wherever a disc around a node of the band needs it, on cells around the grid too: its area is 0. Deep enough for
/// gamma, which is not cut at 1: 2 r to the band's edge, a diagonal and a half to the node, r of the disc.
fn distance_field(
    grid: &Grid,
    radius: f64,
    phi: &(impl Fn(DVec2) -> f64 + Sync),
    watch: &Watch,
) -> Result<VolumeMap, Error> {
    let size = grid.cell_size.truncate();
    let margin = ((radius / size).ceil() + 1.0).as_uvec2();
    let grown = Grid {
        origin: grid.origin - (margin.as_dvec2() * size).extend(0.0),
        resolution: grid.resolution + (2 * margin).extend(0),
        ..*grid
    };
    let cells = grown.resolution.as_u64vec3();
    if cells.x.saturating_mul(cells.y) > 4 * MAX_CELLS {
        return Err(Error::setting(
            "cell_size",
            "the cells are too small for the support radius; take larger ones",
        ));
    }
    let work = watch.begin(Stage::Band.step(), grown.resolution.y.into())?;
    let [band_cells, solid_cells] = cells_within(&grown, 3.0 * radius + 1.5 * size.length(), phi, &work)?;
    let places = places(&grown, &numbered(&grown, &band_cells)?);
    let distance = distances(&places, phi, &watch.begin(Stage::Distance.step(), places.len() as u64)?)?;
    // Nobody asks this map for an area, but an asset has a positive one.
    let disc = std::f64::consts::PI * radius * radius;
    Ok(VolumeMap::from_asset(&Asset {
        dimension: Dimension::Two,
        grid: grown.into(),
        support_radius: radius,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec { name: String::new(), degree: 0, points: 0, ball_volume: disc },
        band_cells,
        solid_cells,
        finer: Vec::new(),
        volume: Array::F64(vec![0.0; distance.len()]),
        signed_distance: Array::F64(distance),
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    })?)
}

/// Phi at the places; each counts as work.
fn distances(
    places: &[DVec2],
    phi: &(impl Fn(DVec2) -> f64 + Sync),
    work: &Work,
) -> Result<Vec<f64>, Cancelled> {
    let at = |&place: &DVec2| {
        work.check()?;
        work.add(1);
        Ok(phi(place))
    };
    places.par_iter().map(at).collect()
}

/// The cells with a point of |Phi| <= width (and some just beyond), and those deeper in the solid. Rows count as work.
fn cells_within(
    grid: &Grid,
    width: f64,
    phi: &(impl Fn(DVec2) -> f64 + Sync),
    work: &Work,
) -> Result<[Vec<CellRun>; 2], Cancelled> {
    let size = grid.cell_size.truncate();
    let reach = width + 0.5 * size.length();
    let row = |j: u32| {
        work.check()?;
        let mut runs = [Vec::<CellRun>::new(), Vec::new()];
        for i in 0..grid.resolution.x {
            let center = grid.origin.truncate() + size * (DVec2::new(i.into(), j.into()) + 0.5);
            let value = phi(center);
            let kind = match value {
                _ if value.abs() <= reach => &mut runs[0],
                _ if value < 0.0 => &mut runs[1],
                _ => continue,
            };
            match kind.last_mut().filter(|run| run.i + run.len == i) {
                Some(run) => run.len += 1,
                None => kind.push(CellRun { i, j, k: 0, len: 1 }),
            }
        }
        work.add(1);
        Ok(runs)
    };
    let rows: Vec<_> = (0..grid.resolution.y).into_par_iter().map(row).collect::<Result<_, Cancelled>>()?;
    Ok([0, 1].map(|kind| rows.iter().flat_map(|row: &[Vec<_>; 2]| row[kind].iter().copied()).collect()))
}

fn numbered(grid: &Grid, band: &[CellRun]) -> Result<Nodes, Error> {
    if band.is_empty() {
        let reason = "no line is within 2 support radii of the domain; move or enlarge it";
        return Err(Error::setting("domain", reason));
    }
    let too_many = || Error::setting("resolution", "the band has more than 2^32 nodes; take larger cells");
    Nodes::new(UVec3::new(grid.resolution.x, grid.resolution.y, 1), band).ok_or_else(too_many)
}

/// Places of the nodes that are stored: those in the plane, in the order of their numbers.
fn places(grid: &Grid, nodes: &Nodes) -> Vec<DVec2> {
    let rows = |family: Family| {
        let in_plane = nodes.intervals(family).filter(|(_, k, _)| *k == 0);
        in_plane.map(move |(j, k, it)| NodeRow { family, first: it.first, end: it.end, j, k })
    };
    let families = [Family::Corner, Family::EdgeX, Family::EdgeY];
    let all = families.into_iter().flat_map(rows).flat_map(|row| row.positions(grid));
    all.map(DVec3::truncate).collect()
}

/// A rule on discs of some radius (metres) in a field.
struct Disc<'a> {
    field: &'a VolumeMap,
    points: &'a [DiscPoint],
    radius: f64,
}

impl Disc<'_> {
    /// Sums of the weights times `of` Phi over the discs around these places, each of which counts as work.
    fn integrals(
        &self,
        places: &[DVec2],
        of: impl Fn(f64) -> f64 + Sync,
        work: &Work,
    ) -> Result<Vec<f64>, Cancelled> {
        let at = |(points, values): &mut (Vec<DVec3>, Vec<Values>), &place: &DVec2| {
            work.check()?;
            points.clear();
            points.extend(self.points.iter().map(|p| (place + self.radius * p.position).extend(0.0)));
            self.field.sample_batch(points, values);
            work.add(1);
            Ok(self.points.iter().zip(values).map(|(p, value)| p.weight * of(value.distance)).sum())
        };
        places.par_iter().map_init(Default::default, at).collect()
    }
}
