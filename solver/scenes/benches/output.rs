//! Time of a frame's files, median of several: `cargo bench -p volmap-scenes --bench output [-- PARTICLES...]`.

use std::time::Instant;
use volmap_runtime::DVec3;
use volmap_scenes::output::Frame;
use volmap_scenes::output::particles::{self, ParticleFormat};
use volmap_scenes::output::picture::{Bounds, Painter, PictureSettings, World};

fn main() {
    let given: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let counts = if given.is_empty() { vec![61_250, 1_000_000] } else { given };
    counts.into_iter().for_each(measure);
}

/// Water that fills half of a box of 2 x 1 x 1 m, its surface oblique.
fn measure(count: usize) {
    let spacing = (1.0 / count as f64).cbrt();
    let cells = (DVec3::new(2.0, 1.0, 1.0) / spacing).as_ivec3();
    let points = (0..cells.x * cells.y * cells.z).map(|n| {
        spacing
            * (DVec3::new(
                (n % cells.x) as f64,
                (n / cells.x % cells.y) as f64,
                (n / cells.x / cells.y) as f64,
            ) + 0.5)
    });
    let positions: Vec<DVec3> = points.filter(|p| p.y < 0.25 + 0.25 * p.x).collect();
    let velocities: Vec<[f32; 3]> = positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let (ones, ids) = (vec![1.0; positions.len()], (0..positions.len() as u32).collect::<Vec<u32>>());
    let frame = Frame {
        time: 0.5,
        step: 100,
        particle_radius: 0.5 * spacing,
        particle_mass: 1000.0 * spacing.powi(3),
        rest_density: 1000.0,
        origin: None,
        positions: &positions,
        velocities: &velocities,
        density: &ones,
        pressure: &ones,
        ids: &ids,
        channels: &[],
        bodies: &[],
    };
    let bounds = Bounds { low: glam::Vec3::ZERO, high: glam::Vec3::new(2.0, 1.0, 1.0) };
    let world = World {
        origin: DVec3::ZERO,
        bounds,
        gravity: glam::Vec3::NEG_Y,
        rest_density: 1000.0,
        props: Vec::new(),
    };
    let mut painter = Painter::new(&PictureSettings::default(), world);
    println!("{} particles", positions.len());
    let mut size = 0;
    time("picture of 1280 x 720", || size = painter.draw(&frame).len());
    println!("  {size} bytes");
    let folder = std::env::temp_dir();
    for format in [ParticleFormat::Vtu, ParticleFormat::Ply, ParticleFormat::Bgeo] {
        let path = folder.join(format!("volmap-bench-{}.{}", std::process::id(), format.extension()));
        time(format.extension(), || {
            particles::write(&path, format, &frame).expect("a folder for temporary files")
        });
        println!("  {} bytes", std::fs::metadata(&path).map_or(0, |m| m.len()));
        _ = std::fs::remove_file(&path);
    }
}

fn time(name: &str, mut run: impl FnMut()) {
    let mut milliseconds: Vec<f64> = (0..7)
        .map(|_| {
            let start = Instant::now();
            run();
            1e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    milliseconds.sort_by(f64::total_cmp);
    println!("  {name}: {:.0} ms, fastest {:.0}", milliseconds[3], milliseconds[0]);
}
