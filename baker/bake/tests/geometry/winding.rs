use glam::DVec3;
use volmap_bake::sdf::brute_force;
use volmap_bake::sdf::bvh::Bvh;
use volmap_bake::sdf::winding::{BETA, WindingNumbers, solid_angle};
use volmap_formats::mesh::TriangleMesh;

use crate::shapes::{self, Random, corners};

/// Largest error of the fast sum at random points in and around the mesh.
fn worst_error(mesh: &TriangleMesh, beta: f64) -> f64 {
    let triangles = corners(mesh);
    let bvh = Bvh::new(&triangles);
    let winding = WindingNumbers::new(&bvh);
    let mut random = Random::knuth(9);
    let mut worst: f64 = 0.0;
    for _ in 0..300 {
        let p = random.point(DVec3::splat(-1.5), DVec3::splat(1.5));
        let slow = brute_force::winding_number(&triangles, p);
        assert!((WindingNumbers::exact(&bvh, p) - slow).abs() < 1e-11);
        worst = worst.max((winding.fast(&bvh, p, beta) - slow).abs());
    }
    worst
}

#[test]
fn solid_angle_of_an_octant() {
    let octant = [DVec3::X, DVec3::Y, DVec3::Z];
    let expected = std::f64::consts::FRAC_PI_2;
    assert!((solid_angle(DVec3::ZERO, &octant) - expected).abs() < 1e-15);
    assert!((solid_angle(DVec3::splat(2.0), &octant)) < 0.0);
}

#[test]
fn closed_surface_is_one_inside_and_zero_outside() {
    let triangles = corners(&shapes::icosphere(3));
    let bvh = Bvh::new(&triangles);
    let winding = WindingNumbers::new(&bvh);
    let mut random = Random::knuth(1);
    for _ in 0..2_000 {
        let p = random.point(DVec3::splat(-1.3), DVec3::splat(1.3));
        if (0.985..1.0).contains(&p.length()) {
            continue;
        }
        let expected = if p.length() < 1.0 { 1.0 } else { 0.0 };
        assert!((WindingNumbers::exact(&bvh, p) - expected).abs() < 1e-12, "{p}");
        assert!((winding.fast(&bvh, p, BETA) - expected).abs() < 0.01, "{p}");
        assert_eq!(winding.inside(&bvh, p, true), expected > 0.5, "{p}");
        assert_eq!(winding.inside(&bvh, p, false), expected > 0.5, "{p}");
    }
}

/// The cube [-1, 1]^3 without its lid: at the centre 5/6, and less than a half near the opening.
#[test]
fn open_box_is_a_fraction() {
    let mut mesh = shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE);
    mesh.triangles.truncate(10);
    let triangles = corners(&mesh);
    let bvh = Bvh::new(&triangles);
    let winding = WindingNumbers::new(&bvh);
    assert!((winding.fast(&bvh, DVec3::ZERO, BETA) - 5.0 / 6.0).abs() < 1e-12);
    for z in [-0.9, 0.0, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0] {
        // Solid angle of a square of half side 1 seen from the height h above its middle.
        let h: f64 = z - 1.0;
        let lid = 4.0 * (1.0 / (h.abs() * (2.0 + h * h).sqrt())).atan() / (4.0 * std::f64::consts::PI);
        let expected = if z < 1.0 { 1.0 - lid } else { lid };
        let p = DVec3::new(0.0, 0.0, z);
        assert!((WindingNumbers::exact(&bvh, p) - expected).abs() < 1e-12, "{z}");
        assert_eq!(winding.inside(&bvh, p, false), expected > 0.5, "{z}");
    }
}

#[test]
fn fast_sum_is_close_to_the_exact_sum() {
    let mut bowl = shapes::icosphere(4);
    bowl.triangles.retain(|t| t.iter().any(|&v| bowl.vertices[v as usize][2] < 0.3));
    let meshes = [
        shapes::icosphere(4),
        bowl,
        shapes::torus(1.0, 0.4, 80, 40),
        shapes::moved(shapes::soup(4_000, 0.05, 5), 2.0, DVec3::NEG_ONE),
    ];
    for mesh in &meshes {
        let (coarse, usual, fine) = (worst_error(mesh, 1.5), worst_error(mesh, BETA), worst_error(mesh, 8.0));
        assert!(coarse < 0.1 && usual < 5e-3 && fine < 2e-5, "{coarse} {usual} {fine}");
    }
}

/// Where the exact value is all but one half, `inside` must still agree with the exact sum.
#[test]
fn close_to_one_half_the_exact_sum_decides() {
    let mut mesh = shapes::icosphere(3);
    mesh.triangles.retain(|t| t.iter().all(|&v| mesh.vertices[v as usize][2] < 0.5));
    let triangles = corners(&mesh);
    let bvh = Bvh::new(&triangles);
    let winding = WindingNumbers::new(&bvh);
    for x in [-0.4, -0.1, 0.0, 0.3] {
        let at = |z: f64| DVec3::new(x, 0.05, z);
        let (mut inside, mut outside) = (0.0, 1.5);
        for _ in 0..60 {
            let z = (inside + outside) / 2.0;
            let exact = WindingNumbers::exact(&bvh, at(z)) > 0.5;
            assert_eq!(winding.inside(&bvh, at(z), false), exact, "{x} {z}");
            if exact { inside = z } else { outside = z }
        }
    }
}
