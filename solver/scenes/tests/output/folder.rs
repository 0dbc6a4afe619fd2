//! The folder of a run.

use super::pictures::keep;
use super::scene::{NAME, Scene, duck, world};
use std::path::Path;
use volmap_formats::mesh::{MeshFormat, read_mesh_bytes};
use volmap_scenes::output::bodies::BodyMesh;
use volmap_scenes::output::folder::Start;
use volmap_scenes::output::particles::ParticleFormat;
use volmap_scenes::output::picture::PictureSettings;
use volmap_scenes::output::{FolderSettings, Output, StepStatistics};

fn settings() -> FolderSettings {
    FolderSettings {
        particles: vec![ParticleFormat::Vtu, ParticleFormat::Ply, ParticleFormat::Bgeo],
        picture: PictureSettings { width: 160, height: 90, ..PictureSettings::default() },
        ..FolderSettings::default()
    }
}

fn open(folder: &Path, start: Option<Start>) -> Output {
    Output::open(folder, &settings(), world(), &[BodyMesh { name: NAME.into(), mesh: duck().into() }], start)
        .unwrap()
}

/// Frames at steps 0, 4, 8 and so on.
fn simulate(output: &mut Output, from: u64, to: u64) {
    for step in from..=to {
        if step > 0 {
            let time = 0.04 * step as f64;
            output.step(&StepStatistics { step, time, particles: 10, ..StepStatistics::default() }).unwrap();
        }
        if step % 4 == 0 {
            let scene = Scene::new(0.08, 0.1 * step as f64);
            output.frame(&scene.frame(step)).unwrap();
        }
    }
}

fn content(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(content(&path)),
            false => {
                all.push((path.file_name().unwrap().display().to_string(), std::fs::read(&path).unwrap()))
            }
        }
    }
    all.sort();
    all
}

#[test]
fn a_run_that_goes_on_leaves_the_same_files() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut output = open(whole.path(), None);
    simulate(&mut output, 0, 12);
    let summary = output.finish(Vec::new()).unwrap();
    assert_eq!((summary.steps, summary.particles, output.frames()), (12, 10, 4));
    // Killed after step 9 and frame 8; the checkpoint is that of step 6.
    let mut output = open(parts.path(), None);
    simulate(&mut output, 0, 9);
    drop(output);
    let mut output = open(parts.path(), Some(Start { step: 6, frames: 2 }));
    assert_eq!(output.frames(), 2);
    simulate(&mut output, 7, 12);
    output.finish(Vec::new()).unwrap();
    keep("animation.png", &std::fs::read(whole.path().join("animation.png")).unwrap());
    let (whole, parts) = (content(whole.path()), content(parts.path()));
    let names: Vec<&str> = whole.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names.len(), 1 + 4 * 4 + 3 + 4, "{names:?}");
    assert!(whole == parts);
}

#[test]
fn poses_move_the_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let mut output = open(folder.path(), None);
    simulate(&mut output, 0, 4);
    output.finish(Vec::new()).unwrap();
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("poses.json")).unwrap()).unwrap();
    let file = json["bodies"][0]["mesh"].as_str().unwrap();
    let mesh = read_mesh_bytes(&std::fs::read(folder.path().join(file)).unwrap(), MeshFormat::Ply).unwrap();
    assert_eq!(mesh.positions, duck().vertices);
    let pose = &json["frames"][1]["bodies"][0];
    let expected = Scene::new(0.2, 0.4).bodies[0].pose;
    let numbers = |key: &str| -> Vec<f64> { serde_json::from_value(pose[key].clone()).unwrap() };
    assert_eq!(pose["name"], NAME);
    assert_eq!(numbers("position"), expected.translation.to_array());
    for (read, given) in numbers("rotation").iter().zip(expected.rotation.to_array()) {
        assert!((read - given).abs() < 1e-15);
    }
}

#[test]
fn what_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let in_the_way = folder.path().join("file");
    std::fs::write(&in_the_way, "").unwrap();
    let open = |folder: &Path| Output::open(folder, &settings(), world(), &[], None);
    let error = open(&in_the_way).err().unwrap().to_string();
    assert!(error.contains("file"), "{error}");
    // A folder that vanishes during the run.
    let run = folder.path().join("run");
    let mut output = open(&run).unwrap();
    std::fs::remove_dir_all(run.join("particles")).unwrap();
    let error = output.frame(&Scene::new(0.2, 0.0).frame(0)).unwrap_err().to_string();
    assert!(error.contains("frame_000000.vtu") && error.contains("no folder"), "{error}");
    // Lists of different lengths.
    let mut output = open(&run).unwrap();
    let scene = Scene::new(0.2, 0.0);
    let mut frame = scene.frame(0);
    frame.density = &[];
    let error = output.frame(&frame).unwrap_err().to_string();
    assert!(error.contains("0 values of density"), "{error}");
}

/// Relative densities are times the fluid's own: single precision, little-endian in PLY, big-endian in BGEO.
#[test]
fn densities_are_in_kilograms_per_cubic_metre() {
    let folder = tempfile::tempdir().unwrap();
    let mut output = Output::open(folder.path(), &settings(), world(), &[], None).unwrap();
    let mut scene = Scene::new(0.2, 0.0);
    scene.density.fill(1.25);
    let mut frame = scene.frame(0);
    frame.rest_density = 13_600.0;
    output.frame(&frame).unwrap();
    let count = |extension: &str, bytes: [u8; 4]| {
        let file = folder.path().join("particles/frame_000000").with_extension(extension);
        std::fs::read(file).unwrap().windows(4).filter(|window| *window == bytes).count()
    };
    let [density, relative] = [17_000.0_f32, 1.25];
    assert_eq!(count("ply", density.to_le_bytes()), scene.positions.len());
    assert_eq!(count("bgeo", density.to_be_bytes()), scene.positions.len());
    assert_eq!([count("ply", relative.to_le_bytes()), count("bgeo", relative.to_be_bytes())], [0; 2]);
}

/// A device that is always full.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut output = open(folder.path(), None);
    let stats = folder.path().join("stats.csv");
    std::fs::remove_file(&stats).unwrap();
    std::os::unix::fs::symlink("/dev/full", &stats).unwrap();
    simulate(&mut output, 1, 3);
    let error = Output::open(folder.path(), &settings(), world(), &[], None).err().unwrap().to_string();
    assert!(error.contains("stats.csv") && error.to_lowercase().contains("space"), "{error}");
}
