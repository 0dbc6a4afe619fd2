//! The sample meshes are what README.md says of them. Everything but the first two tests looks at the meshes
//! as they are on disk, rounded to 5 decimals.

#[path = "samples/support.rs"]
mod support;

use glam::DVec3;
use support::{intersections, min_angles, read, sharpest_fold};
use volmap_data::topology::Topology;
use volmap_data::{mesh::Mesh, obj, samples};

#[test]
fn committed_files_are_what_the_program_makes() {
    for sample in samples() {
        let made = obj::to_text(&sample.mesh, sample.title);
        assert!(made == support::text(sample.file), "{} differs: run volmap-make-data", sample.file);
    }
}

#[test]
fn files_are_small_and_hold_every_vertex_and_triangle() {
    for sample in samples() {
        let (mesh, length) = (read(sample.file), support::text(sample.file).len());
        assert_eq!(mesh.triangles, sample.mesh.triangles, "{}", sample.file);
        assert_eq!(mesh.vertices.len(), sample.mesh.vertices.len(), "{}", sample.file);
        for (rounded, exact) in mesh.vertices.iter().zip(&sample.mesh.vertices) {
            assert!((*rounded - *exact).abs().max_element() <= 0.500001e-5, "{}", sample.file);
        }
        assert!(length < if sample.file == "canyon.obj" { 3_000_000 } else { 1_500_000 }, "{length}");
    }
}

/// File, triangles, Euler characteristic, box and volume (m^3).
type Stated = (&'static str, usize, i64, [DVec3; 2], f64);

fn stated() -> [Stated; 5] {
    let v = DVec3::new;
    [
        ("duck.obj", DUCK, 2, [v(-0.65, -0.65, -0.75), v(0.65, 0.65, 0.75)], DUCK_VOLUME),
        ("canyon.obj", 65_808, 2, [v(-3.2, 0.0, 0.0), v(3.2, 3.2, 38.4)], 404.5005),
        // 81 holes through a ball: 2 - 2 * 81. Volume: 10 bars each way, less their 100 crossings.
        ("grid.obj", 4_800, -160, [v(-0.5, -0.015, -0.5), v(0.5, 0.015, 0.5)], 2e1 * 9e-4 - 1e2 * 2.7e-5),
        ("tank.obj", 12, 2, [v(-1.55, 0.0, -1.55), v(1.55, 3.1, 1.55)], 29.791),
        ("drum.obj", 144, 2, [v(-1.0, -1.0, -0.4), v(1.0, 1.0, 0.4)], 2.4203),
    ]
}

const DUCK: usize = 19_136;
const DUCK_VOLUME: f64 = 0.8309;

fn euler_characteristic(mesh: &Mesh) -> i64 {
    // In a closed mesh every edge has two triangles.
    mesh.vertices.len() as i64 - 3 * mesh.triangles.len() as i64 / 2 + mesh.triangles.len() as i64
}

#[test]
fn good_meshes_are_single_closed_oriented_manifolds() {
    for (file, triangles, euler, [low, high], volume) in stated() {
        let mesh = read(file);
        let topology = Topology::of(&mesh);
        assert!(topology.is_closed_manifold() && topology.components == 1, "{file}: {topology:?}");
        assert_eq!(mesh.triangles.len(), triangles, "{file}");
        assert_eq!(euler_characteristic(&mesh), euler, "{file}");
        assert_eq!(mesh.bounds(), (low, high), "{file}");
        assert!((mesh.volume() - volume).abs() < 1e-4, "{file}: {}", mesh.volume());
    }
}

#[test]
fn no_mesh_intersects_itself() {
    for (file, ..) in stated() {
        assert_eq!(intersections(&read(file)), 0, "{file}");
    }
    assert_eq!(intersections(&read("bad_holes.obj")), 0);
}

#[test]
fn intersections_are_seen() {
    // A small cube whose corner pokes through a face of a large one.
    let mut mesh = read("tank.obj");
    let mut poking = mesh.clone();
    for v in &mut poking.vertices {
        *v = *v * 0.1 + DVec3::new(1.5, 1.0, 0.0);
    }
    assert_eq!(intersections(&mesh), 0);
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(poking.vertices);
    mesh.triangles.extend(poking.triangles.iter().map(|t| t.map(|v| v + first)));
    assert!(intersections(&mesh) >= 4);
}

#[test]
fn duck_has_no_slivers_and_no_folds() {
    let mesh = read("duck.obj");
    let mut angles = min_angles(&mesh);
    angles.sort_by(f64::total_cmp);
    assert!(angles[0] > 20.0, "smallest angle {}", angles[0]);
    assert!(angles[angles.len() / 100] > 35.0, "1 % have less than {}", angles[angles.len() / 100]);
    assert!(angles[angles.len() / 2] > 50.0, "half have less than {}", angles[angles.len() / 2]);
    assert!(sharpest_fold(&mesh) < 75.0, "fold {}", sharpest_fold(&mesh));
}

#[test]
fn other_meshes_have_no_slivers() {
    for (file, least) in [("canyon.obj", 8.0), ("grid.obj", 40.0), ("tank.obj", 44.9), ("drum.obj", 5.0)] {
        let smallest = min_angles(&read(file)).into_iter().fold(180.0, f64::min);
        assert!(smallest > least, "{file}: {smallest}");
    }
}

#[test]
fn canyon_holds_water() {
    // The highest level at which water poured into the bed reaches no edge of the box is at least 1.8 m:
    // no point of the rim (the terrain's vertices come first, 65 to a row) is lower.
    let mesh = read("canyon.obj");
    let (columns, rows) = (65, 385);
    let rim = (0..columns * rows).filter(|i| {
        let (i, k) = (i % columns, i / columns);
        i == 0 || i == columns - 1 || k == 0 || k == rows - 1
    });
    let lowest = rim.map(|i| mesh.vertices[i].y).fold(f64::INFINITY, f64::min);
    assert!(lowest > 1.8, "{lowest}");
    // The bed is below 0.75 m, all the way between the two ends.
    for row in mesh.vertices[..columns * rows].chunks_exact(columns).skip(20).take(rows - 40) {
        let bed = row.iter().map(|v| v.y).fold(f64::INFINITY, f64::min);
        assert!(bed > 0.1 && bed < 0.75, "{bed} at z = {}", row[0].z);
    }
}

#[test]
fn bad_duck_has_exactly_the_stated_damage() {
    let mesh = read("bad_holes.obj");
    let expected = Topology {
        // Those of the three holes, and two of the fin.
        boundary_edges: 3 + 5 + 26 + 2,
        boundary_loops: 3,
        // Those of the copied triangle, and the fin's foot.
        nonmanifold_edges: 3 + 1,
        flipped_edges: 4 * 3,
        duplicate_triangles: 1,
        components: 1,
        ..Topology::default()
    };
    assert_eq!(Topology::of(&mesh), expected);
    assert_eq!(mesh.triangles.len(), 5_170);
    assert_eq!(support::boundary_loop_lengths(&mesh), [3, 5, 26]);
    // Face numbers of the file, from 1, as README.md has them.
    let numbers = |faces: Vec<usize>| faces.iter().map(|i| i + 1).collect::<Vec<_>>();
    assert_eq!(numbers(support::turned(&mesh)), [1406, 3983, 3985, 4616]);
    assert_eq!(numbers(support::copies(&mesh)), [5169]);
    assert_eq!(mesh.triangles[5169 - 1], mesh.triangles[2716 - 1]);
    assert_eq!(numbers(support::fins(&mesh)), [5170]);
}

#[test]
fn repairing_the_stated_damage_gives_a_closed_duck() {
    // Undo each kind of damage by hand: drop the copy and the fin, turn the four, close the loops by fans.
    let mut mesh = read("bad_holes.obj");
    support::repair(&mut mesh);
    let topology = Topology::of(&mesh);
    assert!(topology.is_closed_manifold() && topology.components == 1, "{topology:?}");
    assert!((mesh.volume() - DUCK_VOLUME).abs() < 0.02, "{}", mesh.volume());
}
