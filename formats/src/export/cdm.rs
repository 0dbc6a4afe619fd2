//! Discregrid's dump of a `CubicLagrangeDiscreteGrid`: the volume maps (`.cdm`) of SPlisHSPlasH and the distances
//! (`.cdf`) of Discregrid and Bullet. Koschier and Bender 2017, *Density Maps for Improved SPH Boundary Handling*.
//!
//! ```text
//! box: lowest, highest corner   6 f64       fields: nodes      u64 fields, each: u64 n, n f64
//! cells along x, y, z           3 u32               cells      u64 fields, each: u64 n, n times 32 u32
//! edges of a cell, their 1/x    6 f64               cell maps  u64 fields, each: u64 n, n u32
//! cells, fields                 2 u64
//! ```
//! Little-endian, without padding, magic, version or checksum. The cell map says of each cell of the grid, x fastest,
//! which of the stored ones it is. The nodes of a stored cell are numbers into the field's nodes.
//!
//! Guaranteed: what is read is a box with as many cells as it says, and every number in it is in range.

use super::{ExportError, publish_to};
use std::path::Path;

/// Value of a node that was not sampled; a cell with such a node has no value.
pub const UNSAMPLED: f64 = f64::MAX;
/// In a cell map: not stored.
pub const REMOVED: u32 = u32::MAX;
/// Nodes of a cell.
pub const NODES: usize = 32;

/// A grid with fields.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteGrid {
    /// Lowest corner of the box, metres.
    pub min: [f64; 3],
    /// Highest corner.
    pub max: [f64; 3],
    /// Cells along x, y, z, at least 1 each.
    pub resolution: [u32; 3],
    /// Edges of a cell, metres.
    pub cell_size: [f64; 3],
    /// The first is the signed distance; in a volume map the second is the volume.
    pub fields: Vec<Field>,
}

/// Values on the cells of a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// Values at the nodes, finite or [`UNSAMPLED`].
    pub nodes: Vec<f64>,
    /// The nodes of each stored cell, in Discregrid's order: see [`local_node`].
    pub cells: Vec<[u32; NODES]>,
    /// The stored cell of each cell of the grid, x fastest, or [`REMOVED`].
    pub cell_map: Vec<u32>,
}

/// Discregrid's place of the asset's local node `a` (`SPEC.md`, section 6), and the other way round: corners and
/// y-edges agree; of the two sides of x- and z-edges the other one runs first.
pub fn local_node(a: usize) -> usize {
    match a / 8 {
        1 | 3 => a & !6 | (a & 2) << 1 | (a & 4) >> 1,
        _ => a,
    }
}

/// Writes a grid.
///
/// # Errors
/// A file that can't be written.
pub fn write(path: &Path, grid: &DiscreteGrid) -> Result<(), ExportError> {
    publish_to(path, &to_bytes(grid))
}

/// The bytes of a grid's file.
pub fn to_bytes(grid: &DiscreteGrid) -> Vec<u8> {
    let mut out = Vec::new();
    let reals = |v: [f64; 3], out: &mut Vec<u8>| v.iter().for_each(|x| out.extend(x.to_le_bytes()));
    let count = |n: usize, out: &mut Vec<u8>| out.extend((n as u64).to_le_bytes());
    reals(grid.min, &mut out);
    reals(grid.max, &mut out);
    grid.resolution.iter().for_each(|n| out.extend(n.to_le_bytes()));
    reals(grid.cell_size, &mut out);
    reals(grid.cell_size.map(|h| 1.0 / h), &mut out);
    out.extend(grid.resolution.iter().map(|&n| u64::from(n)).product::<u64>().to_le_bytes());
    count(grid.fields.len(), &mut out);
    count(grid.fields.len(), &mut out);
    for field in &grid.fields {
        count(field.nodes.len(), &mut out);
        out.extend(field.nodes.iter().flat_map(|x| x.to_le_bytes()));
    }
    count(grid.fields.len(), &mut out);
    for field in &grid.fields {
        count(field.cells.len(), &mut out);
        out.extend(field.cells.as_flattened().iter().flat_map(|n| n.to_le_bytes()));
    }
    count(grid.fields.len(), &mut out);
    for field in &grid.fields {
        count(field.cell_map.len(), &mut out);
        out.extend(field.cell_map.iter().flat_map(|n| n.to_le_bytes()));
    }
    out
}

/// A grid from the bytes of its file; every count, index and number is checked.
///
/// # Errors
/// Bytes that aren't such a dump, or damaged ones. Memory stays in proportion to the bytes.
pub fn from_bytes(bytes: &[u8]) -> Result<DiscreteGrid, ExportError> {
    let mut rest = Bytes(bytes);
    let mut grid = DiscreteGrid {
        min: rest.array(f64::from_le_bytes)?,
        max: rest.array(f64::from_le_bytes)?,
        resolution: rest.array(u32::from_le_bytes)?,
        cell_size: rest.array(f64::from_le_bytes)?,
        fields: Vec::new(),
    };
    let inverse: [f64; 3] = rest.array(f64::from_le_bytes)?;
    check_box(&grid, inverse)?;
    let [cells, fields] = rest.array(u64::from_le_bytes)?;
    if product(grid.resolution) != Some(cells) {
        return damaged(format!("{cells} cells aren't {:?}", grid.resolution));
    }
    // Each field takes three counts of 8 bytes at least.
    if fields == 0 || fields > (rest.0.len() / 24) as u64 {
        return damaged(format!("{fields} fields"));
    }
    let fields = fields as usize;
    rest.expect_count(fields)?;
    let nodes: Vec<_> = (0..fields).map(|_| rest.list(f64::from_le_bytes)).collect::<Result<_, _>>()?;
    rest.expect_count(fields)?;
    let stored: Vec<_> = (0..fields).map(|_| rest.cells()).collect::<Result<_, _>>()?;
    rest.expect_count(fields)?;
    for (nodes, stored) in nodes.into_iter().zip(stored) {
        let field = Field { nodes, cells: stored, cell_map: rest.list(u32::from_le_bytes)? };
        check_field(&field, cells)?;
        grid.fields.push(field);
    }
    match rest.0.len() {
        0 => Ok(grid),
        n => damaged(format!("{n} bytes behind its end")),
    }
}

fn damaged<T>(what: impl Into<String>) -> Result<T, ExportError> {
    Err(ExportError::NotDiscregrid(what.into()))
}

fn product([x, y, z]: [u32; 3]) -> Option<u64> {
    (u64::from(x) * u64::from(y)).checked_mul(z.into())
}

/// A box of cells that are as large as it says, but for rounding.
fn check_box(grid: &DiscreteGrid, inverse: [f64; 3]) -> Result<(), ExportError> {
    for (axis, per_size) in inverse.into_iter().enumerate() {
        let (low, high, cells) = (grid.min[axis], grid.max[axis], grid.resolution[axis]);
        let size = grid.cell_size[axis];
        if !((high - low).is_finite() && low < high && cells > 0) {
            return damaged(format!("{cells} cells from {low:e} to {high:e}"));
        }
        let rounding = 1e-9 * f64::max(low.abs(), high.abs()).max(high - low);
        let fits = (size * f64::from(cells) - (high - low)).abs() <= rounding;
        if !(size > 0.0 && fits && (size * per_size - 1.0).abs() <= 1e-9) {
            return damaged(format!("{cells} cells of {size:e}, 1 / {per_size:e}, {low:e} to {high:e}"));
        }
    }
    Ok(())
}

fn check_field(field: &Field, cells: u64) -> Result<(), ExportError> {
    if field.cell_map.len() as u64 != cells {
        return damaged(format!("a map of {} of {cells} cells", field.cell_map.len()));
    }
    if field.cell_map.iter().any(|&cell| cell != REMOVED && cell as usize >= field.cells.len()) {
        return damaged("a cell that is not stored");
    }
    if field.cells.as_flattened().iter().any(|&node| node as usize >= field.nodes.len()) {
        return damaged("a node without a value");
    }
    match field.nodes.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => damaged("a value that isn't finite"),
    }
}

/// What is left to read.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, bytes: u64) -> Result<&'a [u8], ExportError> {
        let part = usize::try_from(bytes).ok().and_then(|n| self.0.split_at_checked(n));
        let Some((part, rest)) = part else { return damaged("it ends too early") };
        self.0 = rest;
        Ok(part)
    }

    fn array<T, const B: usize, const N: usize>(
        &mut self,
        read: fn([u8; B]) -> T,
    ) -> Result<[T; N], ExportError> {
        let bytes = self.take((B * N) as u64)?.as_chunks::<B>().0;
        Ok(std::array::from_fn(|n| read(bytes[n])))
    }

    /// The bytes of as many elements of `size` bytes as the count before them says.
    fn counted(&mut self, size: u64) -> Result<&'a [u8], ExportError> {
        let [count] = self.array(u64::from_le_bytes)?;
        self.take(count.saturating_mul(size))
    }

    fn list<T, const B: usize>(&mut self, read: fn([u8; B]) -> T) -> Result<Vec<T>, ExportError> {
        Ok(self.counted(B as u64)?.as_chunks::<B>().0.iter().map(|&bytes| read(bytes)).collect())
    }

    fn cells(&mut self) -> Result<Vec<[u32; NODES]>, ExportError> {
        let cells = self.counted(4 * NODES as u64)?.as_chunks::<{ 4 * NODES }>().0;
        let number = |cell: &[u8; 4 * NODES], n: usize| cell.as_chunks::<4>().0[n];
        Ok(cells.iter().map(|cell| std::array::from_fn(|n| u32::from_le_bytes(number(cell, n)))).collect())
    }

    fn expect_count(&mut self, expected: usize) -> Result<(), ExportError> {
        let [count] = self.array(u64::from_le_bytes)?;
        match count == expected as u64 {
            true => Ok(()),
            false => damaged(format!("{count} arrays for {expected} fields")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Two cells, the second removed from the second field.
    fn grid() -> DiscreteGrid {
        let field = |scale: f64| Field {
            nodes: (0..52).map(|n| scale * f64::from(n)).collect(),
            cells: vec![std::array::from_fn(|n| n as u32), std::array::from_fn(|n| 51 - n as u32)],
            cell_map: vec![1, 0],
        };
        let mut second = field(-1.5);
        (second.cell_map[1], second.nodes[51]) = (REMOVED, UNSAMPLED);
        DiscreteGrid {
            min: [-1.0, 0.0, 0.1],
            max: [1.0, 0.5, 0.4],
            resolution: [2, 1, 1],
            cell_size: [1.0, 0.5, 0.4 - 0.1],
            fields: vec![field(0.25), second],
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let bytes = to_bytes(&grid());
        assert_eq!(bytes.len(), 124 + 8 + 2 * (8 + 52 * 8) + 8 + 2 * (8 + 256) + 8 + 2 * (8 + 8));
        assert_eq!(from_bytes(&bytes).unwrap(), grid());
    }

    #[test]
    fn local_nodes_are_an_exchange_of_two_sides() {
        assert!((0..NODES).all(|a| local_node(local_node(a)) == a));
        // Discregrid's node 10 is the lower one on the x-edge at the upper z.
        assert_eq!([8, 9, 10, 12, 15].map(local_node), [8, 9, 12, 10, 15]);
        assert_eq!([0, 3, 18, 20, 26, 28].map(local_node), [0, 3, 18, 20, 28, 26]);
    }

    #[test]
    fn every_truncation_is_refused() {
        let bytes = to_bytes(&grid());
        for length in 0..bytes.len() {
            assert!(from_bytes(&bytes[..length]).is_err(), "{length} bytes");
        }
        assert!(from_bytes(&[bytes, vec![0]].concat()).is_err());
    }

    #[test]
    fn impossible_contents_are_refused_by_name() {
        let refusal = |change: fn(&mut DiscreteGrid)| {
            let mut grid = grid();
            change(&mut grid);
            from_bytes(&to_bytes(&grid)).unwrap_err().to_string()
        };
        for (part, text) in [
            ("finite", refusal(|grid| grid.fields[0].nodes[3] = f64::NAN)),
            ("without a value", refusal(|grid| grid.fields[1].cells[0][31] = 52)),
            ("not stored", refusal(|grid| grid.fields[0].cell_map[0] = 2)),
            ("of 2 cells", refusal(|grid| grid.fields[1].cell_map.push(0))),
            ("from 1e0 to 1e0", refusal(|grid| grid.min[0] = 1.0)),
            ("cells of 6e-1", refusal(|grid| grid.cell_size[1] = 0.6)),
            ("0 fields", refusal(|grid| grid.fields.clear())),
        ] {
            assert!(text.contains(part), "{text}");
        }
    }

    proptest! {
        #[test]
        fn flipped_bits_never_panic_and_what_is_read_is_in_range(
            flips in prop::collection::vec((0usize..2000, 0u8..8), 1..4)
        ) {
            let mut bytes = to_bytes(&grid());
            for (at, bit) in flips {
                let length = bytes.len();
                bytes[at % length] ^= 1 << bit;
            }
            if let Ok(read) = from_bytes(&bytes) {
                for field in &read.fields {
                    prop_assert_eq!(field.cell_map.len() as u64, product(read.resolution).unwrap());
                    for &cell in field.cell_map.iter().filter(|&&cell| cell != REMOVED) {
                        prop_assert!(field.cells[cell as usize].iter().all(|&n| field.nodes[n as usize].is_finite()));
                    }
                }
            }
        }

        #[test]
        fn any_bytes_are_refused_or_read(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            prop_assert!(from_bytes(&bytes).is_err());
        }
    }
}
