//! From settings to a grid: support radius, domain, cells, and what the bake will cost, before any of it is done.

use crate::error::Error;
pub use crate::settings::{GridChoice, MapSettings, Precision};
use crate::volume_map::lattice::MAX_REACH;
use glam::{DVec3, UVec3};
use std::f64::consts::PI;
use volmap_formats::asset::{Exterior, MAX_CELLS_PER_AXIS, MAX_ROWS, Rounded};
use volmap_formats::text::significant;
use volmap_runtime::Grid;

/// The surface, as far as a plan needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Lowest corner of the surface's box, metres.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
    /// Surface area, m^2.
    pub area: f64,
}

/// The grid of a bake and its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Support radius r, metres.
    pub support_radius: f64,
    /// Half width of the band, 2 r.
    pub band_width: f64,
    /// The grid of the map.
    pub grid: Grid,
    /// Cells around `grid` where Phi is needed although the map ends: not 0 only if the domain cuts the band.
    pub margin: UVec3,
    /// By how much the domain cuts the band, metres, at the low and high side of each axis; 0 where it doesn't.
    pub cut: [[f64; 3]; 2],
    /// What lies outside the domain.
    pub exterior: Exterior,
    /// What the bake will cost, about.
    pub estimate: Estimate,
}

/// What a bake will cost, from the surface's area: right to a factor of 2 for smooth surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Cells of the band.
    pub cells: u64,
    /// Memory at its peak, bytes.
    pub memory: u64,
    /// Seconds on one thread.
    pub seconds: f64,
}

/// Support radii in metres whose ball has a volume that single precision holds.
const SUPPORT_RADII: [f64; 2] = [1e-9, 1e9];
/// Largest coordinate of a domain, metres: squares and cubes of lengths stay in range.
const MAX_EXTENT: f64 = 1e12;
/// Part of a coordinate that a cell's edge must exceed: nodes must not fall together by rounding.
const MIN_CELL: f64 = 1e-10;
/// Measured with `chord8` on one core of an AMD EPYC (Zen 3), on a canyon of 2.5 million cells; half or twice that
/// elsewhere.
const SECONDS_PER_SAMPLE: f64 = 1.5e-9;
const SECONDS_PER_NODE: f64 = 0.9e-6;
const BYTES_PER_NODE: u64 = 40;
/// With `--precision f64`.
const BYTES_PER_DOUBLE_NODE: u64 = 56;
/// With a density, whose field reaches deeper than the band.
const BYTES_PER_DENSITY_NODE: u64 = 32;
const BYTES_PER_ROW: u64 = 48;

/// Plans a bake.
///
/// # Errors
/// Settings that contradict each other or the surface, or a bake over the memory limit.
pub fn plan(extent: &Extent, settings: &MapSettings) -> Result<Plan, Error> {
    let support_radius = support_radius(extent, settings)?;
    let band_width = 2.0 * support_radius;
    let reach = band_width + finite("thickness", settings.thickness)?.abs();
    let needed = [extent.min - reach, extent.max + reach];
    let [low, high] = domain(needed, settings)?;
    let grid = grid(low, high, support_radius, settings)?;
    check_precision(&grid)?;
    check_rounding(&grid, support_radius, settings)?;
    if let Some(density) = &settings.density {
        density.check().map_err(|reason| Error::setting("density_quadrature", reason))?;
    }
    let cut = cut(&grid, needed);
    let cuts = cut[0].max_element().max(cut[1].max_element()) > 0.0;
    let margin = if cuts { margin(&grid, support_radius)? } else { UVec3::ZERO };
    check_reach(&grid, support_radius)?;
    let estimate = estimate(extent, &grid, margin, band_width, settings);
    if estimate.memory > settings.max_memory {
        return Err(Error::Memory { needed: estimate.memory, allowed: settings.max_memory });
    }
    Ok(Plan {
        support_radius,
        band_width,
        grid,
        margin,
        cut: cut.map(|side| side.to_array()),
        exterior: if settings.invert { Exterior::Solid } else { Exterior::Fluid },
        estimate,
    })
}

impl Plan {
    /// The grid on which Phi is sampled: the map's, grown by the margin.
    pub fn distance_grid(&self) -> Grid {
        self.grown(self.margin)
    }

    /// The map's grid with cells around it.
    pub fn grown(&self, margin: UVec3) -> Grid {
        Grid {
            origin: self.grid.origin - margin.as_dvec3() * self.grid.cell_size,
            cell_size: self.grid.cell_size,
            resolution: self.grid.resolution + 2 * margin,
        }
    }
}

/// By how much the domain ends within the band, but for rounding.
fn cut(grid: &Grid, needed: [DVec3; 2]) -> [DVec3; 2] {
    let beyond = |length: DVec3| DVec3::select(length.cmpgt(1e-6 * grid.cell_size), length, DVec3::ZERO);
    [beyond(grid.origin - needed[0]), beyond(needed[1] - grid.max_corner())]
}

/// Cells within reach of a node beyond the domain's faces.
pub(crate) fn margin(grid: &Grid, support_radius: f64) -> Result<UVec3, Error> {
    let cells = (support_radius / grid.cell_size).ceil() + 1.0;
    let grown = grid.resolution.as_dvec3() + 2.0 * cells;
    check_resolution("domain", "cuts the band, and with a support radius around it has ", grown)?;
    Ok(cells.as_uvec3())
}

fn finite(parameter: &'static str, value: f64) -> Result<f64, Error> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(Error::setting(parameter, format!("{value} is not a finite length"))),
    }
}

/// The support radius as given, or by default, metres.
pub(crate) fn support_radius(extent: &Extent, settings: &MapSettings) -> Result<f64, Error> {
    let diagonal = (extent.max - extent.min).length();
    let radius = settings.support_radius.unwrap_or_else(|| rounded(diagonal / 20.0));
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Error::setting(
            "support_radius",
            format!("{radius} is not a positive length (four times `particle_radius`)"),
        ));
    }
    let [least, most] = SUPPORT_RADII;
    if !(least..=most).contains(&radius) {
        let reason = format!(
            "{} m is outside {least:e} to {most:e} m; check the mesh's size ({} m), `unit` and `scale`",
            significant(radius, 4),
            significant(diagonal, 4)
        );
        return Err(Error::setting("support_radius", reason));
    }
    Ok(radius)
}

/// The next lower of 1, 2 or 5 times a power of ten.
fn rounded(length: f64) -> f64 {
    let power = 10f64.powf(length.log10().floor());
    let step = [5.0, 2.0, 1.0].into_iter().find(|step| step * power <= length * (1.0 + 1e-12));
    step.unwrap_or(1.0) * power
}

fn domain(needed: [DVec3; 2], settings: &MapSettings) -> Result<[DVec3; 2], Error> {
    let padding = finite("padding", settings.padding)?;
    if padding < 0.0 {
        return Err(Error::setting("padding", "is negative; use `domain` for a smaller domain"));
    }
    let [low, high] = settings.domain.map_or(needed, |corners| corners.map(DVec3::from));
    if !(low.is_finite() && high.is_finite() && low.cmplt(high).all()) {
        let reason = format!("{low} to {high} is not a box; give xmin,ymin,zmin,xmax,ymax,zmax");
        return Err(Error::setting("domain", reason));
    }
    Ok([low - padding, high + padding])
}

fn grid(low: DVec3, high: DVec3, support_radius: f64, settings: &MapSettings) -> Result<Grid, Error> {
    let extent = high - low;
    let (parameter, edge) = match settings.grid {
        GridChoice::FromRadius | GridChoice::Tolerance(_) | GridChoice::Bytes(_) => {
            ("support_radius", 0.5 * support_radius)
        }
        GridChoice::CellSize(edge) => ("cell_size", edge),
        GridChoice::Resolution(cells) => {
            let resolution = UVec3::from(cells);
            check_resolution("resolution", "", resolution.as_dvec3())?;
            return Ok(Grid { origin: low, cell_size: extent / resolution.as_dvec3(), resolution });
        }
    };
    if !(edge > 0.0 && edge.is_finite()) {
        return Err(Error::setting(parameter, format!("cells of {edge} m are not possible")));
    }
    // A domain that is whole cells but for rounding stays as it is.
    let resolution = (extent / edge - 1e-9).ceil().max(DVec3::ONE);
    check_resolution(parameter, "", resolution)?;
    let origin = low - 0.5 * (resolution * edge - extent);
    Ok(Grid { origin, cell_size: DVec3::splat(edge), resolution: resolution.as_uvec3() })
}

pub(crate) fn check_precision(grid: &Grid) -> Result<(), Error> {
    let farthest = grid.origin.abs().max(grid.max_corner().abs()).max_element();
    let edge = grid.cell_size.min_element();
    if farthest <= MAX_EXTENT && edge >= MIN_CELL * farthest {
        return Ok(());
    }
    let reason = format!(
        "cells of {} m up to {} m from the origin are beyond what the map can hold; move the mesh \
         to the origin (`translate`) or check `domain`, `padding` and `thickness`",
        significant(edge, 4),
        significant(farthest, 4)
    );
    Err(Error::setting("domain", reason))
}

fn check_reach(grid: &Grid, support_radius: f64) -> Result<(), Error> {
    let cells = support_radius / grid.cell_size.min_element();
    if cells <= MAX_REACH {
        return Ok(());
    }
    let reason = format!(
        "the cells are {cells:.0} times smaller than the support radius, more than {MAX_REACH:.0} times; take larger \
         cells (2 to 4 along the radius suffice) by this or `resolution`, or a smaller `support_radius`"
    );
    Err(Error::setting("cell_size", reason))
}

/// Told before the work: the values at the far corners of the band's cells need too many steps.
fn check_rounding(grid: &Grid, support_radius: f64, settings: &MapSettings) -> Result<(), Error> {
    let Precision::Rounded(fraction) = settings.precision else { return Ok(()) };
    let farthest = 2.0 * support_radius + grid.cell_size.length();
    let density = settings.density.map(|density| density.largest(farthest, support_radius));
    let largest = density.unwrap_or(0.0).max(farthest / support_radius);
    match Rounded::new(&[largest], 1.0, fraction) {
        Ok(_) => Ok(()),
        Err(error) => Err(Error::setting("max_rounding", error.to_string())),
    }
}

fn check_resolution(parameter: &'static str, before: &str, cells: DVec3) -> Result<(), Error> {
    let reason = if cells.min_element() < 1.0 {
        "an axis has no cell"
    } else if cells.max_element() > f64::from(MAX_CELLS_PER_AXIS) {
        "an axis has more than 1,048,576 cells; take larger ones"
    } else if cells.y * cells.z > MAX_ROWS as f64 {
        "the grid has more than 2^24 rows of cells along x; take larger cells"
    } else {
        return Ok(());
    };
    Err(Error::setting(parameter, format!("{before}{} x {} x {} cells: {reason}", cells.x, cells.y, cells.z)))
}

fn estimate(extent: &Extent, grid: &Grid, margin: UVec3, width: f64, settings: &MapSettings) -> Estimate {
    let cell_volume = grid.cell_size.element_product();
    let resolution = grid.resolution + 2 * margin;
    // The band is a slab of the surface's area, with half a cell's diagonal more on each side, and round rims.
    let depth = width + 0.5 * grid.cell_size.length();
    let size = extent.max - extent.min + 2.0 * settings.thickness.abs();
    // Moved by the thickness, the surface is about as large as its box, or larger.
    let moved = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let area = if settings.thickness == 0.0 { extent.area } else { extent.area.max(moved) };
    let ball = 4.0 / 3.0 * PI * depth.powi(3);
    let band = area * 2.0 * depth + PI * depth * depth * (extent.max - extent.min).length() + ball;
    let cells = (band / cell_volume).min(resolution.as_dvec3().element_product());
    let nodes = 8.0 * cells;
    let bytes_per_node = match settings.precision {
        Precision::F64 => BYTES_PER_DOUBLE_NODE,
        _ => BYTES_PER_NODE,
    };
    let bytes_per_node = bytes_per_node + settings.density.map_or(0, |_| BYTES_PER_DENSITY_NODE);
    let density_points = settings.density.map_or(0, |density| density.rule.points().len());
    let samples = nodes * (settings.rule.points().len() + density_points) as f64;
    let rows = u64::from(resolution.y) * u64::from(resolution.z);
    Estimate {
        cells: cells as u64,
        memory: nodes as u64 * bytes_per_node + rows * BYTES_PER_ROW,
        seconds: samples * SECONDS_PER_SAMPLE + nodes * SECONDS_PER_NODE,
    }
}
