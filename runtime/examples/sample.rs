//! Opens a map and asks it about a few points:
//!
//! ```text
//! cargo run --release -p volmap-runtime --example sample -- [ASSET]
//! ```
//!
//! Without an asset it makes one of a ball.

mod ball;

use std::error::Error;
use volmap_formats::asset::{self, Compression};
use volmap_runtime::{Sample, VolumeMap};

/// The program.
pub fn main() -> Result<(), Box<dyn Error>> {
    let given = std::env::args().nth(1).filter(|name| name.ends_with(".h5"));
    let map = match given {
        Some(path) => VolumeMap::open(path)?,
        None => ball_from_a_file()?,
    };
    let (low, high) = (map.grid().origin, map.grid().max_corner());
    println!("r = {} m, {} bytes in memory, from {low} to {high}", map.support_radius(), map.memory_bytes());
    for part in [0.5, 0.6, 0.7, 0.8, 1.2] {
        let point = low + part * (high - low);
        match map.sample(point) {
            Sample::Near(at) => println!(
                "{point}: {:.4} m from the surface, whose closest point is {:.4}; {:.3e} m^3 of solid",
                at.distance, at.closest_point, at.volume
            ),
            Sample::Outside => println!("{point}: no surface within 2 r"),
            Sample::DeepInside => println!("{point}: more than 2 r deep in the solid"),
        }
    }
    Ok(())
}

/// Written and opened, as a bake's asset is.
fn ball_from_a_file() -> Result<VolumeMap, Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("volmap-example-{}.h5", std::process::id()));
    asset::write(&path, &ball::asset(0.1), Compression::default())?;
    let map = VolumeMap::open(&path);
    std::fs::remove_file(&path)?;
    let map = map?;

    // What comes out of it is the ball.
    let at = map.sample([0.25, 0.0, 0.0]).near().ok_or("the point is near the surface")?;
    assert!((at.distance - 0.05).abs() < 1e-4 && (at.normal.x - 1.0).abs() < 1e-3);
    assert!(map.inside([0.1, 0.1, 0.0]) && !map.inside([0.2, 0.1, 0.0]));
    Ok(map)
}
