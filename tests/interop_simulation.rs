//! Interop, simulations: VTK and meshio read the particles that were written, and splashsurf makes a surface of them;
//! the solver's benches compare like with like.

use std::path::Path;
use volmap_runtime::DVec3;
use volmap_scenes::output::Frame;
use volmap_scenes::output::particles::{self, ParticleFormat};
use volmap_tests::python;

use crate::interop_asset::run;

/// Particle radius; the block has 20 x 16 x 24 particles.
const RADIUS: f64 = 0.025;

/// Where maps of countries have their places, and the particles of `far`.
const FAR: DVec3 = DVec3::new(500_000.0, 0.0, 4_650_000.0);

#[test]
fn other_programs_read_the_particles() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), None);
    std::fs::create_dir(folder.path().join("far")).unwrap();
    write(&folder.path().join("far"), Some(FAR));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/check_simulation.py");
    let mut command = std::process::Command::new(python());
    print!("{}", run(command.arg(&script).arg(folder.path())));
}

#[test]
fn benches_end_where_the_peer_has_other_particles_or_settings() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/check_bench.py");
    let output = run(std::process::Command::new(python()).arg(&script));
    assert!(output.contains("particle_mass: [0.1, 0.1] instead of [0.125, 0.125]"), "{output}");
}

/// A frame in all formats, and the collection of it. The script knows the rules that the values follow.
fn write(folder: &Path, origin: Option<DVec3>) {
    let place =
        |n: u32| 2.0 * RADIUS * (DVec3::new((n % 20).into(), (n / 20 % 16).into(), (n / 320).into()) + 0.5);
    let ids: Vec<u32> = (0..20 * 16 * 24).rev().collect();
    let positions: Vec<DVec3> = ids.iter().map(|&n| origin.unwrap_or_default() + place(n)).collect();
    let velocities: Vec<[f32; 3]> = ids.iter().map(|&n| [n as f32, 0.5, -2.0 * n as f32]).collect();
    let density: Vec<f32> = ids.iter().map(|&n| 1.0 + n as f32 / 1024.0).collect();
    let pressure: Vec<f32> = ids.iter().map(|&n| 10.0 * n as f32).collect();
    let frame = Frame {
        time: 0.25,
        step: 100,
        particle_radius: RADIUS,
        particle_mass: 0.125,
        rest_density: 1000.0,
        origin,
        positions: &positions,
        velocities: &velocities,
        density: &density,
        pressure: &pressure,
        ids: &ids,
        channels: &[],
        bodies: &[],
    };
    for format in [ParticleFormat::Vtu, ParticleFormat::Ply, ParticleFormat::Bgeo] {
        let path = folder.join(format!("frame_000001.{}", format.extension()));
        particles::write(&path, format, &frame).unwrap();
    }
    let files = [particles::CollectionEntry { time: 0.25, file: "frame_000001.vtu".to_owned() }];
    particles::write_collection(&folder.join("particles.pvd"), &files).unwrap();
}
