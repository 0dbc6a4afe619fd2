use glam::DVec3;
use proptest::prelude::*;
use volmap_bake::mesh::topology::Topology;
use volmap_bake::mesh::{diagnose, orient, prepare};
use volmap_formats::mesh::TriangleMesh;

use crate::shapes::{self, Random};

/// Flips about `percent` of the triangles and returns how many.
fn scramble(mesh: &mut TriangleMesh, percent: f64, seed: u64) -> usize {
    let mut random = Random::knuth(seed);
    let mut count = 0;
    for triangle in &mut mesh.triangles {
        if random.unit() * 100.0 < percent {
            triangle.swap(1, 2);
            count += 1;
        }
    }
    count
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn scrambled_torus_is_repaired(percent in 1.0..40.0, seed: u64) {
        let original = shapes::torus(1.0, 0.4, 30, 20);
        let mut mesh = original.clone();
        let flipped = scramble(&mut mesh, percent, seed);
        let repair = orient(&mut mesh);
        prop_assert_eq!(repair.flipped_triangles, flipped);
        prop_assert_eq!(repair.repaired_patches, usize::from(flipped > 0));
        prop_assert_eq!(repair.turned_patches, 0);
        for (found, expected) in mesh.triangles.iter().zip(&original.triangles) {
            let start = found.iter().position(|v| *v == expected[0]).unwrap();
            prop_assert_eq!([found[start], found[(start + 1) % 3], found[(start + 2) % 3]], *expected);
        }
    }
}

#[test]
fn clean_mesh_is_left_alone() {
    let mut mesh = shapes::merged(&[
        shapes::icosphere(2),
        shapes::flipped(shapes::moved(shapes::icosphere(2), 0.5, DVec3::ZERO)),
        shapes::moved(shapes::open_cylinder(20, 1.0), 1.0, DVec3::X * 5.0),
    ]);
    let original = mesh.clone();
    assert_eq!(orient(&mut mesh), Default::default());
    assert_eq!(mesh, original);
}

#[test]
fn inside_out_sphere_is_turned() {
    let mut mesh = shapes::flipped(shapes::icosphere(2));
    let repair = orient(&mut mesh);
    assert_eq!((repair.turned_patches, repair.flipped_triangles), (1, mesh.triangles.len()));
    assert!(diagnose(&mesh).volume > 0.0);
}

/// A hollow ball that is wholly inside out stays a hollow ball.
#[test]
fn what_lies_inside_turns_along() {
    let mut mesh = shapes::merged(&[
        shapes::moved(shapes::icosphere(2), 0.5, DVec3::ZERO),
        shapes::flipped(shapes::icosphere(2)),
    ]);
    let repair = orient(&mut mesh);
    assert_eq!((repair.turned_patches, repair.turned_along), (1, 1));
    let found = diagnose(&mesh);
    assert_eq!(
        (found.cavities.count, found.nested_solids.count, found.inside_out_components.count),
        (1, 0, 0)
    );
}

#[test]
fn moebius_strip_is_reported() {
    let mut mesh = shapes::moebius_strip(41);
    let repair = orient(&mut mesh);
    assert_eq!(repair.non_orientable_patches, 1);
    assert_eq!(repair.non_orientable_places.len(), 1);
    let found = diagnose(&mesh);
    assert_eq!((found.boundary_loop_count, found.boundary_loops[0].edges), (1, 82));
    assert!(!found.oriented);
}

#[test]
fn open_patch_keeps_its_majority() {
    let original = shapes::flipped(shapes::open_cylinder(30, 1.0));
    let mut mesh = original.clone();
    let flipped = scramble(&mut mesh, 20.0, 3);
    let repair = orient(&mut mesh);
    assert_eq!((repair.flipped_triangles, repair.repaired_patches), (flipped, 1));
    assert!(diagnose(&mesh).oriented);
}

/// Orienting twice changes nothing the second time.
#[test]
fn orientation_is_idempotent() {
    let mut mesh = shapes::merged(&[
        shapes::moebius_strip(20),
        shapes::flipped(shapes::torus(1.0, 0.3, 20, 10)),
        shapes::moved(shapes::icosphere(2), 0.2, DVec3::X),
        shapes::soup(50, 0.3, 1),
    ]);
    scramble(&mut mesh, 30.0, 5);
    orient(&mut mesh);
    let once = mesh.clone();
    let again = orient(&mut mesh);
    assert_eq!(again.flipped_triangles, 0);
    assert_eq!(mesh, once);
}

/// A hollow may touch the outer surface from inside: corners there are on the surface, and the others tell.
#[test]
fn hollow_that_touches_the_outside_stays_hollow() {
    let mut mesh = shapes::merged(&[
        shapes::cuboid(DVec3::ZERO, DVec3::ONE),
        shapes::flipped(shapes::cuboid(DVec3::new(0.0, 0.2, 0.2), DVec3::new(0.4, 0.6, 0.6))),
        shapes::flipped(shapes::moved(shapes::icosphere(1), 0.25, DVec3::new(0.5, 0.75, 0.75))),
    ]);
    assert_eq!(orient(&mut mesh), Default::default());
    assert_eq!(diagnose(&mesh).cavities.count, 2);
}

/// What `prepare` hands on from orienting to diagnosing is what diagnosing finds by itself.
#[test]
fn preparation_finds_what_its_steps_find() {
    let hollow = |seed| {
        let mut mesh = shapes::merged(&[
            shapes::moved(shapes::torus(1.0, 0.3, 20, 10), 0.2, DVec3::splat(0.1)),
            shapes::flipped(shapes::icosphere(2)),
            shapes::moved(shapes::icosphere(1), 0.5, DVec3::Y * 5.0),
            shapes::moved(shapes::open_cylinder(20, 1.0), 1.0, DVec3::X * 5.0),
        ]);
        scramble(&mut mesh, 10.0, seed);
        mesh
    };
    // Two wings that share an edge of the ball.
    let mut winged = hollow(2);
    let [a, b, _] = winged.triangles[500];
    let tip = winged.vertices.len() as u32;
    winged.vertices.extend([[3.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    winged.triangles.extend([[a, b, tip], [b, a, tip + 1]]);
    for mesh in [hollow(1), winged, shapes::soup(200, 0.3, 1), shapes::moebius_strip(20)] {
        for keep_orientation in [true, false] {
            let (mut stepwise, mut prepared) = (mesh.clone(), mesh.clone());
            let repair = if keep_orientation { Default::default() } else { orient(&mut stepwise) };
            let found = prepare(&mut prepared, keep_orientation);
            assert_eq!(prepared, stepwise);
            assert_eq!(found.repair, repair);
            assert_eq!(found.diagnosis, diagnose(&stepwise));
            assert_eq!(found.topology, Topology::new(&stepwise));
        }
    }
}
