//! Whether the parts of an asset fit each other: the one place that says so. What depends on the file alone is checked
//! while it is read (`schema.rs`): that all is there and of the right type.

use super::error::AssetError;
use super::schema::{DENSITY, DensityField, PLANE_WEIGHT};
use super::tree::{Array, MAX_ERROR, STEP};
use super::{Asset, CellRun, Dimension, GridSpec, MAX_CELLS_PER_AXIS, MAX_LEVELS, MAX_ROWS};

impl Asset {
    /// Checks the asset: the grid is a finite box of 1 to 2^20 cells an axis and at most 2^24 rows, of one layer in two
    /// dimensions; lengths and integrals are positive and finite; the cells lie in the grid, in order, each in one run
    /// at most; the fields have one length and type, and finite values. In adaptive maps the same of the cells of each
    /// level; they are in space and without a density, have [`MAX_LEVELS`] levels at most and at most 2^20 cells of the
    /// finest one an axis, and weights that are 0 or 1. Reading a file does this too.
    ///
    /// Not checked: that there are as many values as nodes, and what cells of different levels are to each other.
    /// Numbering the nodes is up to who uses them.
    ///
    /// # Errors
    /// [`AssetError::Invalid`] with the first part that is wrong.
    pub fn check(&self) -> Result<(), AssetError> {
        check_grid(&self.grid, self.dimension)?;
        check_positive("/grid@support_radius", self.support_radius)?;
        check_positive("/quadrature@ball_volume", self.quadrature.ball_volume)?;
        check_cells(0, &self.band_cells, &self.solid_cells, self.grid.resolution)?;
        check_adaptive(self)?;
        check_field("/fields/signed_distance", &self.signed_distance, &self.signed_distance)?;
        check_field("/fields/volume", &self.volume, &self.signed_distance)?;
        self.density.as_ref().map_or(Ok(()), |density| check_density(density, &self.signed_distance))
    }
}

fn check_grid(grid: &GridSpec, dimension: Dimension) -> Result<(), AssetError> {
    let [_, y, z] = grid.resolution;
    if grid.resolution.iter().any(|n| !(1..=MAX_CELLS_PER_AXIS).contains(n)) {
        return Err(AssetError::invalid("/grid@resolution", "is outside 1 to 1048576 cells an axis"));
    }
    if u64::from(y) * u64::from(z) > MAX_ROWS {
        return Err(AssetError::invalid("/grid@resolution", "has more than 2^24 rows of cells"));
    }
    if dimension == Dimension::Two && z != 1 {
        return Err(AssetError::invalid(
            "/grid@resolution",
            "has more than one cell along z in two dimensions",
        ));
    }
    if grid.cell_size.iter().any(|&h| !(h > 0.0 && h.is_finite())) {
        return Err(AssetError::invalid("/grid@cell_size", "isn't positive and finite"));
    }
    let high = |axis: usize| grid.origin[axis] + grid.cell_size[axis] * f64::from(grid.resolution[axis]);
    match (0..3).all(|axis| grid.origin[axis].is_finite() && high(axis).is_finite()) {
        true => Ok(()),
        false => Err(AssetError::invalid("/grid@origin", "isn't the corner of a finite box of cells")),
    }
}

fn check_positive(what: &str, value: f64) -> Result<(), AssetError> {
    match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(AssetError::invalid(what, "isn't positive and finite")),
    }
}

/// The cells of one level.
fn check_cells(
    level: usize,
    band: &[CellRun],
    solid: &[CellRun],
    resolution: [u32; 3],
) -> Result<(), AssetError> {
    check_runs("/cells/band", level, band, resolution)?;
    check_runs("/cells/solid", level, solid, resolution)?;
    check_disjoint(band, solid)
}

/// What adaptive maps have beside the cells of level 0.
fn check_adaptive(asset: &Asset) -> Result<(), AssetError> {
    if asset.finer.is_empty() && asset.plane_weight.is_none() {
        return Ok(());
    }
    if asset.dimension != Dimension::Three || asset.density.is_some() {
        return Err(AssetError::invalid(
            "/cells",
            "has levels or weights, which are for volumes in space alone",
        ));
    }
    if asset.finer.len() >= MAX_LEVELS {
        return Err(AssetError::invalid("/cells/band", format!("has more than {MAX_LEVELS} levels")));
    }
    if asset.grid.resolution.iter().any(|&n| u64::from(n) << asset.finer.len() > MAX_CELLS_PER_AXIS.into()) {
        return Err(AssetError::invalid(
            "/grid@resolution",
            "is over 1048576 cells of the finest level an axis",
        ));
    }
    for (level, cells) in (1..).zip(&asset.finer) {
        check_cells(level, &cells.band, &cells.solid, asset.grid.resolution.map(|n| n << level))?;
    }
    match asset.plane_weight.iter().flatten().any(|&weight| weight > 1) {
        true => Err(AssetError::invalid(PLANE_WEIGHT, "has numbers other than 0 and 1")),
        false => Ok(()),
    }
}

fn check_runs(what: &str, level: usize, runs: &[CellRun], [x, y, z]: [u32; 3]) -> Result<(), AssetError> {
    let of_level = if level == 0 { String::new() } else { format!(" of level {level}") };
    let mut free = (0, 0, 0);
    for (row, run) in runs.iter().enumerate() {
        let end = run.i.checked_add(run.len).filter(|&end| end <= x && run.len > 0);
        let (Some(end), true, true) = (end, run.j < y, run.k < z) else {
            return Err(AssetError::invalid(what, format!("row {row}{of_level} lies outside the grid")));
        };
        if (run.k, run.j, run.i) < free {
            return Err(AssetError::invalid(what, format!("row {row}{of_level} is out of order")));
        }
        free = (run.k, run.j, end);
    }
    Ok(())
}

fn check_disjoint(band: &[CellRun], solid: &[CellRun]) -> Result<(), AssetError> {
    let mut all: Vec<&CellRun> = band.iter().chain(solid).collect();
    all.sort_unstable_by_key(|run| (run.k, run.j, run.i));
    let overlap = |pair: &[&CellRun]| {
        (pair[0].k, pair[0].j) == (pair[1].k, pair[1].j) && pair[0].i + pair[0].len > pair[1].i
    };
    match all.windows(2).any(overlap) {
        true => Err(AssetError::invalid("/cells/solid", "overlaps /cells/band")),
        false => Ok(()),
    }
}

/// `first` is the field whose length and type the others share.
fn check_field(what: &str, field: &Array, first: &Array) -> Result<(), AssetError> {
    match field {
        Array::U32(_) => return Err(AssetError::invalid(what, "isn't f32, f64 or i16")),
        Array::Rounded(rounded) if !(rounded.step > 0.0 && rounded.step.is_finite()) => {
            return Err(AssetError::invalid(format!("{what}@{STEP}"), "isn't positive and finite"));
        }
        Array::Rounded(rounded) if !(rounded.max_error >= 0.0 && rounded.max_error.is_finite()) => {
            return Err(AssetError::invalid(format!("{what}@{MAX_ERROR}"), "isn't a finite bound"));
        }
        Array::Rounded(_) | Array::F32(_) | Array::F64(_) => {}
    }
    if field.type_name() != first.type_name() {
        return Err(AssetError::invalid(what, "differs from /fields/signed_distance in precision"));
    }
    if field.len() != first.len() {
        let reason = format!("has {} values and /fields/signed_distance has {}", field.len(), first.len());
        return Err(AssetError::invalid(what, reason));
    }
    match field.is_finite() {
        true => Ok(()),
        false => Err(AssetError::invalid(what, "has values that aren't finite")),
    }
}

fn check_density(density: &DensityField, first: &Array) -> Result<(), AssetError> {
    check_positive(&format!("{DENSITY}@extension_length"), density.extension_length)?;
    check_positive(&format!("{DENSITY}@kernel_integral"), density.kernel_integral)?;
    check_field(DENSITY, &density.values, first)
}
