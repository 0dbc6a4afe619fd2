//! Two bodies that share a map; one of them turns and moves:
//!
//! ```text
//! cargo run --release -p volmap-runtime --example pose
//! ```

mod ball;

use std::error::Error;
use std::sync::Arc;
use volmap_runtime::{DQuat, DVec3, Pose, PosedMap, VolumeMap};

/// The program.
pub fn main() -> Result<(), Box<dyn Error>> {
    let map = Arc::new(VolumeMap::from_asset(&ball::asset(0.1))?);
    let still = PosedMap { map: map.clone(), pose: Pose::default() };
    let mut moving = PosedMap { map, pose: Pose::default() };

    // A particle at rest; the body comes nearer and turns at once.
    let particle = DVec3::new(0.9, 0.0, 0.0);
    for step in 0..=4 {
        let time = 0.1 * f64::from(step);
        moving.pose = Pose {
            rotation: DQuat::from_rotation_z(2.0 * time),
            translation: DVec3::new(1.5 * time, 0.0, 0.0),
        };
        // Points and directions of the answers are the world's.
        match moving.sample(particle).near() {
            Some(at) => {
                println!("t = {time:.1} s: {:.3} m away, towards {:.3}", at.distance, -at.normal);
                let expected = (particle - moving.pose.translation).length() - ball::RADIUS;
                assert!((at.distance - expected).abs() < 1e-3);
                assert!((at.closest_point + at.distance * at.normal - particle).length() < 1e-12);
            }
            None => println!("t = {time:.1} s: out of reach"),
        }
    }
    assert!(moving.sample(particle).near().is_some() && still.sample(particle).near().is_none());
    Ok(())
}
