//! Random scenes of up to 500 particles and 4 bodies, with every boundary method and settings across their range: what
//! no scene may do. Energy of what nothing drives doesn't grow, momentum of what touches no ground is kept, no particle
//! is lost, speeds are bounded, and every run goes to its end.
//!
//! `VOLMAP_SEED=17 cargo test --release -p volmap-fluid --test fuzzed one` tells what a scene shows.

mod methods;
#[path = "fuzz/run.rs"]
mod run;
#[path = "fuzz/scene.rs"]
mod scene;

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// In threads of their own: those of the pool bake maps, for which scenes wait.
fn check(seeds: Range<u64>) {
    let (next, faults) = (AtomicU64::new(seeds.start), Mutex::new(Vec::new()));
    let work = || {
        while let Some(seed) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|seed| *seed < seeds.end) {
            faults.lock().unwrap().extend(run::faults(seed));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn thirty_scenes_keep_what_must_be_kept() {
    check(0..30);
}

#[cfg(feature = "long")]
#[test]
fn a_thousand_scenes_keep_what_must_be_kept() {
    check(0..1000);
}

#[test]
fn one_scene_by_its_number() {
    let seed = std::env::var("VOLMAP_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(0);
    check(seed..seed + 1);
}
