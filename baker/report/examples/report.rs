//! Bakes a sphere that is made here, measures the map against the mesh, and prints the verdict.
//!
//! ```sh
//! cargo run --release -p volmap-report --example report
//! ```

use std::fmt::Write;
use std::path::Path;
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{Input, InputSettings, from_bytes};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::watch::Watch;
use volmap_report::report::{ReportSettings, report};

/// Largest error that passes, as a part of the full ball.
const MAX_ERROR: f64 = 0.02;

/// A sphere of radius 0.5 m, of `2 n` x `n` quads.
pub fn sphere(n: u32) -> Result<Input, volmap_bake::Error> {
    let mut obj = String::new();
    for ring in 0..=n {
        let (y, radius) = {
            let angle = std::f64::consts::PI * f64::from(ring) / f64::from(n);
            (0.5 * angle.cos(), 0.5 * angle.sin())
        };
        for side in 0..2 * n {
            let angle = std::f64::consts::PI * f64::from(side) / f64::from(n);
            _ = writeln!(obj, "v {} {y} {}", radius * angle.cos(), radius * angle.sin());
        }
    }
    for ring in 0..n {
        for side in 0..2 * n {
            // OBJ counts vertices from 1.
            let corner = |ring: u32, side: u32| 1 + ring * 2 * n + side % (2 * n);
            let [a, b, c, d] = [
                corner(ring, side),
                corner(ring, side + 1),
                corner(ring + 1, side + 1),
                corner(ring + 1, side),
            ];
            _ = writeln!(obj, "f {a} {b} {c} {d}");
        }
    }
    // The vertices of a pole are one.
    let settings = InputSettings { weld_tolerance: 1e-9, ..InputSettings::default() };
    from_bytes(Path::new("sphere.obj"), obj.as_bytes(), &settings)
}

/// Bakes and measures; returns the verdict, and whether the map passed.
pub fn measure() -> Result<(String, bool), volmap_report::Error> {
    let mesh = sphere(32)?;
    let map =
        MapSettings { support_radius: Some(0.1), grid: GridChoice::CellSize(0.1), ..MapSettings::default() };
    let asset =
        bake(mesh.clone(), &BakeSettings { map, ..BakeSettings::default() }, &Watch::default())?.asset;
    let settings = ReportSettings {
        points: 400,
        mesh_points: 100,
        pixels: 0,
        max_error: Some(MAX_ERROR),
        ..ReportSettings::default()
    };
    let verdict = report(&asset, Some(mesh), &settings, &Watch::default())?.findings.verdict;
    Ok((verdict.text, verdict.passed == Some(true)))
}

fn main() -> Result<(), volmap_report::Error> {
    let (text, passed) = measure()?;
    println!("{}: {text}", if passed { "good" } else { "not good enough" });
    Ok(())
}
