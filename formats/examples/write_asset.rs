//! Makes a volume map of two cells by hand, writes it and reads it back:
//!
//! ```text
//! cargo run --release -p volmap-formats --example write_asset -- two_cells.h5
//! ```
//!
//! `SPEC.md` says what the numbers mean; a bake computes them.

use std::error::Error;
use std::path::PathBuf;
use volmap_formats::asset::{
    self, Array, Asset, AssetError, Attributes, CellRun, Compression, Dimension, Exterior, GridSpec,
    QuadratureSpec,
};

/// Two cells beside each other share the nodes between them: 32 + 20 (SPEC.md, section 5).
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
        // Far from any surface: 0.3 m outside of it, where no solid is within the ball.
        signed_distance: Array::F32(vec![0.3; NODES]),
        volume: Array::F32(vec![0.0; NODES]),
        density: None,
        bake: Attributes::new(),
        source: [("mesh".to_owned(), "made by hand".into())].into(),
        diagnosis: Attributes::new(),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = PathBuf::from(std::env::args_os().nth(1).ok_or("name the file to write")?);
    let made = two_cells();
    asset::write(&path, &made, Compression::default())?;
    let read = asset::read(&path)?;
    assert_eq!(read, made);
    println!(
        "{} nodes in {} runs of cells, format version {}",
        read.volume.len(),
        read.band_cells.len(),
        read.format_version()
    );

    // Every byte is covered by a checksum: a damaged file is an error, never another number.
    let mut bytes = std::fs::read(&path)?;
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    match asset::from_bytes(bytes) {
        Ok(same) => assert_eq!(same, made, "a bit that means nothing"),
        Err(AssetError::Io(error)) => return Err(error.into()),
        Err(error) => println!("with a bit changed: {error}"),
    }
    Ok(())
}
