//! The volume-map asset: what a bake leaves on disk and a simulation loads. `SPEC.md` is its description.
//!
//! ```text
//! Asset  <- schema ->  Tree (groups, attributes, arrays)  <- write / read ->  HDF5 bytes
//! ```

mod check;
mod error;
pub(crate) mod filters;
#[cfg(feature = "write")]
pub(crate) mod publish;
mod read;
mod rounded;
mod schema;
mod tree;
#[cfg(feature = "write")]
mod write;

pub use error::AssetError;
#[cfg(feature = "write")]
pub use publish::{NewFile, clear_leftovers};
pub use rounded::{Rounded, RoundingError};
pub use schema::{DensityField, FORMAT_NAME, FORMAT_VERSION, MAX_CELLS_PER_AXIS, MAX_LEVELS, MAX_ROWS};
pub use tree::{Array, Attributes, Dataset, Tree, Value};
#[cfg(feature = "write")]
pub use write::Compression;

use std::path::Path;

/// The lattice of cells: `origin` is its lowest corner, `cell_size` in metres, `resolution` in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridSpec {
    /// Lowest corner of the domain, metres.
    pub origin: [f64; 3],
    /// Edge lengths of a cell, metres.
    pub cell_size: [f64; 3],
    /// Cells along x, y, z.
    pub resolution: [u32; 3],
}

/// In how many dimensions a map's solid lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dimension {
    /// In the plane: distances are those of a curve, the volume is an area (m^2), and nothing depends on z.
    Two,
    /// In space.
    #[default]
    Three,
}

impl Dimension {
    /// 2 or 3.
    pub fn count(self) -> u64 {
        match self {
            Dimension::Two => 2,
            Dimension::Three => 3,
        }
    }
}

/// Consecutive cells along x: `(i .. i + len, j, k)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellRun {
    /// First cell along x.
    pub i: u32,
    /// Row along y.
    pub j: u32,
    /// Row along z.
    pub k: u32,
    /// Number of cells, at least 1.
    pub len: u32,
}

/// The cells of one level of an adaptive map, on that level's lattice, each list sorted by (k, j, i).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LevelCells {
    /// Stored cells.
    pub band: Vec<CellRun>,
    /// Cells deeper in the solid than the band.
    pub solid: Vec<CellRun>,
}

/// What fills the space outside the grid's domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exterior {
    /// Free space: no boundary there.
    Fluid,
    /// Solid, as around the inside of a container.
    Solid,
}

/// The rule that integrated the volume, Eq. 12 of Bender et al. 2020.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadratureSpec {
    /// Name, `gl30`, `ball8`: see `SPEC.md`, section 8.
    pub name: String,
    /// Polynomial exactness of the rule per axis.
    pub degree: u32,
    /// Points inside the ball.
    pub points: u64,
    /// Volume that the rule gives the full ball, m^3 (the exact one is 4/3 pi r^3). In two dimensions the disc's area,
    /// m^2.
    pub ball_volume: f64,
}

/// A volume map with all that is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Asset {
    /// In how many dimensions. In two, the grid has one cell along z, and only nodes in the plane are stored.
    pub dimension: Dimension,
    /// The lattice of cells.
    pub grid: GridSpec,
    /// Support radius r of the kernels that the map serves, metres.
    pub support_radius: f64,
    /// What lies outside the domain.
    pub exterior: Exterior,
    /// How the volume was integrated.
    pub quadrature: QuadratureSpec,
    /// Stored cells, those with a point of |Phi| <= 2 r, sorted by (k, j, i).
    pub band_cells: Vec<CellRun>,
    /// Cells deeper in the solid than the band, sorted by (k, j, i).
    pub solid_cells: Vec<CellRun>,
    /// Cells of the levels 1, 2, ... of an adaptive map, each of half the size of those before; empty in uniform maps.
    /// `band_cells` and `solid_cells` are level 0's.
    pub finer: Vec<LevelCells>,
    /// Signed distance at the nodes, metres, negative inside the solid ([`Array::F32`], [`Array::F64`]
    /// or [`Array::Rounded`]).
    pub signed_distance: Array,
    /// Boundary volume at the nodes, m^3 (in two dimensions area, m^2), in the same precision.
    pub volume: Array,
    /// 0 or 1 at the free corner nodes of an adaptive map: how much of the volume is that of a flat wall at the node's
    /// distance, of which `volume` then holds the difference. `None` where the volume is stored plainly.
    pub plane_weight: Option<Vec<u32>>,
    /// Boundary density at the nodes, if it was baked too.
    pub density: Option<DensityField>,
    /// Effective value of every parameter of the bake.
    pub bake: Attributes,
    /// Where the map comes from: mesh file, its hash, triangles, bounding box, program.
    pub source: Attributes,
    /// What was found of the mesh: closed, oriented, holes.
    pub diagnosis: Attributes,
}

/// Reads an asset; every length, range and checksum is checked.
///
/// # Errors
/// A file that can't be read, isn't an asset, is of a newer version, or is damaged.
pub fn read(path: &Path) -> Result<Asset, AssetError> {
    let bytes = std::fs::read(path).map_err(|error| AssetError::Io(error).in_file(path))?;
    from_bytes(bytes).map_err(|error| error.in_file(path))
}

/// Reads an asset from the bytes of its file.
///
/// # Errors
/// As [`read`], without the file's name.
pub fn from_bytes(bytes: Vec<u8>) -> Result<Asset, AssetError> {
    schema::read(bytes)
}

/// Whether `path` can be written to, as far as it shows without trying: to be asked before a long bake.
///
/// # Errors
/// A folder or a device in its place, or no folder to hold it.
#[cfg(feature = "write")]
pub fn check_target(path: &Path) -> Result<(), AssetError> {
    publish::check_target(path).map_err(|error| AssetError::Io(error).in_file(path))
}

/// Makes a file of these bytes; it appears whole or not at all, as assets do.
///
/// # Errors
/// A folder that can't be written to. An existing file at `path` stays as it was.
#[cfg(feature = "write")]
pub fn publish(path: &Path, bytes: &[u8]) -> Result<(), AssetError> {
    publish::publish(bytes, path).map_err(|error| AssetError::Io(error).in_file(path))
}

/// Writes an asset: the file of [`encode`]'s bytes at `path` appears whole.
///
/// # Errors
/// A folder that can't be written to. An existing file at `path` stays as it was.
#[cfg(feature = "write")]
pub fn write(path: &Path, asset: &Asset, compression: Compression) -> Result<(), AssetError> {
    publish(path, &encode(asset, compression).map_err(|error| error.in_file(path))?)
}

/// The bytes of an asset's file: written to a scratch file in the system's temporary folder, read back and compared.
/// They are a function of the asset and the compression alone.
///
/// # Errors
/// An asset that would be refused when read; no room for the scratch file.
#[cfg(feature = "write")]
pub fn encode(asset: &Asset, compression: Compression) -> Result<Vec<u8>, AssetError> {
    write::encode(&schema::tree_from_asset(asset), compression)
}
