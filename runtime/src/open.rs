//! Opening a map: what a query relies on.
//!
//! `volmap-formats` guarantees what is about the file alone ([`Asset::check`]): a finite grid, cells in it and in
//! order, fields of one length and type with finite values. Here the tables are derived, and what they show is checked:
//! that there is a value for each node.

use crate::adaptive::{AdaptiveCells, Walls};
use crate::error::Error;
use crate::grid::Grid;
use crate::layout::{CellIndex, FlatWall, Levels, Nodes};
use crate::map::{Content, DensityNodes, VolumeMap};
use crate::plane::{self, PlaneNodes};
use crate::storage::{Pairs, RealPairs, Singles};
use std::borrow::Cow;
use std::path::Path;
use volmap_formats::asset::{self, Array, Asset, DensityField, Dimension};

impl VolumeMap {
    /// Opens an asset.
    ///
    /// # Errors
    /// A file that can't be read, isn't a volume map, is newer than this crate, or is damaged.
    pub fn open(path: impl AsRef<Path>) -> Result<VolumeMap, Error> {
        let path = path.as_ref();
        let in_file = |error| Error::InFile { path: path.to_owned(), error: Box::new(error) };
        from_checked(&asset::read(path)?).map_err(in_file)
    }

    /// Opens an asset from the bytes of its file.
    ///
    /// # Errors
    /// As [`VolumeMap::open`].
    pub fn from_bytes(bytes: Vec<u8>) -> Result<VolumeMap, Error> {
        from_checked(&asset::from_bytes(bytes)?)
    }

    /// Opens an asset that is in memory.
    ///
    /// # Errors
    /// What [`Asset::check`] refuses; fields of another length than there are nodes; 2^32 nodes or more; a density of
    /// a kernel that isn't known.
    pub fn from_asset(asset: &Asset) -> Result<VolumeMap, Error> {
        asset.check()?;
        from_checked(asset)
    }
}

fn from_checked(asset: &Asset) -> Result<VolumeMap, Error> {
    let grid = Grid::from(asset.grid);
    let (content, density) =
        if asset.is_adaptive() { (of_levels(asset, grid)?, None) } else { uniform(asset, grid)? };
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
        content,
        density,
    })
}

fn uniform(asset: &Asset, grid: Grid) -> Result<(Content, Option<DensityNodes>), Error> {
    let nodes = Nodes::new(grid.resolution, &asset.band_cells)
        .ok_or_else(|| Error::inconsistent("/cells/band", "has more than 2^32 nodes"))?;
    let stored = Stored::new(asset.dimension, &nodes);
    let fields = interleave(&asset.signed_distance, &asset.volume, &stored)?;
    let density = asset.density.as_ref().map(|density| density_nodes(density, &stored));
    let cells = CellIndex::new(grid.resolution, &asset.band_cells, &asset.solid_cells, &nodes);
    Ok((Content::Uniform(cells, fields), density.transpose()?))
}

fn of_levels(asset: &Asset, grid: Grid) -> Result<Content, Error> {
    let levels = Levels::for_values(grid, &asset.levels(), asset.signed_distance.len())
        .map_err(|error| Error::inconsistent("/cells/band", error.to_string()))?;
    let fields = complete(&asset.signed_distance, &asset.volume, &levels)?;
    let walls = asset.plane_weight.as_ref().map(|weights| -> Result<Walls, Error> {
        expect_length(
            "/fields/plane_weight",
            weights.len(),
            levels.free_corner_count(),
            "free corner nodes",
        )?;
        let wall = FlatWall::new(asset.support_radius, asset.quadrature.ball_volume);
        Ok(Walls::new(wall, &levels.complete_weights(weights)))
    });
    let walls = walls.transpose()?;
    Ok(Content::Adaptive(AdaptiveCells { tree: levels.into_tree(), walls }, fields))
}

/// The values at all nodes of an adaptive map, from those at the free ones.
fn complete(distance: &Array, volume: &Array, levels: &Levels) -> Result<RealPairs, Error> {
    expect_length("/fields/signed_distance", distance.len(), levels.free_count(), "free nodes")?;
    expect_length("/fields/volume", volume.len(), levels.free_count(), "free nodes")?;
    let single = |x: f64| x as f32;
    match (distance, volume) {
        (Array::F32(d), Array::F32(v)) => {
            let pairs = d.iter().zip(v).map(|(&d, &v)| [d, v]);
            Ok(RealPairs::F32(levels.complete_all(pairs, f64::from, single)))
        }
        (Array::F64(d), Array::F64(v)) => {
            let pairs = d.iter().zip(v).map(|(&d, &v)| [d, v]);
            Ok(RealPairs::F64(levels.complete_all(pairs, |x| x, |x| x)))
        }
        // Between nodes there are values that are no multiples.
        (Array::Rounded(d), Array::Rounded(v)) => {
            let pairs = d.values().zip(v.values()).map(|(d, v)| [d as f32, v as f32]);
            Ok(RealPairs::F32(levels.complete_all(pairs, f64::from, single)))
        }
        _ => Err(Error::inconsistent("/fields", "differ in precision")),
    }
}

fn expect_length(what: &'static str, found: usize, expected: usize, nodes: &str) -> Result<(), Error> {
    match found == expected {
        true => Ok(()),
        false => Err(Error::inconsistent(what, format!("has {found} values for {expected} {nodes}"))),
    }
}

/// Which nodes' values are stored.
struct Stored {
    /// How many.
    nodes: usize,
    /// In two dimensions.
    plane: Option<PlaneNodes>,
}

impl Stored {
    fn new(dimension: Dimension, nodes: &Nodes) -> Stored {
        let plane = (dimension == Dimension::Two).then(|| PlaneNodes::new(nodes));
        Stored { nodes: plane.as_ref().map_or(nodes.count(), PlaneNodes::count), plane }
    }

    /// The values of all nodes of the cells.
    fn all<'a>(&self, what: &'static str, field: &'a Array) -> Result<Cow<'a, Array>, Error> {
        expect_length(what, field.len(), self.nodes, "nodes")?;
        Ok(match &self.plane {
            Some(plane) => Cow::Owned(plane.spread(field)),
            None => Cow::Borrowed(field),
        })
    }
}

fn interleave(distance: &Array, volume: &Array, stored: &Stored) -> Result<Pairs, Error> {
    let distance = stored.all("/fields/signed_distance", distance)?;
    let volume = stored.all("/fields/volume", volume)?;
    Pairs::interleave(&distance, &volume).ok_or_else(|| Error::inconsistent("/fields", "differ in precision"))
}

fn density_nodes(density: &DensityField, stored: &Stored) -> Result<DensityNodes, Error> {
    let kernel = density.kernel.parse();
    let kernel = kernel.map_err(|error: String| Error::inconsistent("/fields/density@kernel", error))?;
    let numbers = Singles::new(&*stored.all("/fields/density", &density.values)?);
    let numbers = numbers.ok_or_else(|| Error::inconsistent("/fields/density", "isn't f32, f64 or i16"))?;
    Ok(DensityNodes { kernel, numbers })
}
