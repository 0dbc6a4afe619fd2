use std::f64::consts::TAU;

use glam::DVec3;
use volmap_bake::mesh::{diagnose, orient};
use volmap_bake::sdf::{Feature, MeshDistance, SignMethod, choose_sign, compare_signs, points_near_surface};
use volmap_bake::watch::Work;
use volmap_formats::mesh::TriangleMesh;

use crate::shapes::{self, Random};

fn with_method(mesh: &TriangleMesh, method: SignMethod) -> MeshDistance {
    MeshDistance::new(mesh, method, &diagnose(mesh))
}

/// Outside a sharp wedge, beyond its edge, the closest point is on the edge, and one of the two faces
/// looks away from the point: its plain normal would say inside. The pseudonormal must not.
#[test]
fn pseudonormal_at_an_acute_edge() {
    let mesh = shapes::wedge(0.1);
    let diagnosis = diagnose(&mesh);
    assert!(diagnosis.closed && diagnosis.oriented && diagnosis.manifold_vertices);
    let distance = with_method(&mesh, SignMethod::Pseudonormal);
    let mut wrong_by_face = 0;
    let mut random = Random::knuth(1);
    for _ in 0..2_000 {
        let p = random.point(DVec3::new(-0.5, -0.04, -0.9), DVec3::new(-0.01, 0.04, 0.9));
        let closest = distance.closest(p);
        if closest.point.x > 1e-12 {
            continue;
        }
        assert!(matches!(closest.feature, Feature::Edge(_)), "{closest:?}");
        assert!(distance.signed_distance(p) > 0.0, "{p}");
        let triangle = mesh.triangles[closest.triangle as usize];
        let [a, b, c] = triangle.map(|v| DVec3::from(mesh.vertices[v as usize]));
        wrong_by_face += usize::from((b - a).cross(c - a).dot(p - closest.point) < 0.0);
    }
    assert!(wrong_by_face > 100, "the case is not hard: {wrong_by_face}");
}

/// The same at a vertex: the tip of a pyramid whose faces are of very different angles there.
#[test]
fn pseudonormal_at_an_acute_vertex() {
    let vertices = vec![[0., 0., 0.], [1., 0.2, -0.01], [1., -0.2, -0.05], [1., 0.0, 0.3], [1., 0.05, 0.3]];
    let triangles = vec![[0, 2, 1], [0, 1, 4], [0, 4, 3], [0, 3, 2], [1, 2, 3], [1, 3, 4]];
    let mut mesh = TriangleMesh { vertices, triangles };
    orient(&mut mesh);
    assert!(diagnose(&mesh).volume > 0.0 && diagnose(&mesh).balanced);
    let distance = with_method(&mesh, SignMethod::Pseudonormal);
    let mut random = Random::knuth(2);
    let mut at_tip = 0;
    for _ in 0..5_000 {
        let p = random.point(DVec3::splat(-0.5), DVec3::splat(0.5));
        let closest = distance.closest(p);
        if closest.point == DVec3::ZERO {
            at_tip += 1;
            assert!(distance.signed_distance(p) > 0.0, "{p}");
        }
    }
    assert!(at_tip > 500);
}

/// Both signs agree on clean surfaces, near and far.
#[test]
fn signs_agree_on_clean_surfaces() {
    let sphere = shapes::icosphere(3);
    let hollow = shapes::merged(&[
        sphere.clone(),
        shapes::flipped(shapes::moved(sphere.clone(), 0.5, DVec3::X * 0.2)),
    ]);
    let meshes = [
        sphere,
        hollow,
        shapes::l_shape(),
        shapes::torus(1.0, 0.4, 50, 25),
        shapes::cuboid(DVec3::new(-1.0, -1.0, -1e-4), DVec3::new(1.0, 1.0, 1e-4)),
        shapes::wedge(0.02),
    ];
    let mut random = Random::knuth(3);
    for mesh in &meshes {
        let diagnosis = diagnose(mesh);
        assert!(choose_sign(&diagnosis).reason.contains("exact"));
        let distance = with_method(mesh, SignMethod::Auto);
        let (lower, upper) = (DVec3::from(diagnosis.bounds.lower), DVec3::from(diagnosis.bounds.upper));
        let mut points: Vec<DVec3> = (0..2_000).map(|_| random.point(lower - 0.1, upper + 0.1)).collect();
        for corners in shapes::corners(mesh) {
            let at = (corners[0] + corners[1] * 0.7 + corners[2] * 0.3) / 2.0;
            points.push(at + random.point(DVec3::splat(-1e-3), DVec3::splat(1e-3)));
        }
        let comparison = compare_signs(&distance, &points, &Work::default()).unwrap();
        assert_eq!(comparison.disagreeing, 0, "{comparison:?}");
        assert_eq!(comparison.points, points.len());
        assert!(comparison.bounds.is_none() && comparison.worst.is_empty());
    }
}

/// Two overlapping balls: inside one, close to the other's surface, pseudonormals say outside.
#[test]
fn overlapping_parts_get_winding_numbers() {
    let sphere = shapes::icosphere(3);
    let mesh = shapes::merged(&[sphere.clone(), shapes::moved(sphere, 1.0, DVec3::X)]);
    let choice = choose_sign(&diagnose(&mesh));
    assert_eq!(choice.method, SignMethod::Winding, "{}", choice.reason);
    let distance = with_method(&mesh, SignMethod::Auto);
    let mut random = Random::knuth(4);
    let points: Vec<DVec3> =
        (0..3_000).map(|_| random.point(DVec3::splat(-1.2), DVec3::new(2.2, 1.2, 1.2))).collect();
    for &p in &points {
        let exact = (p.length() - 1.0).min(p.distance(DVec3::X) - 1.0);
        if exact.abs() > 0.02 {
            assert_eq!(distance.signed_distance(p) < 0.0, exact < 0.0, "{p}");
            assert_eq!(distance.sign(p) < 0.0, exact < 0.0, "{p}");
        }
    }
    let comparison = compare_signs(&distance, &points, &Work::default()).unwrap();
    assert!(comparison.disagreeing > 20, "{comparison:?}");
    assert!(comparison.worst[0].1 >= comparison.worst[1].1);
}

#[test]
fn a_solid_in_a_solid_gets_winding_numbers() {
    let sphere = shapes::icosphere(3);
    let mesh = shapes::merged(&[sphere.clone(), shapes::moved(sphere, 0.5, DVec3::ZERO)]);
    let distance = with_method(&mesh, SignMethod::Auto);
    assert_eq!(distance.sign_choice().method, SignMethod::Winding);
    assert!(distance.signed_distance(DVec3::new(0.55, 0.0, 0.0)) < 0.0);
    assert!(distance.signed_distance(DVec3::new(0.2, 0.0, 0.0)) < 0.0);
}

/// Middle of the tube below where it has gone around by the angle 2 u: radius and height.
fn coil(u: f64) -> (f64, f64) {
    (1.0 + 0.15 * u.cos(), 0.15 * u.sin())
}

/// A closed tube of radius 0.3 that goes around the z axis twice, and overlaps itself all along.
fn coiled_tube() -> TriangleMesh {
    let (around, along) = (160, 40);
    let mut mesh = shapes::torus(1.0, 0.3, around, along);
    for (i, vertex) in mesh.vertices.iter_mut().enumerate() {
        let u = (i as u32 / along) as f64 / f64::from(around) * TAU;
        let v = (i as u32 % along) as f64 / f64::from(along) * TAU;
        let (radius, height) = coil(u);
        let radius = radius + 0.3 * v.cos();
        *vertex = [radius * (2.0 * u).cos(), radius * (2.0 * u).sin(), height + 0.3 * v.sin()];
    }
    mesh
}

/// One component that passes through itself: inside the tube, close to where its other turn has its
/// surface, pseudonormals say outside.
#[test]
fn a_component_through_itself_is_a_union() {
    let mesh = coiled_tube();
    let diagnosis = diagnose(&mesh);
    assert!(diagnosis.components == 1 && diagnosis.closed && diagnosis.oriented);
    let distance = with_method(&mesh, SignMethod::Auto);
    let mut random = Random::knuth(5);
    for _ in 0..3_000 {
        let p = random.point(DVec3::new(-1.6, -1.6, -0.6), DVec3::new(1.6, 1.6, 0.6));
        let exact = [0.0, TAU / 2.0].map(|turn| {
            let (radius, height) = coil(p.y.atan2(p.x) / 2.0 + turn);
            (p.x.hypot(p.y) - radius).hypot(p.z - height) - 0.3
        });
        let exact = exact[0].min(exact[1]);
        if exact.abs() > 0.01 {
            assert_eq!(distance.signed_distance(p) < 0.0, exact < 0.0, "{p}");
        }
    }
    let near = points_near_surface(&shapes::corners(&mesh));
    assert!(compare_signs(&distance, &near, &Work::default()).unwrap().disagreeing > 1_000);
}

/// Trust is told apart: closed, open, and scrambled.
#[test]
fn choice_says_how_far_it_can_be_trusted() {
    let reason = |mesh: &TriangleMesh| choose_sign(&diagnose(mesh)).reason;
    assert!(reason(&shapes::icosphere(1)).contains("exact"));
    assert!(reason(&shapes::open_cylinder(9, 1.0)).contains("holes"));
    let mut scrambled = shapes::icosphere(1);
    scrambled.triangles[3].swap(0, 1);
    assert!(reason(&scrambled).contains("doubtful"));
}

/// Along a line of steps of all sizes, what is known of the last point changes nothing.
#[test]
fn known_distances_change_nothing() {
    let sphere = shapes::icosphere(3);
    let open = shapes::open_cylinder(24, 1.0);
    let overlap = shapes::merged(&[sphere.clone(), shapes::moved(sphere, 1.0, DVec3::X)]);
    for mesh in [overlap, open, shapes::torus(1.0, 0.4, 40, 20)] {
        let distance = with_method(&mesh, SignMethod::Auto);
        let mut random = Random::knuth(6);
        let mut point = DVec3::splat(-1.5);
        let resolved = |mut known| {
            distance.side(&mut known);
            known
        };
        let mut known = resolved(distance.distance_near(point, None));
        for k in 0..3_000 {
            let step = [0.01, 0.1, 1.0][k % 3];
            let next = random.point(DVec3::splat(-step), DVec3::splat(step)) + point * 0.97;
            let found = resolved(distance.distance_near(next, Some(&known)));
            assert_eq!(found, resolved(distance.distance_near(next, None)), "{next}");
            (point, known) = (next, found);
        }
    }
}
