//! Makes a scene in Rust, without a scene file, and simulates it without writing anything but its meshes: water falls
//! into a tank in which a cube floats.
//!
//! ```text
//! cargo run --release -p volmap-scenes --example scene_in_rust -- meshes
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};
use volmap_bake::parameters::Parameters;
use volmap_bake::watch::Watch;
use volmap_fluid::shapes::cuboid;
use volmap_fluid::simulation::Simulation;
use volmap_formats::export::ply;
use volmap_runtime::DVec3;
use volmap_scenes::assemble::assemble;
use volmap_scenes::scene::{Block, Body, FreeMotion, Motion, Scene, prepare};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from).ok_or("name a folder for the meshes")?;
    std::fs::create_dir_all(&folder)?;
    for height in heights(&scene(&folder)?, 0.5)? {
        println!("the cube is at y = {height:.3} m");
    }
    Ok(())
}

/// The scene. Its bodies are meshes in the folder, which are baked on first use.
pub fn scene(folder: &Path) -> Result<Scene, Box<dyn Error>> {
    let body = |name: &str, min: DVec3, max: DVec3| -> Result<Body, Box<dyn Error>> {
        let (path, mesh) = (folder.join(format!("{name}.ply")), cuboid(min, max));
        ply::write(&path, &mesh.vertices, &mesh.triangles, "a box")?;
        Ok(Body { name: name.into(), mesh: Some(path), ..Body::default() })
    };
    let tank = body("tank", DVec3::new(-0.4, 0.0, -0.4), DVec3::new(0.4, 0.8, 0.4))?;
    let cube = body("cube", DVec3::splat(-0.1), DVec3::splat(0.1))?;
    let free = FreeMotion { density: Some(400.0), ..FreeMotion::default() };
    Ok(Scene {
        particle_radius: 0.025,
        cache: Some(folder.join("maps")),
        blocks: vec![Block {
            min: [-0.4, 0.0, -0.4],
            max: [0.4, 0.3, 0.4],
            velocity: [0.0; 3],
            packing: Default::default(),
        }],
        bodies: vec![
            // The solid is outside of the mesh.
            Body { bake: Parameters { invert: Some(true), ..Parameters::default() }, ..tank },
            Body { motion: Motion::Free(free), translation: [0.0, 0.45, 0.0], ..cube },
        ],
        ..Scene::default()
    })
}

/// Height of the second body after every tenth of a second until a time, seconds.
pub fn heights(scene: &Scene, end: f64) -> Result<Vec<f64>, volmap_scenes::Error> {
    let mut on_bake = |mesh: &Path| println!("baking {}", mesh.display());
    let prepared = prepare(scene, &Watch::default(), &mut on_bake)?;
    let mut simulation = Simulation::new(assemble(scene, prepared)?)?;
    let mut heights = Vec::new();
    while simulation.time() < end {
        simulation.step()?;
        if simulation.time() >= 0.1 * (heights.len() + 1) as f64 {
            heights.push(simulation.bodies().state(1).pose.translation.y);
        }
    }
    Ok(heights)
}
