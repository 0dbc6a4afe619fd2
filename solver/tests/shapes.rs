//! Bodies of simple shape in scenes, scenes to start from, and limits of memory.

use assert_cmd::Command;
use std::path::Path;
use volmap_bake::primitive::PlacedPrimitive;
use volmap_bake::watch::Watch;
use volmap_fluid::bodies::Mass;
use volmap_formats::export::ply;
use volmap_formats::mesh::Placement;
use volmap_scenes::session::{RunSettings, Session};

const SCENE: &str = r#"
version = 1
particle_radius = 0.03
cache = "maps"

[[blocks]]
min = [-0.3, 0.0, -0.3]
max = [0.3, 0.36, 0.3]

[[bodies]]
name = "tank"
shape = { box = { size = [0.6, 0.9, 0.6] } }
bake = { invert = true }
translation = [0.0, 0.45, 0.0]

[[bodies]]
name = "ball"
BODY
translation = [0.02, 0.5, 0.01]
motion = { free = { density = 500.0 } }

[output]
frames_per_second = 10
preview = []
"#;

fn sim(folder: &Path, line: &str) -> Command {
    let mut command = Command::cargo_bin("volmap-sim").unwrap();
    command.current_dir(folder).env("XDG_CACHE_HOME", folder).args(line.split_whitespace());
    command
}

fn refusal(command: &mut Command, code: i32) -> String {
    String::from_utf8(command.assert().code(code).get_output().stderr.clone()).unwrap()
}

/// Where the ball is after half a second.
fn height(folder: &Path, body: &str, name: &str) -> f64 {
    let scene = folder.join(format!("{name}.toml"));
    std::fs::write(&scene, SCENE.replace("BODY", body)).unwrap();
    let settings = RunSettings { until: Some(0.5), ..RunSettings::default() };
    let watch = Watch::default();
    let mut session = Session::open(&scene, &folder.join(name), &settings, &watch, &mut |_| ()).unwrap();
    session.run(&watch, &mut |_| ()).unwrap();
    session.simulation().bodies().state(1).pose.translation.y
}

#[test]
fn a_sphere_floats_as_its_mesh_does() {
    let folder = tempfile::tempdir().unwrap();
    let ball = PlacedPrimitive::new("sphere:0.12".parse().unwrap(), &Placement::default()).unwrap();
    let mesh = ball.mesh().unwrap();
    ply::write(&folder.path().join("ball.ply"), &mesh.vertices, &mesh.triangles, "a ball").unwrap();
    let shape = height(folder.path(), "shape = { sphere = { radius = 0.12 } }", "shape");
    let mesh_height = height(folder.path(), "mesh = \"ball.ply\"", "mesh");
    assert!((shape - mesh_height).abs() < 0.01, "{shape} {mesh_height}");
    assert!(shape < 0.45 && shape > 0.2, "it fell, and is held: {shape}");
    let [exact, of_mesh] = [Mass::of_shape(&ball, 500.0).unwrap(), Mass::of_mesh(&mesh, 500.0).unwrap()];
    assert!((exact.mass / (500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.12f64.powi(3)) - 1.0).abs() < 1e-14);
    assert!((exact.mass / of_mesh.mass - 1.0).abs() < 2e-3);
    assert!((exact.inertia.x_axis.x / of_mesh.inertia.x_axis.x - 1.0).abs() < 3e-3);
}

#[test]
fn scenes_to_start_from_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for template in ["tank", "jet"] {
        let file = format!("{template}.toml");
        sim(at, &format!("new {file} --template {template}")).assert().success();
        let check = sim(at, &format!("check {file}")).assert().success();
        let told = String::from_utf8(check.get_output().stdout.clone()).unwrap();
        assert!(!told.contains("note"), "{told}");
        sim(at, &format!("run {file} -o {template} --steps 3 -q")).assert().success();
    }
    sim(at, "new").assert().success();
    let before = std::fs::read(at.join("scene.toml")).unwrap();
    let error = refusal(&mut sim(at, "new"), 1);
    assert!(error.contains("scene.toml: is there already and stays"), "{error}");
    assert_eq!(std::fs::read(at.join("scene.toml")).unwrap(), before);
    assert!(refusal(&mut sim(at, "new scene.json"), 1).contains("ends in .toml"));
}

#[test]
fn shapes_that_cannot_be_used_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (body, said) in [
        ("shape = { sphere = { radius = 0.0 } }", "a sphere with a radius of 0 m"),
        ("shape = { ball = { radius = 1.0 } }", "unknown value `ball`; known here: box"),
        ("shape = \"sphere:0.1\"\nmesh = \"a.obj\"", "give `map`, `mesh` or `shape`, one of them"),
        ("bake = { shape = \"sphere:0.1\" }\nmesh = \"a.obj\"", "give `shape` beside `bake`"),
        ("shape = { plane = { normal = [0.0, 1.0, 0.0] } }", "a plane has no end and no mass"),
        ("", "or `shape`, as { sphere = { radius = 0.5 } }"),
        ("shape = \"sphere:0.1\"\nbake = { scale = [1.0, 2.0, 1.0] }", "scaled alike along all axes"),
    ] {
        std::fs::write(at.join("s.toml"), SCENE.replace("BODY", body)).unwrap();
        let error = refusal(&mut sim(at, "check s.toml"), 1);
        assert!(error.contains(said), "{body}: {error}");
    }
    let plane = "shape = { plane = { normal = [0.0, 1.0, 0.0] } }";
    let scene = SCENE.replace("BODY", plane).replace("motion = { free = { density = 500.0 } }", "");
    std::fs::write(at.join("s.toml"), scene).unwrap();
    let error = refusal(&mut sim(at, "check s.toml"), 1);
    assert!(error.contains("bodies[1].shape: a plane has no end"), "{error}");
}

#[test]
fn runs_that_need_more_memory_than_they_may_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    sim(at, "new a.toml").assert().success();
    let error = refusal(&mut sim(at, "run a.toml -o out --max-memory 30MB"), 1);
    assert_eq!(refusal(&mut sim(at, "check a.toml --max-memory 30MB"), 1), error);
    let said =
        ["the run would need about", "more than --max-memory, 30.0 MB", "particles", "particle_radius"];
    assert!(said.iter().all(|part| error.contains(part)), "{error}");
    // The particles would fit, the bake of the tank would not.
    let fine = std::fs::read_to_string(at.join("a.toml")).unwrap();
    let fine = fine.replace("invert = true", "invert = true, cell_size = 0.004");
    std::fs::write(at.join("fine.toml"), fine).unwrap();
    let error = refusal(&mut sim(at, "run fine.toml -o out --max-memory 60MB"), 1);
    assert!(error.contains("can't be baked: it would need about"), "{error}");
    let checked = refusal(&mut sim(at, "check fine.toml --max-memory 60MB"), 1);
    assert!(checked.contains("can't be baked: it would need about"), "{checked}");
    // An emitter's particles count as those of the start.
    sim(at, "new jet.toml --template jet").assert().success();
    let error = refusal(&mut sim(at, "run jet.toml -o out --max-memory 32MB"), 1);
    assert!(error.contains("from emitters until 1.5 s"), "{error}");
    assert!(!at.join("out").exists());
    sim(at, "run a.toml -o out --max-memory 1GiB --steps 1 -q").assert().success();
    sim(at, "check a.toml --max-memory 1GiB").assert().success();
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_runs_out_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let block = "[[blocks]]\nmin = [-2.0, 0.0, -2.0]\nmax = [2.0, 4.0, 2.0]\n";
    let text = format!("version = 1\nparticle_radius = 0.012\n{block}[output]\npreview = []\n");
    std::fs::write(at.join("s.toml"), text).unwrap();
    let limited = |limit: u32, threads: u32| {
        let mut command = Command::new("sh");
        let line = format!("ulimit -v {limit}; exec \"$0\" run s.toml -o out --threads {threads}");
        command.current_dir(at).args(["-c", &line]).arg(assert_cmd::cargo::cargo_bin("volmap-sim"));
        refusal(&mut command, 3)
    };
    let error = limited(300_000, 1);
    assert!(error.contains("no memory left") && error.contains("particle_radius"), "{error}");
    let error = limited(200_000, 300);
    assert!(error.contains("the system refuses 300 threads"), "{error}");
}
