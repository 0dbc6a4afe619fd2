//! Runs a scene file, and looks at the fluid after every frame:
//!
//! ```text
//! cargo run --release -p volmap-scenes --example run_scene -- data/scenes/hydrostatic.toml out
//! ```
//!
//! The folder then holds what `volmap-sim run` would have written.

use std::error::Error;
use std::path::{Path, PathBuf};
use volmap_bake::watch::Watch;
use volmap_scenes::output::{RunSummary, StepStatistics};
use volmap_scenes::session::{RunSettings, Session};

fn main() -> Result<(), Box<dyn Error>> {
    let mut paths = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(scene), Some(folder)) = (paths.next(), paths.next()) else {
        return Err("name a scene and a folder".into());
    };
    let settings = RunSettings { until: Some(1.0), ..RunSettings::default() };
    let summary = run(&scene, &folder, &settings, &mut |frame| {
        println!(
            "frame {}: t = {:.3} s, {} particles, highest at {:.3} m, {} + {} iterations",
            frame.number,
            frame.statistics.time,
            frame.statistics.particles,
            frame.highest,
            frame.statistics.density_iterations,
            frame.statistics.divergence_iterations
        );
    })?;
    println!("{} steps of {:.2} ms", summary.steps, summary.step_ms.mean);
    Ok(())
}

/// What is told of a frame.
pub struct FrameTold<'a> {
    /// Its number in the folder.
    pub number: u64,
    /// The step before the frame.
    pub statistics: &'a StepStatistics,
    /// Largest y of a particle, metres.
    pub highest: f64,
}

/// Simulates step by step until the end, and calls `on_frame` after each frame.
pub fn run(
    scene: &Path,
    folder: &Path,
    settings: &RunSettings,
    on_frame: &mut dyn FnMut(&FrameTold),
) -> Result<RunSummary, volmap_scenes::Error> {
    let mut on_bake = |mesh: &Path| println!("baking {}", mesh.display());
    let mut session = Session::open(scene, folder, settings, &Watch::default(), &mut on_bake)?;
    while !session.is_done() {
        let step = session.step()?;
        if let Some(number) = step.frame {
            let positions = &session.simulation().particles().positions;
            let highest = positions.iter().map(|position| position.y).fold(f64::NEG_INFINITY, f64::max);
            on_frame(&FrameTold { number, statistics: &step.statistics, highest });
        }
    }
    session.finish()
}
