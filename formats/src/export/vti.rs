//! Equally spaced points with values, as VTK's XML ImageData (`.vti`), version 1.0, raw appended data.
//! *VTK File Formats*, Kitware.

use super::{ExportError, publish_to};
use std::fmt::Write;
use std::path::Path;

/// Points `origin + spacing * (i, j, k)`, i fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Lowest point, metres.
    pub origin: [f64; 3],
    /// Steps along x, y, z, metres.
    pub spacing: [f64; 3],
    /// Points along x, y, z, at least 1.
    pub points: [u32; 3],
    /// Values at the points, each with its name, which is plain text without quotation marks.
    pub arrays: Vec<(&'static str, Numbers)>,
}

/// Values of one type, one a point.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// Small integers.
    U8(Vec<u8>),
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

impl Numbers {
    fn type_name(&self) -> &'static str {
        match self {
            Numbers::U8(_) => "UInt8",
            Numbers::F32(_) => "Float32",
            Numbers::F64(_) => "Float64",
        }
    }

    fn le_bytes(&self) -> Vec<u8> {
        match self {
            Numbers::U8(v) => v.clone(),
            Numbers::F32(v) => super::le_bytes(v, f32::to_le_bytes),
            Numbers::F64(v) => super::le_bytes(v, f64::to_le_bytes),
        }
    }
}

/// Writes an image.
///
/// # Errors
/// A file that can't be written.
pub fn write(path: &Path, image: &Image) -> Result<(), ExportError> {
    publish_to(path, &to_bytes(image))
}

fn to_bytes(image: &Image) -> Vec<u8> {
    let [x, y, z] = image.points.map(|n| n.saturating_sub(1));
    let list = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    let extent = format!("0 {x} 0 {y} 0 {z}");
    let mut header = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">\n\
         <Piece Extent=\"{extent}\">\n<PointData>\n",
        list(image.origin),
        list(image.spacing)
    );
    let mut data = Vec::new();
    for (name, numbers) in &image.arrays {
        _ = writeln!(
            header,
            "<DataArray type=\"{}\" Name=\"{name}\" format=\"appended\" offset=\"{}\"/>",
            numbers.type_name(),
            data.len()
        );
        let bytes = numbers.le_bytes();
        data.extend((bytes.len() as u64).to_le_bytes());
        data.extend(bytes);
    }
    header += "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
    let mut out = header.into_bytes();
    out.extend(data);
    out.extend(b"\n</AppendedData>\n</VTKFile>\n");
    out
}
