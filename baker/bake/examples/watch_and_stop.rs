//! Bakes in a thread of its own, shows how far it is, and stops it.
//!
//! `cargo run --release -p volmap-bake --example watch_and_stop`

use glam::DVec3;
use std::error::Error;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;
use volmap_bake::Error as BakeError;
use volmap_bake::bake::bake_distance;
use volmap_bake::plan::Extent;
use volmap_bake::settings::{GridChoice, MapSettings};
use volmap_bake::watch::{Step, Watch};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // Each step is sent to this thread as it begins. What is done of it can be read from here at any time.
    let (steps, received) = mpsc::channel::<Step>();
    let watch = Watch::new(move |step| _ = steps.send(step.clone()));
    let cancel = watch.cancel().clone();

    let bake = thread::spawn(move || {
        let sphere = |x: DVec3| x.length() - 1.0;
        let extent = Extent { min: DVec3::splat(-1.0), max: DVec3::splat(1.0), area: 12.6 };
        let grid = GridChoice::CellSize(0.02);
        let settings = MapSettings { support_radius: Some(0.04), grid, ..MapSettings::default() };
        bake_distance(&sphere, &extent, &settings, &watch)
    });

    while let Ok(step) = received.recv_timeout(Duration::from_secs(60)) {
        let Some(work) = step.work else { continue };
        println!("{}: {} of {}", step.name, work.done(), work.total());
        // Enough was seen when the integration begins.
        if step.name == "integrating the volume" {
            cancel.cancel();
            break;
        }
    }
    match bake.join().expect("the bake doesn't panic") {
        Err(BakeError::Cancelled(_)) => println!("stopped, with nothing left behind"),
        Err(error) => return Err(error.into()),
        Ok(asset) => println!("it was faster: {} nodes", asset.volume.len()),
    }
    Ok(())
}
