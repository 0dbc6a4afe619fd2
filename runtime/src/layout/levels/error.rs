//! What can be wrong with the cells of several levels.

use glam::UVec3;

/// Why a set of cells is no adaptive map's. The cell is named by its level and its index on that level's lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LevelsError {
    /// A cell is listed and holds listed cells of finer levels.
    #[error("cell ({}, {}, {}) of level {level} holds cells of finer levels", cell.x, cell.y, cell.z)]
    Nested {
        /// Level of the larger cell.
        level: u32,
        /// The larger cell.
        cell: UVec3,
    },
    /// Cells that touch differ by two levels or more.
    #[error("cell ({}, {}, {}) of level {level} touches cells two levels finer", cell.x, cell.y, cell.z)]
    Unbalanced {
        /// Level of the larger cell.
        level: u32,
        /// The larger cell.
        cell: UVec3,
    },
    /// More than 2^32 nodes, or 2^30 runs or refined cells.
    #[error("the cells have too many nodes")]
    TooMany,
    /// The cells can't all have values of their own: a file that would take much more memory than its size.
    #[error("{cells} cells can't belong to {values} values at their nodes")]
    TooFewValues {
        /// Stored cells, or cells that hold finer ones.
        cells: u64,
        /// Values.
        values: u64,
    },
}
