//! Opening a map: everything that a query relies on is checked here, once.

use crate::cells::CellIndex;
use crate::density::DensityNodes;
use crate::error::Error;
use crate::fields::{Fields, Numbers};
use crate::grid::Grid;
use crate::nodes::Nodes;
use crate::plane::{self, PlaneNodes};
use crate::query::VolumeMap;
use glam::{DVec3, UVec3};
use std::borrow::Cow;
use std::path::Path;
use volmap_formats::asset::{
    self, Array, Asset, CellRun, DensityField, Dimension, MAX_CELLS_PER_AXIS, MAX_ROWS,
};

impl VolumeMap {
    /// Opens an asset.
    ///
    /// # Errors
    /// A file that can't be read, isn't a volume map, is newer than this crate, or is damaged.
    pub fn open(path: &Path) -> Result<VolumeMap, Error> {
        let in_file = |source| Error::InFile { path: path.to_owned(), source: Box::new(source) };
        VolumeMap::from_asset(&asset::read(path)?).map_err(in_file)
    }

    /// Opens an asset from the bytes of its file.
    ///
    /// # Errors
    /// As [`VolumeMap::open`].
    pub fn from_bytes(bytes: Vec<u8>) -> Result<VolumeMap, Error> {
        VolumeMap::from_asset(&asset::from_bytes(bytes)?)
    }

    /// Opens an asset that is in memory.
    ///
    /// # Errors
    /// A grid without cells or of infinite extent, a radius that isn't positive, cells outside the grid or out of
    /// order, fields of another length than the nodes or with values that aren't finite.
    pub fn from_asset(asset: &Asset) -> Result<VolumeMap, Error> {
        let grid = Grid::from(asset.grid);
        check_grid(&grid)?;
        check_plane(asset.dimension, &grid)?;
        if !(asset.support_radius > 0.0 && asset.support_radius.is_finite()) {
            return Err(Error::inconsistent("/grid@support_radius", "isn't positive and finite"));
        }
        check_runs("/cells/band", &asset.band_cells, grid.resolution)?;
        check_runs("/cells/solid", &asset.solid_cells, grid.resolution)?;
        check_disjoint(&asset.band_cells, &asset.solid_cells)?;
        let nodes = Nodes::new(grid.resolution, &asset.band_cells)
            .ok_or_else(|| Error::inconsistent("/cells/band", "has more than 2^32 nodes"))?;
        let layout = Layout::new(asset.dimension, &nodes);
        let fields = interleave(&asset.signed_distance, &asset.volume, &layout)?;
        let density = asset.density.as_ref().map(|density| density_nodes(asset, density, &layout));
        let grid = match asset.dimension {
            Dimension::Two => plane::endless(grid),
            Dimension::Three => grid,
        };
        Ok(VolumeMap {
            dimension: asset.dimension,
            grid,
            per_cell: 1.0 / grid.cell_size,
            support_radius: asset.support_radius,
            exterior: asset.exterior,
            quadrature: asset.quadrature.clone(),
            cells: CellIndex::new(grid.resolution, &asset.band_cells, &asset.solid_cells, &nodes),
            fields,
            density: density.transpose()?,
        })
    }
}

fn check_grid(grid: &Grid) -> Result<(), Error> {
    let resolution = grid.resolution;
    if resolution.min_element() == 0 || resolution.max_element() > MAX_CELLS_PER_AXIS {
        return Err(Error::inconsistent("/grid@resolution", "is outside 1 to 1048576 cells an axis"));
    }
    if u64::from(resolution.y) * u64::from(resolution.z) > MAX_ROWS {
        return Err(Error::inconsistent("/grid", "has more than 2^24 rows of cells"));
    }
    if !(grid.cell_size.cmpgt(DVec3::ZERO).all() && grid.origin.is_finite() && grid.max_corner().is_finite())
    {
        return Err(Error::inconsistent("/grid", "isn't a finite box of cells larger than zero"));
    }
    Ok(())
}

fn check_plane(dimension: Dimension, grid: &Grid) -> Result<(), Error> {
    match dimension == Dimension::Two && grid.resolution.z != 1 {
        true => {
            Err(Error::inconsistent("/grid@resolution", "has more than one cell along z in two dimensions"))
        }
        false => Ok(()),
    }
}

fn check_runs(what: &'static str, runs: &[CellRun], resolution: UVec3) -> Result<(), Error> {
    let mut free = (0, 0, 0);
    for (row, run) in runs.iter().enumerate() {
        let end = run.i.checked_add(run.len).filter(|&end| end <= resolution.x && run.len > 0);
        let (Some(end), true, true) = (end, run.j < resolution.y, run.k < resolution.z) else {
            return Err(Error::inconsistent(what, format!("row {row} lies outside the grid")));
        };
        if (run.k, run.j, run.i) < free {
            return Err(Error::inconsistent(what, format!("row {row} is out of order")));
        }
        free = (run.k, run.j, end);
    }
    Ok(())
}

fn check_disjoint(band: &[CellRun], solid: &[CellRun]) -> Result<(), Error> {
    let mut all: Vec<&CellRun> = band.iter().chain(solid).collect();
    all.sort_unstable_by_key(|run| (run.k, run.j, run.i));
    let overlap = |pair: &[&CellRun]| {
        (pair[0].k, pair[0].j) == (pair[1].k, pair[1].j) && pair[0].i + pair[0].len > pair[1].i
    };
    match all.windows(2).any(overlap) {
        true => Err(Error::inconsistent("/cells/solid", "overlaps /cells/band")),
        false => Ok(()),
    }
}

/// Which nodes' values are stored.
struct Layout {
    /// How many.
    nodes: usize,
    /// In two dimensions.
    plane: Option<PlaneNodes>,
}

impl Layout {
    fn new(dimension: Dimension, nodes: &Nodes) -> Layout {
        let plane = (dimension == Dimension::Two).then(|| PlaneNodes::new(nodes));
        Layout { nodes: plane.as_ref().map_or(nodes.count(), PlaneNodes::count), plane }
    }

    /// The values of all nodes of the cells.
    fn all<'a>(&self, field: &'a Array) -> Cow<'a, Array> {
        match &self.plane {
            Some(plane) => Cow::Owned(plane.spread(field)),
            None => Cow::Borrowed(field),
        }
    }
}

fn interleave(distance: &Array, volume: &Array, layout: &Layout) -> Result<Fields, Error> {
    check_field("/fields/signed_distance", distance, layout.nodes)?;
    check_field("/fields/volume", volume, layout.nodes)?;
    let fields = Fields::interleave(&layout.all(distance), &layout.all(volume));
    fields.ok_or_else(|| Error::inconsistent("/fields", "differ in precision"))
}

fn check_field(what: &'static str, field: &Array, nodes: usize) -> Result<(), Error> {
    if field.len() != nodes {
        let reason = format!("has {} values for {nodes} nodes", field.len());
        return Err(Error::inconsistent(what, reason));
    }
    if !field.is_finite() {
        return Err(Error::inconsistent(what, "has values that aren't finite"));
    }
    if matches!(field, Array::Rounded(rounded) if !rounded.has_sound_attributes()) {
        return Err(Error::inconsistent(what, "has a step that isn't positive, or no finite bound"));
    }
    Ok(())
}

fn density_nodes(asset: &Asset, density: &DensityField, layout: &Layout) -> Result<DensityNodes, Error> {
    check_field("/fields/density", &density.values, layout.nodes)?;
    let same_type = density.values.type_name() == asset.volume.type_name();
    let numbers = Numbers::new(&layout.all(&density.values)).filter(|_| same_type);
    let numbers = numbers.ok_or_else(|| Error::inconsistent("/fields", "differ in precision"))?;
    Ok(DensityNodes { kernel: density.kernel.clone(), numbers })
}
