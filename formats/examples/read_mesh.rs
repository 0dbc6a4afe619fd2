//! Reads a mesh of any format and says what it is:
//!
//! ```text
//! cargo run --release -p volmap-formats --example read_mesh -- data/duck.obj
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};
use volmap_formats::mesh::{self, CleanSettings, MeshFormat, Placement, UpAxis};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).map(PathBuf::from);
    let file = file.ok_or_else(|| format!("name a mesh file: {}", MeshFormat::list()))?;
    println!("{}", describe(&file)?);
    Ok(())
}

/// What a mesh file holds.
pub fn describe(file: &Path) -> Result<String, Box<dyn Error>> {
    // The polygons that the file has, then triangles without what is double or has no area.
    let raw = mesh::read_mesh(file)?;
    let mut text = format!("{}: {} vertices, {} faces\n", raw.format, raw.positions.len(), raw.faces.len());
    let unit = raw.unit.unwrap_or(1.0);
    let (mut triangles, report) = mesh::clean(raw, &CleanSettings::default())?;
    text +=
        &format!("{} vertices welded, {} duplicate triangles dropped\n", report.welded, report.duplicates);

    // In metres, and y up where z was.
    Placement { unit, up_axis: UpAxis::Z, ..Placement::default() }.apply(&mut triangles)?;
    text += &format!("{} vertices, {} triangles\n", triangles.vertices.len(), triangles.triangles.len());
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let along = || triangles.vertices.iter().map(|vertex| vertex[axis]);
        let lowest = along().fold(f64::INFINITY, f64::min);
        let highest = along().fold(f64::NEG_INFINITY, f64::max);
        text += &format!("{name} from {lowest} to {highest} m\n");
    }
    Ok(text)
}
