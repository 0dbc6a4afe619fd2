//! Makes a volume map of two cells by hand, writes it and reads it back:
//!
//! ```text
//! cargo run --release -p volmap-formats --example write_asset -- two_cells.h5
//! ```
//!
//! `SPEC.md` says what the numbers mean. A bake computes them.

use std::error::Error;
use std::path::{Path, PathBuf};
use volmap_formats::asset::{
    self, Array, Asset, Attributes, CellRun, Compression, Dimension, Exterior, GridSpec, QuadratureSpec,
};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).map(PathBuf::from);
    println!("{}", write_and_read(&file.ok_or("name the file to write")?)?);
    Ok(())
}

/// Two cells beside each other: 32 nodes each, 12 of them shared (`SPEC.md`, section 5).
const NODES: usize = 52;

fn two_cells() -> Asset {
    Asset {
        dimension: Dimension::Three,
        grid: GridSpec { origin: [0.0; 3], cell_size: [0.5; 3], resolution: [2, 1, 1] },
        support_radius: 0.25,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec { name: "gl30".into(), degree: 30, points: 2000, ball_volume: 0.0654 },
        band_cells: vec![CellRun { i: 0, j: 0, k: 0, len: 2 }],
        solid_cells: Vec::new(),
        finer: Vec::new(),
        // All nodes are 0.3 m outside of the solid: none of it is within the support radius.
        signed_distance: Array::F32(vec![0.3; NODES]),
        volume: Array::F32(vec![0.0; NODES]),
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: [("mesh".to_owned(), "made by hand".into())].into(),
        diagnosis: Attributes::new(),
    }
}

/// Writes the map, and says what it finds when it reads the file.
pub fn write_and_read(file: &Path) -> Result<String, Box<dyn Error>> {
    let made = two_cells();
    asset::write(file, &made, Compression::default())?;
    let read = asset::read(file)?;
    assert_eq!(read, made);
    let mut text = format!("format version {}, {} nodes\n", read.format_version(), read.volume.len());

    // Checksums cover the content: a damaged file is an error, never another number.
    let mut bytes = std::fs::read(file)?;
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    match asset::from_bytes(bytes) {
        Ok(same) => assert_eq!(same, made, "the bit has no meaning"),
        Err(error) => text += &format!("with a bit changed: {error}\n"),
    }
    Ok(text)
}
