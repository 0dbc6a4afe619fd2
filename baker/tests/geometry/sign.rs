use glam::DVec3;
use volmap_baker::mesh::{diagnose, orient};
use volmap_baker::sdf::{Feature, MeshDistance, SignMethod, choose_sign, compare_signs};
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
    let mut random = Random(1);
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
    let mut random = Random(2);
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
    let mut random = Random(3);
    for mesh in &meshes {
        let diagnosis = diagnose(mesh);
        assert_eq!(choose_sign(&diagnosis).method, SignMethod::Pseudonormal);
        let distance = with_method(mesh, SignMethod::Auto);
        let (lower, upper) = (DVec3::from(diagnosis.bounds.lower), DVec3::from(diagnosis.bounds.upper));
        let mut points: Vec<DVec3> = (0..2_000).map(|_| random.point(lower - 0.1, upper + 0.1)).collect();
        for corners in shapes::corners(mesh) {
            let at = (corners[0] + corners[1] * 0.7 + corners[2] * 0.3) / 2.0;
            points.push(at + random.point(DVec3::splat(-1e-3), DVec3::splat(1e-3)));
        }
        let comparison = compare_signs(&distance, &points);
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
    let mut random = Random(4);
    let points: Vec<DVec3> =
        (0..3_000).map(|_| random.point(DVec3::splat(-1.2), DVec3::new(2.2, 1.2, 1.2))).collect();
    for &p in &points {
        let exact = (p.length() - 1.0).min(p.distance(DVec3::X) - 1.0);
        if exact.abs() > 0.02 {
            assert_eq!(distance.signed_distance(p) < 0.0, exact < 0.0, "{p}");
            assert_eq!(distance.sign(p) < 0.0, exact < 0.0, "{p}");
        }
    }
    let comparison = compare_signs(&distance, &points);
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

/// One component that passes through itself: the torus of small major radius.
#[test]
fn a_component_through_itself_gets_winding_numbers() {
    let mesh = shapes::torus(0.3, 1.0, 60, 40);
    assert_eq!(choose_sign(&diagnose(&mesh)).method, SignMethod::Pseudonormal);
    let distance = with_method(&mesh, SignMethod::Auto);
    let choice = distance.sign_choice();
    assert_eq!(choice.method, SignMethod::Winding, "{}", choice.reason);
}
