//! From a scene to particles and maps: counts that are known, overlaps, the cache.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;
use volmap_bake::parameters::{DensityKernel, Numbers, Parameters, PrecisionName, Scale};
use volmap_bake::watch::Watch;
use volmap_fluid::settings::BoundaryMethod;
use volmap_runtime::{ClosureKind, DVec3, KernelKind};
use volmap_scenes::scene::map::Origin;
use volmap_scenes::scene::{
    Block, Body, EmitterSettings, Fill, Keyframe, Motion, Nozzle, Prepared, Region, Rotation, Scene, Spin,
    load, memory::Limit, prepare, prepare_within,
};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

/// A tank of one metre, its floor's middle at the origin; its cells are coarse, so that it bakes fast.
fn tank(invert: bool) -> Parameters {
    let invert = Some(invert);
    Parameters { invert, scale: Some(Scale([1.0 / 3.1; 3])), cell_size: Some(0.05), ..Parameters::default() }
}

fn body(bake: Parameters) -> Body {
    Body { mesh: Some(data("tank.obj")), bake, ..Body::default() }
}

fn scene(cache: &TempDir) -> Scene {
    // Of maps that are quickly baked.
    let closure = Some(ClosureKind::Calibrated);
    Scene { cache: Some(cache.path().join("maps")), closure, ..Scene::default() }
}

fn run(scene: &Scene) -> Result<Prepared, String> {
    prepare(scene, &Default::default(), &mut |_| ()).map_err(|error| error.to_string())
}

fn cube(min: [f64; 3], edge: f64) -> Block {
    Block { min, max: min.map(|x| x + edge), velocity: [1.0, 2.0, 3.0], packing: Default::default() }
}

fn nearest_pair(points: &[DVec3]) -> f64 {
    let pairs = points.iter().enumerate().flat_map(|(i, a)| points[..i].iter().map(move |b| a.distance(*b)));
    pairs.fold(f64::INFINITY, f64::min)
}

/// What turns by itself would stir the fluid by the roughness of equal cells.
#[test]
fn bodies_that_turn_have_cells_as_exact_as_the_closure_needs() {
    let cache = tempfile::tempdir().unwrap();
    let levels = |motion: Motion, cell_size: Option<f64>| {
        let body =
            Body { motion, ..body(Parameters { invert: Some(true), cell_size, ..Parameters::default() }) };
        let blocks = vec![cube([0.0, 1.0, 0.0], 1.2)];
        let closure = Some(ClosureKind::Mirror);
        // So large that equal cells would be few.
        let scene = Scene { closure, particle_radius: 0.3, bodies: vec![body], blocks, ..scene(&cache) };
        run(&scene).unwrap().bodies[0].map.levels()
    };
    let spin = |rpm| Motion::Spin(Spin { axis: [0.0, 1.0, 0.0], rpm, centre: None });
    let frame = |time, degrees| Keyframe {
        time,
        translation: [time, 0.0, 0.0],
        rotation: Rotation { axis: Some([0.0, 1.0, 0.0]), degrees: Some(degrees), quaternion: None },
    };
    let keys = |degrees| Motion::Keyframes(vec![frame(0.0, 0.0), frame(1.0, degrees)]);
    for (motion, turns) in [(spin(5.0), true), (spin(0.0), false), (keys(10.0), true), (keys(0.0), false)] {
        assert_eq!(levels(motion.clone(), None) > 1, turns, "{motion:?}");
    }
    assert_eq!(levels(spin(5.0), Some(0.1)), 1, "what the scene says holds");
}

/// The search for cells takes memory in proportion to how exact they are.
#[test]
fn volumes_are_less_exact_where_memory_is_short_and_that_is_told() {
    let cache = tempfile::tempdir().unwrap();
    let body = body(Parameters { invert: Some(true), ..Parameters::default() });
    let blocks = vec![cube([0.0, 1.0, 0.0], 1.0)];
    let closure = Some(ClosureKind::Mirror);
    let scene = Scene { closure, particle_radius: 0.08, bodies: vec![body], blocks, ..scene(&cache) };
    let within = |bytes| {
        let prepared = prepare_within(&scene, Limit { bytes, end: 0.1 }, &Watch::default(), &mut |_| ());
        let prepared = prepared.map_err(|error| error.to_string()).unwrap();
        let told = prepared.notes.into_iter().find(|note| note.contains("volumes may be wrong by"));
        (prepared.bodies[0].map.memory_bytes(), told)
    };
    let (exact, nothing) = within(200_000_000);
    let (rough, told) = within(40_000_000);
    assert_eq!(nothing, None);
    assert!(told.is_some_and(|note| note.contains("4 % of the full ball instead of 1 %")), "after 2 %");
    assert!(rough <= exact, "{rough} {exact}");
}

#[test]
fn the_dam_break_holds_the_particles_of_the_program_it_is_compared_with() {
    let cache = tempfile::tempdir().unwrap();
    let mut loaded = load(&data("scenes/double_dam_break.toml")).unwrap();
    // Coarser than the scene's, which take seconds to bake.
    loaded.bodies[0].bake.cell_size = Some(0.1);
    let prepared = run(&Scene { cache: scene(&cache).cache, ..loaded }).unwrap();
    let points = &prepared.particles.positions;
    assert_eq!(points.len(), 61_250);
    // 25 x 49 x 25 from -1.45, 0.05, -1.45 in steps of 0.05; the second block's first is at 0.25, 0.05, 0.25.
    assert!(points[0].distance(DVec3::new(-1.45, 0.05, -1.45)) < 1e-9);
    assert!(points[30_624].distance(DVec3::new(-0.25, 2.45, -0.25)) < 1e-9);
    assert!(points[30_625].distance(DVec3::new(0.25, 0.05, 0.25)) < 1e-9);
    assert!(prepared.notes.iter().all(|note| note.contains("coarse")), "{:?}", prepared.notes);
}

#[test]
fn water_fills_a_tank_to_its_corners() {
    let cache = tempfile::tempdir().unwrap();
    let blocks = vec![cube([-0.5, 0.0, -0.5], 1.0)];
    let prepared = run(&Scene { bodies: vec![body(tank(true))], blocks, ..scene(&cache) }).unwrap();
    assert_eq!(prepared.particles.positions.len(), 8000);
    assert!(prepared.particles.velocities.iter().all(|&v| v == DVec3::new(1.0, 2.0, 3.0)));
}

#[test]
fn solids_and_containers_are_filled_to_their_walls() {
    let cache = tempfile::tempdir().unwrap();
    for invert in [false, true] {
        let fill = Fill {
            mesh: Some(data("tank.obj")),
            bake: tank(invert),
            translation: [5.0, 0.0, 0.0],
            ..Fill::default()
        };
        let prepared = run(&Scene { fills: vec![fill.clone()], ..scene(&cache) }).unwrap();
        let points = &prepared.particles.positions;
        assert_eq!(points.len(), 8000);
        let lowest = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        assert!(lowest.distance(DVec3::new(4.525, 0.025, -0.475)) < 1e-9, "{lowest}");
        // An odd number of particles fits as well, and only a part may be filled.
        let bake = Parameters { scale: Some(Scale([0.95 / 3.1; 3])), ..tank(invert) };
        let within = Some(Region { min: [4.0, 0.0, -1.0], max: [6.0, 0.475, 1.0] });
        let part = Fill { bake, within, ..fill };
        let prepared = run(&Scene { fills: vec![part], ..scene(&cache) }).unwrap();
        // 10 layers: the highest lies at 0.475.
        assert_eq!(prepared.particles.positions.len(), 19 * 19 * 10);
    }
}

#[test]
fn a_turned_solid_is_filled_with_about_its_volume_and_nothing_outside() {
    let cache = tempfile::tempdir().unwrap();
    let rotation = Rotation::about([1.0, 2.0, 3.0], 40.0);
    let fill = Fill { mesh: Some(data("tank.obj")), bake: tank(false), rotation, ..Fill::default() };
    let prepared = run(&Scene { fills: vec![fill.clone()], ..scene(&cache) }).unwrap();
    let points = prepared.particles.positions;
    // The centres fill a cube that is one spacing smaller.
    let expected = 0.95_f64.powi(3) / 0.05_f64.powi(3);
    assert!((points.len() as f64 / expected - 1.0).abs() < 0.02, "{} {expected}", points.len());
    for point in points {
        let local = fill.pose().to_map(point) - DVec3::Y * 0.5;
        assert!(local.abs().max_element() <= 0.475 + 1e-6, "{local}");
    }
}

#[test]
fn what_lies_in_a_body_is_left_out_and_counted() {
    let cache = tempfile::tempdir().unwrap();
    // The tank as a solid: it takes the middle of a block that is 2 m wide.
    let blocks = vec![cube([-1.0, -0.5, -1.0], 2.0)];
    let prepared = run(&Scene { bodies: vec![body(tank(false))], blocks, ..scene(&cache) }).unwrap();
    let counts = &prepared.particles.counts[0];
    assert_eq!((counts.particles, counts.in_bodies), (64_000 - 8000, 8000));
    assert!(prepared.notes[0].contains("8,000 in a body"), "{:?}", prepared.notes);
}

#[test]
fn overlapping_sources_give_each_place_one_particle() {
    let cache = tempfile::tempdir().unwrap();
    // The second is half a spacing off: nearer than the spacing, not nearer than rp.
    for (shift, duplicates) in [(0.0, 1000), (0.01, 1000), (0.025 * 3.0_f64.sqrt().recip() * 1.01, 0)] {
        let blocks = vec![cube([0.0; 3], 0.5), cube([shift; 3], 0.5)];
        let prepared = run(&Scene { blocks, ..scene(&cache) }).unwrap();
        assert_eq!(prepared.particles.counts[1].duplicates, duplicates, "{shift}");
        assert_eq!(prepared.particles.positions.len() as u64, 2000 - duplicates);
        assert!(nearest_pair(&prepared.particles.positions) > 0.025 * (1.0 - 1e-6));
    }
}

#[test]
fn what_lies_out_of_the_domain_is_left_out_and_counted() {
    let cache = tempfile::tempdir().unwrap();
    let domain = Some(Region { min: [0.0; 3], max: [0.25, 1.0, 1.0] });
    let prepared = run(&Scene { blocks: vec![cube([0.0; 3], 0.5)], domain, ..scene(&cache) }).unwrap();
    assert_eq!((prepared.particles.counts[0].outside, prepared.particles.positions.len()), (500, 500));
}

#[test]
fn no_fluid_is_an_error_with_its_cause() {
    let cache = tempfile::tempdir().unwrap();
    assert!(run(&scene(&cache)).unwrap_err().contains("there is no fluid"));
    let blocks = vec![cube([-0.25, 0.25, -0.25], 0.5)];
    let error = run(&Scene { bodies: vec![body(tank(false))], blocks, ..scene(&cache) }).unwrap_err();
    assert!(
        error.contains("all 1,000 particles lie in a body,") && error.contains("invert = true"),
        "{error}"
    );
    let bake = Parameters { scale: Some(Scale([0.01; 3])), ..tank(false) };
    let fills = vec![Fill { mesh: Some(data("tank.obj")), bake, ..Fill::default() }];
    assert!(run(&Scene { fills, ..scene(&cache) }).unwrap_err().contains("no particle fits"));
}

#[test]
fn nozzles_in_each_other_are_told() {
    let cache = tempfile::tempdir().unwrap();
    let nozzle = |x: f64, start: f64| EmitterSettings {
        position: [x, 0.0, 0.0],
        nozzle: Nozzle::Box { width: 0.2, height: 0.2 },
        start,
        stop: Some(start + 0.3),
        ..EmitterSettings::default()
    };
    let notes = |emitters: Vec<EmitterSettings>| run(&Scene { emitters, ..scene(&cache) }).unwrap().notes;
    let told = notes(vec![nozzle(0.0, 0.0), nozzle(1.0, 0.0), nozzle(0.0, 0.1)]);
    assert!(
        told.iter().any(|n| n.contains("emitters[2]: its nozzle lies in that of emitters[0]")),
        "{told:?}"
    );
    assert_eq!(told.len(), 1, "{told:?}");
    // Beside each other, or one after the other.
    assert_eq!(notes(vec![nozzle(0.0, 0.0), nozzle(0.2, 0.0), nozzle(0.0, 0.3)]), Vec::<String>::new());
}

/// The watch is cancelled when the bake begins, as by Ctrl-C.
#[test]
fn a_bake_that_is_cancelled_leaves_nothing() {
    let cache = tempfile::tempdir().unwrap();
    let scene =
        Scene { bodies: vec![body(tank(true))], blocks: vec![cube([0.0, 0.2, 0.0], 0.3)], ..scene(&cache) };
    let watch = Watch::default();
    let error = prepare(&scene, &watch, &mut |_| watch.cancel().cancel()).unwrap_err();
    assert!(error.is_cancelled(), "{error}");
    assert!(!cache.path().join("maps").exists());
}

#[test]
fn maps_are_baked_once_and_shared() {
    let cache = tempfile::tempdir().unwrap();
    let blocks = vec![cube([3.0; 3], 0.5)];
    // The third, a container, is around the fluid.
    let around = Body { translation: [3.25, 3.0, 3.25], ..body(tank(true)) };
    let bodies = vec![body(tank(false)), body(tank(false)), around];
    let scene = Scene { bodies, blocks, ..scene(&cache) };
    let mut baked = 0;
    let first = prepare(&scene, &Default::default(), &mut |_| baked += 1).unwrap();
    assert!(Arc::ptr_eq(&first.bodies[0].map, &first.bodies[1].map));
    assert!(!Arc::ptr_eq(&first.bodies[0].map, &first.bodies[2].map));
    assert_eq!(
        first.bodies.iter().map(|body| body.name.as_str()).collect::<Vec<_>>(),
        ["tank", "tank 2", "tank 3"]
    );
    let again = prepare(&scene, &Default::default(), &mut |_| baked += 1).unwrap();
    assert_eq!((baked, again.bodies[0].origin, again.bodies[2].origin), (2, Origin::Cache, Origin::Cache));
    let at = DVec3::new(0.1, 0.97, 0.2);
    assert_eq!(first.bodies[0].map.sample(at), again.bodies[0].map.sample(at));
    assert!(again.bodies[0].surface.mesh.as_ref().is_some_and(|mesh| mesh.triangles.len() == 12));
    // What is damaged is baked again; other parameters are other maps.
    for file in std::fs::read_dir(cache.path().join("maps")).unwrap() {
        std::fs::write(file.unwrap().path(), b"damage").unwrap();
    }
    let repaired = prepare(&scene, &Default::default(), &mut |_| baked += 1).unwrap();
    assert_eq!((baked, repaired.bodies[0].origin), (4, Origin::Baked));
    prepare(&Scene { particle_radius: 0.03, ..scene.clone() }, &Default::default(), &mut |_| baked += 1)
        .unwrap();
    assert_eq!(baked, 6);
}

#[test]
fn a_cache_that_cannot_be_written_is_a_note() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("maps"), b"a file, no folder").unwrap();
    let scene = Scene {
        bodies: vec![body(tank(true))],
        blocks: vec![cube([-0.25, 0.0, -0.25], 0.5)],
        ..scene(&folder)
    };
    let prepared = run(&scene).unwrap();
    assert_eq!(prepared.particles.positions.len(), 1000);
    assert!(prepared.notes[0].contains("not kept in the cache"), "{:?}", prepared.notes);
}

#[test]
fn maps_of_another_radius_are_refused_for_bodies_and_taken_for_fills() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("maps");
    let blocks = vec![cube([-0.25, 0.0, -0.25], 0.5)];
    run(&Scene { bodies: vec![body(tank(true))], blocks: blocks.clone(), ..scene(&folder) }).unwrap();
    let file = std::fs::read_dir(map).unwrap().next().unwrap().unwrap().path();
    let from_map = Body { map: Some(file.clone()), ..Body::default() };
    let half = Scene { particle_radius: 0.0125, ..scene(&folder) };
    let error = run(&Scene { bodies: vec![from_map.clone()], blocks, ..half.clone() }).unwrap_err();
    for part in ["bodies[0].map", "0.1 m", "`calibrated`", "0.05 m", "support_radius = 0.05, invert = true"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let fills = vec![Fill {
        map: Some(file),
        within: Some(Region { min: [-1.0; 3], max: [1.0, 0.1, 1.0] }),
        ..Fill::default()
    }];
    assert!(run(&Scene { fills: fills.clone(), ..half }).unwrap().particles.positions.len() > 4 * 38 * 38);
    // Of the closure's radius it is taken for both.
    let both = run(&Scene { bodies: vec![from_map], fills, ..scene(&folder) }).unwrap();
    assert_eq!(both.bodies[0].origin, Origin::Asset);
}

#[test]
fn missing_and_useless_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let blocks = vec![cube([3.0; 3], 0.5)];
    let error = |body: Body| {
        run(&Scene { bodies: vec![body], blocks: blocks.clone(), ..scene(&folder) }).unwrap_err()
    };
    let missing = error(Body { map: Some("nowhere/tank.h5".into()), ..Body::default() });
    assert!(missing.contains("bodies[0].map: there is no file nowhere/tank.h5"), "{missing}");
    let (bad_map, bad_mesh) = (folder.path().join("bad.h5"), folder.path().join("bad.obj"));
    std::fs::write(&bad_map, b"no HDF5").unwrap();
    std::fs::write(&bad_mesh, b"f 1 2 3\n").unwrap();
    assert!(error(Body { map: Some(bad_map), ..Body::default() }).contains("bad.h5"));
    assert!(error(Body { mesh: Some(bad_mesh), ..Body::default() }).contains("bad.obj"));
    let tiny = Parameters { cell_size: Some(1e-5), ..tank(true) };
    assert!(error(body(tiny)).contains("tank.obj"));
}

#[test]
fn parameters_that_contradict_the_scene_are_refused_and_both_are_named() {
    let cache = tempfile::tempdir().unwrap();
    let bake = |given: Parameters, boundary| {
        let blocks = vec![cube([-0.5, 0.0, -0.5], 0.5)];
        let closure = scene(&cache).closure.filter(|_| boundary == BoundaryMethod::VolumeMap);
        let body = body(given.over(&tank(true)));
        run(&Scene { boundary, closure, bodies: vec![body], blocks, ..scene(&cache) })
    };
    let volume = |given| bake(given, BoundaryMethod::VolumeMap);
    let density = |given| bake(given, BoundaryMethod::DensityMap).unwrap_err();
    let radius = Parameters { support_radius: Some(0.3), ..Parameters::default() };
    let error = volume(radius).unwrap_err();
    assert!(
        error.starts_with("bodies[0].bake.support_radius: gives a map of support radius 0.3 m"),
        "{error}"
    );
    assert!(error.contains("closure `calibrated` takes one of 0.1 m"), "{error}");
    let radius = Parameters { particle_radius: Some(0.1), ..Parameters::default() };
    assert!(volume(radius).unwrap_err().starts_with("bodies[0].bake.particle_radius: "));
    let error = density(Parameters { density: Some(false), ..Parameters::default() });
    assert!(error.starts_with("bodies[0].bake.density: ") && error.contains("density_map"), "{error}");
    let error =
        density(Parameters { kernel: Some(DensityKernel(KernelKind::WendlandC2)), ..Parameters::default() });
    assert!(
        error.starts_with("bodies[0].bake.kernel: is wendland_c2, but kernel = \"cubic_spline\""),
        "{error}"
    );
    // What the scene would choose itself is no contradiction, and the rest reaches the map.
    let agreed = Parameters {
        support_radius: Some(0.1),
        precision: Some(PrecisionName::F64),
        translate: Some(Numbers([0.0, 0.05, 0.0])),
        density: Some(true),
        kernel: Some(DensityKernel(KernelKind::WendlandC2)),
        ..Parameters::default()
    };
    let prepared = volume(agreed).unwrap();
    let map = &prepared.bodies[0].map;
    assert_eq!((map.support_radius(), map.density_kernel()), (0.1, Some(KernelKind::WendlandC2)));
    let plain = volume(Parameters::default()).unwrap();
    let moved = map.grid().origin - plain.bodies[0].map.grid().origin;
    assert!(moved.distance(0.05 * DVec3::Y) < 1e-9, "{moved}");
}

/// A glTF keeps its numbers in another file: a change there is another mesh.
#[test]
fn buffers_beside_a_mesh_belong_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("cube.gltf");
    let text = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"cube.bin","byteLength":168}],
        "bufferViews":[{"buffer":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":72}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
                     {"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;
    std::fs::write(&mesh, text).unwrap();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5_u16]];
    let write = |edge: f32| {
        let corner = |n: u32| [n & 1, n >> 1 & 1, n >> 2].map(|bit| bit as f32 * edge);
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
        let mut bytes: Vec<u8> = (0..8).flat_map(corner).flat_map(f32::to_le_bytes).collect();
        bytes.extend(triangles.flat_map(u16::to_le_bytes));
        std::fs::write(folder.path().join("cube.bin"), bytes).unwrap();
    };
    let body = Body { mesh: Some(mesh), ..Body::default() };
    let scene = Scene { bodies: vec![body], blocks: vec![cube([3.0; 3], 0.2)], ..scene(&folder) };
    write(0.3);
    let first = run(&scene).unwrap();
    assert_eq!(run(&scene).unwrap().files, first.files);
    write(0.25);
    let second = run(&scene).unwrap();
    assert_ne!(second.files, first.files);
    assert_eq!(second.bodies[0].origin, Origin::Baked);
    let at = DVec3::new(0.35, 0.1, 0.1);
    assert_ne!(second.bodies[0].map.sample(at), first.bodies[0].map.sample(at));
}
