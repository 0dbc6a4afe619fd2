//! How a map is laid out: what a program needs that writes assets, converts them, or walks their cells. Who only
//! samples maps needs nothing of it.
//!
//! - [`Nodes`] numbers the nodes of a sparse set of cells, in the order in which an asset stores its fields;
//! - [`Levels`] does the same for the cells of an adaptive map, which are of several sizes;
//! - [`FlatWall`] is what adaptive maps may store the volume's difference from;
//! - [`CellIndex`] finds the 32 node numbers of a cell;
//! - [`serendipity`] is the element: its nodes, shape functions and monomials, in their one order.
//!
//! The values of a field are those at the nodes, in the order of their numbers:
//!
//! ```
//! use volmap_runtime::layout::{CellRun, GridSpec, Nodes};
//! use volmap_runtime::{DVec3, Grid};
//!
//! let grid = Grid::from(GridSpec { origin: [0.0; 3], cell_size: [0.5; 3], resolution: [2, 1, 1] });
//! let nodes = Nodes::new(grid.resolution, &[CellRun { i: 0, j: 0, k: 0, len: 2 }]).expect("fewer than 2^32");
//! let places: Vec<DVec3> = nodes.positions(&grid).collect();
//! assert_eq!((nodes.count(), places.len()), (52, 52));
//! assert_eq!(places[1], DVec3::new(0.5, 0.0, 0.0));
//! ```

mod cells;
mod levels;
mod nodes;
pub mod serendipity;

pub use crate::flat_wall::FlatWall;
pub use cells::{Cell, CellIndex, NodeNumbers};
pub(crate) use cells::{Found, Hint, Place, Starts};
pub use levels::{CornerWeights, Held, LevelCell, Levels, LevelsError};
pub(crate) use levels::{Tree, TreeHint};
pub use nodes::{Family, NodeInterval, Nodes};
pub use volmap_formats::asset::{CellRun, GridSpec, LevelCells};
