//! The examples do what they say.

#[allow(dead_code)]
#[path = "../examples/run_scene.rs"]
mod run_scene;
#[allow(dead_code)]
#[path = "../examples/scene_in_rust.rs"]
mod scene_in_rust;

use volmap_scenes::session::RunSettings;

#[test]
fn run_scene_tells_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    // A block that falls freely from 0.1 m.
    let text = "version = 1\nparticle_radius = 0.05\nblocks = [{ min = [0, 0.1, 0], max = [0.3, 0.4, 0.3] }]\n\
                output = { frames_per_second = 50, preview = [] }\nstop = { time = 0.1 }\n";
    std::fs::write(&scene, text).unwrap();
    let mut frames = Vec::new();
    let out = folder.path().join("out");
    let summary = run_scene::run(&scene, &out, &RunSettings::default(), &mut |frame| {
        frames.push((frame.number, frame.statistics.time, frame.highest));
    });
    let numbers: Vec<u64> = frames.iter().map(|frame| frame.0).collect();
    assert_eq!(numbers, [1, 2, 3, 4, 5], "frame 0 is the start");
    for (_, time, highest) in frames {
        // The integrator is of first order.
        let fall = 0.5 * 9.81 * time * time;
        assert!((0.35 - fall - highest).abs() < 0.02 * time, "{time} s: {highest} m");
    }
    assert!(summary.unwrap().simulated_seconds >= 0.1 && out.join("particles/frame_000005.vtu").exists());
}

#[test]
fn a_scene_made_in_rust_floats_its_cube() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_in_rust::scene(folder.path()).unwrap();
    let heights = scene_in_rust::heights(&scene, 0.3).unwrap();
    assert_eq!(heights.len(), 3);
    // It falls from 0.45 m, by 0.15 m at most before it touches the water at 0.3 m.
    assert!(heights[0] < 0.45 && heights.iter().all(|height| (0.2..0.45).contains(height)), "{heights:?}");
}
