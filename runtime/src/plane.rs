//! Maps in two dimensions: Bender et al. 2020, Fig. 11.
//!
//! Their element is the cubic Serendipity quadrilateral of 12 nodes, 4 corners and 2 on each edge. The hexahedron of 32
//! nodes ([`crate::layout::serendipity`]) whose values don't depend on z is the same function, for its shape functions
//! reproduce those of the quadrilateral. So such a map is held as one layer of hexahedra, endless along z, and is asked
//! as any other.

use crate::grid::Grid;
use crate::layout::{Family, Nodes};
use volmap_formats::asset::{Array, Rounded};

/// Nodes in the plane, of each family that has some there: corners, x-edges, y-edges. They are stored in this order,
/// each family by (j, i).
pub(crate) struct PlaneNodes([usize; 3]);

impl PlaneNodes {
    /// Of the nodes of one layer of cells: half of each family lies below it, the other half above.
    pub fn new(layer: &Nodes) -> PlaneNodes {
        PlaneNodes([Family::Corner, Family::EdgeX, Family::EdgeY].map(|family| layer.count_of(family) / 2))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.iter().sum()
    }

    /// The same values below and above the layer and between. `field` is as long as there are nodes.
    pub fn spread(&self, field: &Array) -> Array {
        match field {
            Array::F32(values) => Array::F32(self.spread_values(values)),
            Array::F64(values) => Array::F64(self.spread_values(values)),
            Array::U32(values) => Array::U32(self.spread_values(values)),
            Array::Rounded(rounded) => {
                Array::Rounded(Rounded { multiples: self.spread_values(&rounded.multiples), ..*rounded })
            }
        }
    }

    fn spread_values<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let [corners, x_edges, y_edges] = self.0;
        let (corners, edges) = values.split_at(corners);
        let (x_edges, y_edges) = (&edges[..x_edges], &edges[x_edges..][..y_edges]);
        let z_edges = corners.iter().flat_map(|&corner| [corner, corner]);
        let halves = [corners, corners, x_edges, x_edges, y_edges, y_edges].into_iter().flatten().copied();
        halves.chain(z_edges).collect()
    }
}

/// One layer that holds every z: the place in a cell along z is 0, and gradients along z are 0.
pub(crate) fn endless(mut grid: Grid) -> Grid {
    grid.origin.z = 0.0;
    grid.cell_size.z = f64::INFINITY;
    grid
}
