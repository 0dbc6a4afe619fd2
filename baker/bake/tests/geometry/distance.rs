use glam::DVec3;
use proptest::prelude::*;
use volmap_bake::mesh::diagnose;
use volmap_bake::sdf::closest_point::closest_point_on_triangle;
use volmap_bake::sdf::{Feature, MeshDistance, SignMethod, brute_force, bvh::Bvh};
use volmap_formats::mesh::TriangleMesh;

use crate::shapes::{self, Random, corners};

pub fn distance_to(mesh: &TriangleMesh) -> MeshDistance {
    MeshDistance::new(mesh, SignMethod::Auto, &diagnose(mesh))
}

/// Signed distance to a box of half the size `half` around `centre`.
fn box_distance(p: DVec3, centre: DVec3, half: DVec3) -> f64 {
    let q = (p - centre).abs() - half;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

#[test]
fn box_is_exact_everywhere() {
    let (lower, upper) = (DVec3::new(-0.5, 0.1, 2.0), DVec3::new(0.7, 1.3, 2.5));
    let distance = distance_to(&shapes::cuboid(lower, upper));
    let mut random = Random::knuth(1);
    for _ in 0..5_000 {
        let p = random.point(lower - 1.0, upper + 1.0);
        let expected = box_distance(p, (lower + upper) / 2.0, (upper - lower) / 2.0);
        assert!((distance.signed_distance(p) - expected).abs() < 1e-14, "{p}");
    }
}

#[test]
fn thin_plate_is_exact_everywhere() {
    let half = DVec3::new(1.0, 1.0, 1e-5);
    let distance = distance_to(&shapes::cuboid(-half, half));
    let mut random = Random::knuth(2);
    for i in 0..5_000 {
        let reach = if i % 2 == 0 { half * 1.5 } else { half + 0.5 };
        let p = random.point(-reach, reach);
        let expected = box_distance(p, DVec3::ZERO, half);
        assert!((distance.signed_distance(p) - expected).abs() < 1e-14, "{p}");
    }
}

#[test]
fn sphere_is_within_its_facet_error() {
    let distance = distance_to(&shapes::icosphere(4));
    // The facets' inradius bounds the error from below: sagitta of the longest edge's circumcircle.
    let sagitta = 2.5e-3;
    let mut random = Random::knuth(3);
    for _ in 0..5_000 {
        let p = random.point(DVec3::splat(-2.0), DVec3::splat(2.0));
        let error = distance.signed_distance(p) - (p.length() - 1.0);
        assert!((-1e-12..sagitta).contains(&error), "{p}: {error}");
    }
}

#[test]
fn torus_is_within_its_facet_error() {
    let distance = distance_to(&shapes::torus(1.0, 0.4, 96, 48));
    let mut random = Random::knuth(4);
    for _ in 0..5_000 {
        let p = random.point(DVec3::splat(-1.6), DVec3::splat(1.6));
        let ring = DVec3::new(p.x, p.y, 0.0).length() - 1.0;
        let error = distance.signed_distance(p) - (ring.hypot(p.z) - 0.4);
        assert!(error.abs() < 2.5e-3, "{p}: {error}");
    }
}

#[test]
fn l_shape_is_exact_outside() {
    let distance = distance_to(&shapes::l_shape());
    let boxes = [
        (DVec3::new(1.0, 0.5, 0.5), DVec3::new(1.0, 0.5, 0.5)),
        (DVec3::new(0.5, 1.0, 0.5), DVec3::new(0.5, 1.0, 0.5)),
    ];
    let mut random = Random::knuth(5);
    for _ in 0..5_000 {
        let p = random.point(DVec3::splat(-1.0), DVec3::splat(3.0));
        let union = boxes.map(|(centre, half)| box_distance(p, centre, half));
        let expected = union[0].min(union[1]);
        let found = distance.signed_distance(p);
        assert_eq!(found < 0.0, expected < 0.0, "{p}");
        assert!(expected < 0.0 || (found - expected).abs() < 1e-14, "{p}");
    }
}

#[test]
fn features_are_told_apart() {
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let cases = [
        (DVec3::new(0.2, 0.2, 3.0), Feature::Face, DVec3::new(0.2, 0.2, 0.0)),
        (DVec3::new(0.3, -2.0, 1.0), Feature::Edge(0), DVec3::new(0.3, 0.0, 0.0)),
        (DVec3::new(1.0, 1.0, -1.0), Feature::Edge(1), DVec3::new(0.5, 0.5, 0.0)),
        (DVec3::new(-1.0, 0.6, 0.0), Feature::Edge(2), DVec3::new(0.0, 0.6, 0.0)),
        (DVec3::new(-1.0, -1.0, 1.0), Feature::Vertex(0), DVec3::ZERO),
        (DVec3::new(3.0, 0.5, 0.0), Feature::Vertex(1), DVec3::X),
        (DVec3::new(0.5, 3.0, 0.0), Feature::Vertex(2), DVec3::Y),
    ];
    for (p, feature, point) in cases {
        let found = closest_point_on_triangle(p, &triangle);
        assert_eq!(found.feature, feature, "{p}");
        assert!(found.point.distance(point) < 1e-15, "{p}");
        assert!((found.distance_squared - p.distance_squared(point)).abs() < 1e-14);
    }
}

#[test]
fn triangle_without_area_is_a_segment() {
    let line = [DVec3::ZERO, DVec3::X, DVec3::new(0.4, 0.0, 0.0)];
    for (p, expected) in [
        (DVec3::new(0.7, 2.0, 0.0), 2.0),
        (DVec3::new(-3.0, 4.0, 0.0), 5.0),
        (DVec3::new(0.4, 0.0, 0.0), 0.0),
    ] {
        let found = closest_point_on_triangle(p, &line);
        assert!((found.distance_squared.sqrt() - expected).abs() < 1e-15, "{p}");
    }
}

/// A needle's exact distance is that to its long axis, to within its width.
#[test]
fn needles_are_as_exact_as_their_width() {
    let mut random = Random::knuth(6);
    for exponent in 1..16 {
        let width = 10f64.powi(-exponent);
        let needle = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, width, 0.0)];
        for _ in 0..200 {
            let p = random.point(DVec3::splat(-0.5), DVec3::splat(1.5));
            let axis = DVec3::new(p.x.clamp(0.0, 1.0), 0.0, 0.0);
            let found = closest_point_on_triangle(p, &needle).distance_squared.sqrt();
            assert!((found - p.distance(axis)).abs() <= width + 1e-15, "{width} {p}");
            // Above the needle's inside the distance is the height, however thin it is.
            let above = DVec3::new(p.x.clamp(0.1, 0.9), 0.1 * width, 1e-3);
            let found = closest_point_on_triangle(above, &needle).distance_squared.sqrt();
            assert!((found - 1e-3).abs() < 1e-12, "{width} {above}: {found}");
        }
    }
}

#[test]
fn bvh_is_brute_force() {
    let sphere = shapes::icosphere(3);
    let meshes = [
        shapes::soup(1, 0.3, 1),
        shapes::soup(5, 0.3, 2),
        shapes::soup(300, 0.1, 3),
        shapes::soup(1000, 1.0, 4),
        shapes::torus(1.0, 0.4, 40, 20),
        shapes::moved(sphere.clone(), 1e-6, DVec3::new(3.0, -2.0, 1e3)),
        shapes::moved(sphere.clone(), 1e9, DVec3::ZERO),
        shapes::moved(sphere, 1e-30, DVec3::ZERO),
    ];
    for (i, mesh) in meshes.iter().enumerate() {
        let triangles = corners(mesh);
        let tree = Bvh::new(&triangles);
        let bounds = diagnose(mesh).bounds;
        let (lower, upper) = (DVec3::from(bounds.lower), DVec3::from(bounds.upper));
        let size = (upper - lower).length();
        let mut random = Random::knuth(i as u64);
        for k in 0..400 {
            let reach = [0.0, 0.2, 20.0][k % 3] * size;
            let p = random.point(lower - reach, upper + reach);
            let (fast, slow) = (tree.closest(p, f64::INFINITY), brute_force::closest(&triangles, p));
            let (d, expected) = (fast.distance_squared.sqrt(), slow.distance_squared.sqrt());
            assert!((d - expected).abs() <= 1e-13 * (size + expected), "{i} {p}: {d} {expected}");
            assert!((fast.point.distance(p) - d).abs() <= 1e-13 * (size + p.length()));
        }
    }
}

/// All triangles around a vertex are equally far from a point beyond it; the lowest must win, whatever
/// the order in which the tree was walked.
#[test]
fn ties_go_to_the_lowest_triangle() {
    let mesh = shapes::icosphere(3);
    let distance = distance_to(&mesh);
    for (vertex, position) in mesh.vertices.iter().enumerate() {
        let lowest = mesh.triangles.iter().position(|t| t.contains(&(vertex as u32)));
        let p = DVec3::from(*position) * 1.7;
        let found = distance.closest(p);
        assert!(matches!(found.feature, Feature::Vertex(_)));
        assert_eq!(Some(found.triangle as usize), lowest);
        assert_eq!(distance.closest_within(p, 0.75), found);
    }
}

#[test]
fn upper_bound_changes_nothing() {
    let mesh = shapes::torus(1.0, 0.4, 60, 30);
    let distance = distance_to(&mesh);
    let mut random = Random::knuth(7);
    for _ in 0..1_000 {
        let p = random.point(DVec3::splat(-1.5), DVec3::splat(1.5));
        let found = distance.closest(p);
        let d = found.distance_squared.sqrt();
        for bound in [0.0, 0.5 * d, d, 1.1 * d, d + 1.0] {
            assert_eq!(distance.closest_within(p, bound), found, "{p} {bound}");
        }
    }
}

#[test]
fn far_and_odd_points_are_answered() {
    let distance = distance_to(&shapes::icosphere(2));
    for far in [1e6, 1e13, 1e30, 1e100] {
        let d = distance.signed_distance(DVec3::new(0.0, far, 0.0));
        assert!((d - far).abs() <= 1e-15 * far + 1.0, "{far}: {d}");
    }
    assert!(distance.signed_distance(DVec3::NAN).is_nan());
    assert!(distance.unsigned_distance(DVec3::INFINITY) == f64::INFINITY);
}

#[test]
fn bvh_does_not_depend_on_threads() {
    let mesh = shapes::torus(1.0, 0.4, 170, 50);
    let triangles = corners(&mesh);
    let built = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        format!("{:?}", pool.install(|| Bvh::new(&triangles)))
    };
    assert!(built(1) == built(3));
}

fn any_point(size: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-size..size).prop_map(DVec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn distance_is_lipschitz(seed in 0u64..20, p in any_point(2.0), q in any_point(2.0)) {
        let distance = distance_to(&shapes::soup(50, 0.4, seed));
        let change = (distance.unsigned_distance(p) - distance.unsigned_distance(q)).abs();
        prop_assert!(change <= p.distance(q) + 1e-14);
    }

    #[test]
    fn bvh_of_any_soup_is_brute_force(seed: u64, count in 1usize..80, p in any_point(2.0)) {
        let mesh = shapes::soup(count, 0.4, seed);
        let fast = distance_to(&mesh).unsigned_distance(p);
        let slow = brute_force::closest(&corners(&mesh), p).distance_squared.sqrt();
        prop_assert!((fast - slow).abs() <= 1e-14 + 1e-14 * slow, "{} {}", fast, slow);
    }
}
