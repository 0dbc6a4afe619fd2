//! One solid for the fluid, mass, contacts and pictures, whatever moved its surface; and maps that end before it.

use std::f64::consts::PI;
use std::path::PathBuf;
use tempfile::TempDir;
use volmap_bake::input::{InputSettings, load};
use volmap_bake::parameters::{Numbers, Parameters};
use volmap_bake::primitive::Primitive;
use volmap_fluid::bodies::Bodies;
use volmap_formats::export::ply;
use volmap_formats::mesh::TriangleMesh;
use volmap_scenes::assemble::assemble;
use volmap_scenes::plan;
use volmap_scenes::scene::{
    Block, Body, FreeMotion, Motion, Packing, Region, Rotation, Scene, SceneSummary, prepare,
};
use volmap_scenes::session::{RunSettings, Session};

const EDGE: f64 = 0.2;
const OUT: f64 = 0.025;

/// A container of 0.6 m on the ground, its walls thicker by 0.05 m, and a bit of water in it.
fn scene(folder: &TempDir, body: Body) -> Scene {
    let tank = Body {
        shape: Some(Primitive::Box { size: [0.6; 3] }),
        bake: Parameters {
            cell_size: Some(0.05),
            invert: Some(true),
            thickness: Some(0.05),
            ..Parameters::default()
        },
        translation: [0.0, 0.3, 0.0],
        ..Body::default()
    };
    Scene {
        cache: Some(folder.path().join("maps")),
        blocks: vec![Block {
            min: [0.15, 0.1, 0.15],
            max: [0.2, 0.15, 0.2],
            velocity: [0.0; 3],
            packing: Packing::default(),
        }],
        bodies: vec![tank, body],
        ..Scene::default()
    }
}

fn cube_mesh(folder: &TempDir) -> PathBuf {
    let corner = |n: u32| [n & 1, n >> 1 & 1, n >> 2 & 1].map(|bit| EDGE * (f64::from(bit) - 0.5));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[u32; 3]> =
        quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let vertices: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let path = folder.path().join("cube.ply");
    ply::write(&path, &vertices, &triangles, "a cube").unwrap();
    path
}

fn free(body: Body) -> Body {
    let motion = Motion::Free(FreeMotion { density: Some(500.0), ..FreeMotion::default() });
    Body { name: "cube".into(), motion, translation: [0.0, 0.2, 0.0], ..body }
}

fn thick_cube(folder: &TempDir, thickness: f64) -> Body {
    let bake = Parameters { thickness: Some(thickness), ..Parameters::default() };
    free(Body { mesh: Some(cube_mesh(folder)), bake, ..Body::default() })
}

/// Without the fluid: contacts alone.
fn bodies(scene: &Scene) -> Bodies {
    assemble(scene, prepare(scene, &Default::default(), &mut |_| ()).unwrap()).unwrap().bodies
}

fn checked(folder: &TempDir, scene: &Scene) -> SceneSummary {
    let path = folder.path().join("scene.json");
    std::fs::write(&path, serde_json::to_string(scene).unwrap()).unwrap();
    plan::check(&path, None, &Default::default(), &mut |_| ()).unwrap()
}

/// The file in the cache that a body was baked into.
fn baked(folder: &TempDir, stem: &str) -> PathBuf {
    let files = std::fs::read_dir(folder.path().join("maps")).unwrap().map(|file| file.unwrap().path());
    let is_it = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(stem);
    files.into_iter().find(is_it).unwrap()
}

#[test]
fn a_thickened_mesh_is_the_same_solid_as_its_map() {
    for thickness in [OUT, -OUT] {
        let folder = tempfile::tempdir().unwrap();
        let by_mesh = scene(&folder, thick_cube(&folder, thickness));
        let mut first = bodies(&by_mesh);
        let map = Some(baked(&folder, "cube"));
        let by_map = scene(&folder, free(Body { map, ..Body::default() }));
        let mut second = bodies(&by_map);
        // Steiner's formula; without rounding where the cube becomes smaller.
        let edge = EDGE + 2.0 * thickness.min(0.0);
        let t = thickness.max(0.0);
        let volume =
            edge.powi(3) + 6.0 * edge * edge * t + 3.0 * PI * edge * t * t + 4.0 / 3.0 * PI * t.powi(3);
        let mass = first.mass(1).unwrap();
        assert!((mass.mass / (500.0 * volume) - 1.0).abs() < 3e-3, "{thickness}: {} kg", mass.mass);
        assert_eq!(second.mass(1), Some(mass));
        // It falls to the bottom of the fluid's container, not to that of the mesh.
        for _ in 0..400 {
            first.step(0.002).unwrap();
            second.step(0.002).unwrap();
        }
        assert_eq!(first.state(1), second.state(1));
        let rest = 0.05 + 0.5 * EDGE + thickness;
        let off = first.state(1).centre.y - rest;
        assert!(off.abs() < 1.5e-3, "{thickness}: it rests {off} m off");
    }
}

#[test]
fn what_is_told_and_drawn_is_the_thickened_solid() {
    let folder = tempfile::tempdir().unwrap();
    let thick = scene(&folder, thick_cube(&folder, OUT));
    let told = checked(&folder, &thick).bodies[1].mass.clone().unwrap();
    let volume =
        EDGE.powi(3) + 6.0 * EDGE * EDGE * OUT + 3.0 * PI * EDGE * OUT * OUT + 4.0 / 3.0 * PI * OUT.powi(3);
    assert!((told.volume / volume - 1.0).abs() < 5e-4, "{told:?}");
    assert!((told.density - 500.0).abs() < 1e-9 && told.volume_of == "map", "{told:?}");
    let out = folder.path().join("out");
    let settings = RunSettings { steps: Some(1), ..RunSettings::default() };
    let mut session = Session::new(thick, &out, &settings, &Default::default(), &mut |_| ()).unwrap();
    session.run(&Default::default(), &mut |_| ()).unwrap();
    for (file, reach, tolerance) in
        [("bodies/01_cube.ply", 0.5 * EDGE + OUT, 1e-6), ("bodies/00_box.ply", 0.25, 3e-3)]
    {
        let mesh = load(&out.join(file), &InputSettings::default()).unwrap().mesh;
        let farthest = farthest(&mesh);
        assert!((farthest - reach).abs() < tolerance, "{file} reaches {farthest} m, not {reach}");
    }
}

/// Largest coordinate.
fn farthest(mesh: &TriangleMesh) -> f64 {
    mesh.vertices.iter().flatten().fold(0.0, |far, x| far.max(x.abs()))
}

#[test]
fn shapes_that_stay_shapes_weigh_by_closed_forms() {
    let folder = tempfile::tempdir().unwrap();
    let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
    for (shape, thickness, volume) in [
        (Primitive::Sphere { radius: 0.07 }, 0.03, ball(0.1)),
        (Primitive::Sphere { radius: 0.1 }, -0.03, ball(0.07)),
        (Primitive::Capsule { radius: 0.05, length: 0.1 }, 0.02, ball(0.07) + PI * 0.07 * 0.07 * 0.1),
        (Primitive::Box { size: [0.2, 0.2, 0.25] }, -0.025, 0.15 * 0.15 * 0.2),
    ] {
        let bake = Parameters { thickness: Some(thickness), ..Parameters::default() };
        let body = free(Body { shape: Some(shape), bake, ..Body::default() });
        let told = checked(&folder, &scene(&folder, body)).bodies[1].mass.clone().unwrap();
        assert!((told.volume / volume - 1.0).abs() < 1e-12, "{shape:?} {thickness}: {told:?}");
        assert_eq!(told.volume_of, "shape");
    }
}

fn domain(corners: [f64; 6]) -> Option<Numbers<6>> {
    Some(Numbers(corners))
}

fn notes(scene: &Scene) -> Vec<String> {
    let plan = plan::plan(scene, 1.0, &Default::default(), &mut |_| ()).unwrap();
    plan.notes.into_iter().filter(|note| note.contains("the domain of its map cuts")).collect()
}

/// A wall of the map's domain stands in the container of 0.6 m.
#[test]
fn a_map_that_cuts_the_fluids_space_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let container = |corners: Option<[f64; 6]>| {
        let bake = Parameters {
            invert: Some(true),
            cell_size: Some(0.05),
            domain: corners.and_then(domain),
            ..Parameters::default()
        };
        let shape = Some(Primitive::Box { size: [0.6; 3] });
        let tank = Body { shape, bake, translation: [0.0, 0.3, 0.0], ..Body::default() };
        Scene { bodies: vec![tank], ..scene(&folder, Body::default()) }
    };
    let whole = [-0.4, -0.4, -0.4, 0.4, 0.4, 0.4];
    assert!(notes(&container(None)).is_empty() && notes(&container(Some(whole))).is_empty());
    let cut = container(Some([-0.4, -0.4, -0.4, 0.25, 0.4, 0.4]));
    let told = notes(&cut);
    let [note] = &told[..] else { panic!("{told:?}") };
    let parts =
        ["body `box`", "cuts its hollow", "as at (0.250, 0.1", "`bake.domain`", "the scene's `domain`"];
    assert!(parts.iter().all(|part| note.contains(part)), "{note}");
    // The same by the map, whose domain is a bake's; `check` tells it as well.
    let alone = tempfile::tempdir().unwrap();
    let again = Scene { cache: Some(alone.path().join("maps")), ..cut.clone() };
    assert_eq!(notes(&again), told);
    let map = Some(baked(&alone, "box"));
    let by_map = Body { map, bake: Parameters::default(), shape: None, ..cut.bodies[0].clone() };
    let by_map = Scene { bodies: vec![by_map], ..cut.clone() };
    let check = checked(&folder, &by_map).notes;
    assert!(check.iter().any(|note| note.contains("its hollow") && note.contains("`--domain`")), "{check:?}");
    // Nothing is told where no fluid can be: out of the domain, or in another body.
    let ends_before = Region { min: [-0.3, 0.0, -0.3], max: [0.24, 0.6, 0.3] };
    assert!(notes(&Scene { domain: Some(ends_before), ..cut.clone() }).is_empty());
    let filled = Body {
        shape: Some(Primitive::Box { size: [0.2, 0.8, 0.8] }),
        translation: [0.33, 0.3, 0.0],
        ..Body::default()
    };
    let mut with_block = cut.clone();
    with_block.bodies.push(filled);
    assert!(notes(&with_block).is_empty());
}

/// A block whose map ends within it is open there; turned, the place turns with it.
#[test]
fn a_map_that_cuts_a_solid_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let block = |corners| {
        let bake = Parameters { domain: domain(corners), ..Parameters::default() };
        let rotation = Rotation::about([0.0, 0.0, 1.0], 90.0);
        let shape = Some(Primitive::Box { size: [0.2; 3] });
        Body { shape, bake, rotation, translation: [0.0, 1.0, 0.0], ..Body::default() }
    };
    let of = |corners| notes(&Scene { bodies: vec![block(corners)], ..scene(&folder, Body::default()) });
    assert!(of([-0.2, -0.2, -0.2, 0.2, 0.2, 0.2]).is_empty());
    let told = of([-0.2, -0.2, -0.2, 0.05, 0.2, 0.2]);
    let [note] = &told[..] else { panic!("{told:?}") };
    assert!(note.contains("cuts its solid") && note.contains(", 1.050, "), "{note}");
}

/// A plane's map ends where the scene does.
#[test]
fn planes_are_not_cut() {
    let folder = tempfile::tempdir().unwrap();
    let plane = Primitive::Plane { normal: [0.0, 1.0, 0.0], within: None };
    for rotation in [Rotation::default(), Rotation::about([0.0, 0.0, 1.0], 20.0)] {
        let ground = Body { shape: Some(plane), rotation, ..Body::default() };
        let domain = Some(Region { min: [-1.0, -0.2, -1.0], max: [1.0, 1.0, 1.0] });
        let scene = Scene { bodies: vec![ground], domain, ..scene(&folder, Body::default()) };
        assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
    }
}
