//! Reads a mesh of any format and says what it is:
//!
//! ```text
//! cargo run --release -p volmap-formats --example read_mesh -- data/duck.obj
//! ```

use std::error::Error;
use std::path::Path;
use volmap_formats::mesh::{self, CleanSettings, MeshFormat, Placement, UpAxis};

fn main() -> Result<(), Box<dyn Error>> {
    let Some(file) = std::env::args_os().nth(1) else {
        return Err(format!("name a mesh file: one of {}", MeshFormat::list()).into());
    };
    // Polygons as the file has them, then triangles without what is double or collapsed.
    let raw = mesh::read_mesh(Path::new(&file))?;
    println!("{}: {} vertices, {} faces", raw.format, raw.positions.len(), raw.faces.len());
    let unit = raw.unit.unwrap_or(1.0);
    let (mut triangles, report) = mesh::clean(raw, &CleanSettings::default())?;
    println!("{} vertices welded, {} duplicate triangles dropped", report.welded, report.duplicates);

    // From the file's unit and axes to metres, y up.
    Placement { unit, up_axis: UpAxis::Z, ..Placement::default() }.apply(&mut triangles)?;
    println!("{} vertices, {} triangles", triangles.vertices.len(), triangles.triangles.len());
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let along = || triangles.vertices.iter().map(|vertex| vertex[axis]);
        let (lowest, highest) =
            (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        println!("{name} from {lowest} to {highest} m");
    }
    Ok(())
}
