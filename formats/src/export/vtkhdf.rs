//! Cells of VTK in HDF5 (`.vtkhdf`): UnstructuredGrid, version 1.0, which VTK 9.2 and ParaView 5.11 or newer read.
//! *VTKHDF File Format*, Kitware. Filters are shuffle and gzip: VTK's own HDF5 has no others.
//!
//! Curved cells are written here, so all are of one type: Lagrange hexahedra of degree 3, whose 64 points stand at
//! thirds. Their order is that of `vtkHigherOrderHexahedron::PointIndexFromIJK`.

use super::{ExportError, le_bytes, publish_to};
use crate::asset::filters;
use rayon::prelude::*;
use rust_hdf5::{DatatypeMessage, Filter, FilterPipeline, H5File, H5Type};
use std::ops::Range;
use std::path::Path;

/// Points of a cell.
pub const POINTS: usize = 64;
/// VTK_LAGRANGE_HEXAHEDRON.
const CELL_TYPE: u8 = 72;
const GZIP_LEVEL: u32 = 4;
/// Elements of a chunk.
const CHUNK: usize = 1 << 16;

/// Hexahedra of degree 3 with values at their points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CubicHexahedra {
    /// Places, metres.
    pub points: Vec<[f64; 3]>,
    /// The points of each cell: number i + 4 j + 16 k is at the thirds (i, j, k) of the cell, each 0 to 3.
    pub cells: Vec<[u32; POINTS]>,
    /// Values at the points, by name.
    pub point_data: Vec<(&'static str, Vec<f64>)>,
    /// Numbers of the whole, by name.
    pub field_data: Vec<(&'static str, f64)>,
}

/// VTK's number of the point at the thirds (i, j, k): corners, edges along x and y, edges along z, faces, inner points.
fn vtk_number(i: usize, j: usize, k: usize) -> usize {
    let inner = |n: usize| n == 1 || n == 2;
    let high = |n: usize| usize::from(n == 3);
    // Around the lower face, and around the edges along z.
    let turn = [[0, 3], [1, 2]][high(i)][high(j)];
    match (inner(i), inner(j), inner(k)) {
        (false, false, false) => turn + 4 * high(k),
        (true, false, false) => 8 + (i - 1) + 4 * high(j) + 8 * high(k),
        (false, true, false) => 8 + (j - 1) + if high(i) == 1 { 2 } else { 6 } + 8 * high(k),
        (false, false, true) => 24 + (k - 1) + 2 * turn,
        (false, true, true) => 32 + (j - 1) + 2 * (k - 1) + 4 * high(i),
        (true, false, true) => 40 + (i - 1) + 2 * (k - 1) + 4 * high(j),
        (true, true, false) => 48 + (i - 1) + 2 * (j - 1) + 4 * high(k),
        (true, true, true) => 56 + (i - 1) + 2 * (j - 1) + 4 * (k - 1),
    }
}

/// Writes the cells.
///
/// # Errors
/// A file that can't be written.
pub fn write(path: &Path, grid: &CubicHexahedra) -> Result<(), ExportError> {
    let bytes = to_bytes(grid).map_err(|error| error.in_file(&std::env::temp_dir()))?;
    publish_to(path, &bytes)
}

/// That crate writes files only.
fn to_bytes(grid: &CubicHexahedra) -> Result<Vec<u8>, ExportError> {
    let scratch = tempfile::Builder::new().prefix("volmap-").suffix(".vtkhdf").tempfile()?;
    write_objects(scratch.path(), grid).map_err(|error| ExportError::Container(error.to_string()))?;
    Ok(std::fs::read(scratch.path())?)
}

fn write_objects(path: &Path, grid: &CubicHexahedra) -> rust_hdf5::Result<()> {
    let file = H5File::create(path)?;
    let root = file.create_group("VTKHDF")?;
    root.set_attr_array_numeric("Version", &[1i64, 0])?;
    let kind = b"UnstructuredGrid";
    root.set_attr_typed("Type", DatatypeMessage::fixed_string(kind.len() as u32), kind.to_vec())?;
    root.create_group("PointData")?;
    root.create_group("FieldData")?;
    let (points, cells) = (grid.points.len(), grid.cells.len());
    let counts = [("Points", points), ("Cells", cells), ("ConnectivityIds", cells * POINTS)];
    for (name, n) in counts {
        write_array::<i64>(&file, &format!("NumberOf{name}"), &[1], &|_| (n as i64).to_le_bytes().into())?;
    }
    write_array::<f64>(&file, "Points", &[points, 3], &|rows| {
        le_bytes(grid.points[rows].as_flattened(), f64::to_le_bytes)
    })?;
    write_array::<i64>(&file, "Offsets", &[cells + 1], &|rows| {
        rows.flat_map(|cell| ((cell * POINTS) as i64).to_le_bytes()).collect()
    })?;
    write_array::<u8>(&file, "Types", &[cells], &|rows| vec![CELL_TYPE; rows.len()])?;
    let order = order();
    write_array::<i64>(&file, "Connectivity", &[cells * POINTS], &|rows| {
        let point = |row: usize| grid.cells[row / POINTS][order[row % POINTS]];
        rows.flat_map(|row| i64::from(point(row)).to_le_bytes()).collect()
    })?;
    for (name, values) in &grid.point_data {
        let path = format!("PointData/{name}");
        write_array::<f64>(&file, &path, &[points], &|rows| le_bytes(&values[rows], f64::to_le_bytes))?;
    }
    for (name, value) in &grid.field_data {
        write_array::<f64>(&file, &format!("FieldData/{name}"), &[1], &|_| value.to_le_bytes().into())?;
    }
    file.close_no_sync()
}

/// Our points in VTK's order.
fn order() -> [usize; POINTS] {
    let mut order = [0; POINTS];
    for point in 0..POINTS {
        order[vtk_number(point % 4, point / 4 % 4, point / 16)] = point;
    }
    order
}

/// A dataset of the group of VTK; `bytes` gives the elements of some of its rows.
fn write_array<T: H5Type>(
    file: &H5File,
    name: &str,
    shape: &[usize],
    bytes: &(dyn Fn(Range<usize>) -> Vec<u8> + Sync),
) -> rust_hdf5::Result<()> {
    let (element, row) = (T::element_size(), shape[1..].iter().product::<usize>());
    let path = format!("VTKHDF/{name}");
    let builder = file.new_dataset::<T>().shape(shape);
    // libhdf5's tools stumble over an index of no chunks.
    if shape[0] == 0 {
        return builder.create(&path).map(drop);
    }
    let mut chunk_shape = shape.to_vec();
    chunk_shape[0] = (CHUNK / row).min(shape[0]);
    let filter = |id, value| Filter { id, flags: 0, cd_values: vec![value] };
    let filters = vec![filter(2, element as u32), filter(1, GZIP_LEVEL)];
    let created = builder.chunk(&chunk_shape).filter_pipeline(FilterPipeline { filters }).create(&path)?;
    let chunks = (0..shape[0].div_ceil(chunk_shape[0])).into_par_iter().map(|index| {
        let first = index * chunk_shape[0];
        let mut chunk = bytes(first..shape[0].min(first + chunk_shape[0]));
        // HDF5 stores the last chunk whole.
        chunk.resize(chunk_shape[0] * row * element, 0);
        filters::deflate(&filters::shuffle(&chunk, element), GZIP_LEVEL, element)
    });
    for (index, chunk) in chunks.collect::<std::io::Result<Vec<_>>>()?.iter().enumerate() {
        created.write_chunk_raw(index, chunk, 0)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_ordered_as_vtk_says() {
        // Printed by vtkHigherOrderHexahedron.PointIndexFromIJK of VTK 9.7.2, i fastest.
        let expected = [
            0, 8, 9, 1, 14, 48, 49, 10, 15, 50, 51, 11, 3, 12, 13, 2, 24, 40, 41, 26, 32, 56, 57, 36, 33, 58,
            59, 37, 30, 44, 45, 28, 25, 42, 43, 27, 34, 60, 61, 38, 35, 62, 63, 39, 31, 46, 47, 29, 4, 16,
            17, 5, 22, 52, 53, 18, 23, 54, 55, 19, 7, 20, 21, 6,
        ];
        let numbers: Vec<usize> = (0..POINTS).map(|p| vtk_number(p % 4, p / 4 % 4, p / 16)).collect();
        assert_eq!(numbers, expected);
    }
}
