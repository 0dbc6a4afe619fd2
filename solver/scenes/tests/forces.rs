//! Forces in scenes: their tables, and those of a program's own in checkpoints and frames.

#[allow(dead_code)]
#[path = "../../fluid/examples/vortex_force.rs"]
mod vortex_force;

use volmap_bake::watch::Watch;
use volmap_fluid::simulation::Simulation;
use volmap_scenes::assemble::assemble;
use volmap_scenes::resume::{self, Identity};
use volmap_scenes::scene::{Scene, Syntax, parse, prepare};
use vortex_force::Vortices;

/// A block that falls, and a jet; no bodies.
const SCENE: &str = r#"
version = 1
particle_radius = 0.04

[[blocks]]
min = [0.0, 0.0, 0.0]
max = [0.5, 0.5, 0.5]
velocity = [0.5, 0.0, 0.0]

[[emitters]]
position = [0.2, 1.0, 0.2]
direction = [0.0, -1.0, 0.0]
speed = 3.0
nozzle = { circle = { radius = 0.15 } }
"#;

fn scene(more: &str) -> Result<Scene, volmap_scenes::Error> {
    parse(&format!("{SCENE}{more}"), Syntax::Toml, "scene.toml")
}

fn with_vortices(scene: &Scene) -> Simulation {
    let mut setup = assemble(scene, prepare(scene, &Watch::default(), &mut |_| ()).unwrap()).unwrap();
    setup.own_forces.push(Box::new(Vortices::new(0.05, 1e-3)));
    Simulation::new(setup).unwrap()
}

fn steps(simulation: &mut Simulation, count: u32) {
    for _ in 0..count {
        simulation.step().unwrap();
    }
}

#[test]
fn what_a_force_remembers_is_in_the_check_point() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene("").unwrap();
    let identity = Identity::new(&scene, Vec::new());
    let file = |name: &str| folder.path().join(name);
    let (mut straight, mut stopped) = (with_vortices(&scene), with_vortices(&scene));
    steps(&mut straight, 60);
    resume::save(&straight, 0, &file("straight"), &identity).unwrap();
    steps(&mut stopped, 25);
    resume::save(&stopped, 0, &file("stopped"), &identity).unwrap();

    let mut resumed = with_vortices(&scene);
    resume::load(&mut resumed, &file("stopped"), &identity).unwrap();
    assert_eq!(resumed.steps(), 25);
    steps(&mut resumed, 35);
    resume::save(&resumed, 0, &file("resumed"), &identity).unwrap();
    let bytes = |name: &str| std::fs::read(file(name)).unwrap();
    assert!(straight.particles().len() > 6 * 6 * 6, "the nozzle has added some");
    assert!(vortex_force::mean_spin(&straight) != 0.0);
    assert!(bytes("resumed") == bytes("straight"));

    // A run without the force wrote no spins.
    let mut without =
        Simulation::new(assemble(&scene, prepare(&scene, &Watch::default(), &mut |_| ()).unwrap()).unwrap())
            .unwrap();
    steps(&mut without, 1);
    resume::save(&without, 0, &file("without"), &identity).unwrap();
    let error = resume::load(&mut resumed, &file("without"), &identity).unwrap_err().to_string();
    assert!(error.contains("spin"), "{error}");
}

#[test]
fn forces_have_tables_of_their_own() {
    let damped = scene("[forces.damping]\nrate = 2.0\n").unwrap();
    assert_eq!(damped.forces.damping.as_ref().map(|damping| damping.rate), Some(2.0));
    let error = scene("[forces.damping]\nrate = -1.0\n").unwrap_err().to_string();
    assert!(error.starts_with("scene.toml:16:") && error.contains("forces.damping.rate: -1 1/s"), "{error}");
    let error = scene("[forces.dampping]\nrate = 1.0\n").unwrap_err().to_string();
    assert!(error.contains("damping"), "{error}");
    let mut simulation = Simulation::new(
        assemble(&damped, prepare(&damped, &Watch::default(), &mut |_| ()).unwrap()).unwrap(),
    )
    .unwrap();
    let before = simulation.particles().velocities[0][0];
    steps(&mut simulation, 1);
    assert!(simulation.particles().velocities[0][0] < before);
}
