//! Bakes a mesh that is made in the program, and writes the asset.
//!
//! `cargo run --release -p volmap-bake --example bake_arrays`

use std::error::Error;
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{InputSettings, from_arrays};
use volmap_bake::settings::{GridChoice, MapSettings};
use volmap_bake::watch::Watch;
use volmap_formats::asset::{self, Compression};

/// A regular octahedron around the origin: corners on the axes, faces counterclockwise seen from outside.
const VERTICES: [[f64; 3]; 6] =
    [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, 0.5], [0.0, 0.0, -0.5]];
const TRIANGLES: [[u32; 3]; 8] =
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // The mesh is checked and cleaned as that of a file.
    let input = from_arrays("octahedron", &VERTICES, &TRIANGLES, &InputSettings::default())?;

    // Particles of radius 2.5 cm have kernels of support radius 10 cm. What isn't said has its default.
    let map =
        MapSettings { support_radius: Some(0.1), grid: GridChoice::CellSize(0.05), ..MapSettings::default() };
    let baked = bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default())?;
    println!("{}", baked.summary);

    // Published whole or not at all.
    let file = std::env::temp_dir().join(format!("octahedron-{}.h5", std::process::id()));
    asset::write(&file, &baked.asset, Compression::default())?;
    println!("{} holds {} nodes", file.display(), baked.asset.volume.len());
    Ok(std::fs::remove_file(file)?)
}
