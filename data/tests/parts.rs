//! The mesher, the noise and the counts on shapes whose answers are known.

use glam::{DVec2, DVec3};
use volmap_data::improve::improve;
use volmap_data::mesh::Mesh;
use volmap_data::noise::{fractal, noise};
use volmap_data::solids::{ellipsoid, smooth_union, tapered, untilt};
use volmap_data::surface::{self, Lattice, gradient, project};
use volmap_data::tank::tank;
use volmap_data::topology::Topology;

const RADII: DVec3 = DVec3::new(0.9, 0.6, 0.4);

fn egg(p: DVec3) -> f64 {
    ellipsoid(p, DVec3::ZERO, RADII)
}

fn egg_mesh(cell: f64) -> Mesh {
    surface::mesh(egg, Lattice { low: DVec3::splat(-1.03), high: DVec3::splat(1.03), cell })
}

#[test]
fn meshed_ellipsoid_converges_to_second_order() {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * RADII.element_product();
    let error = |cell: f64| {
        let mesh = egg_mesh(cell);
        assert!(Topology::of(&mesh).is_closed_manifold());
        for v in &mesh.vertices {
            assert!(((*v / RADII).length() - 1.0).abs() < 1e-9, "{v} is off the surface");
        }
        (volume - mesh.volume()) / volume
    };
    let (coarse, fine) = (error(0.1), error(0.05));
    assert!(coarse > 0.0 && coarse < 0.03, "{coarse}");
    assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn improving_keeps_the_surface_and_widens_the_smallest_angle() {
    let smallest = |mesh: &Mesh| {
        let angle = |p: DVec3, q: DVec3, r: DVec3| (q - p).angle_between(r - p).to_degrees();
        let of = |&t: &[u32; 3]| {
            let [a, b, c] = mesh.corners(t);
            angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
        };
        mesh.triangles.iter().map(of).fold(180.0, f64::min)
    };
    let mut mesh = egg_mesh(0.05);
    let before = smallest(&mesh);
    improve(&mut mesh, egg, 20);
    assert!(Topology::of(&mesh).is_closed_manifold());
    assert!(mesh.vertices.iter().all(|v| ((*v / RADII).length() - 1.0).abs() < 1e-9));
    assert!(before < 20.0 && smallest(&mesh) > 30.0, "{before} {}", smallest(&mesh));
}

#[test]
fn solids_vanish_where_they_should() {
    let on_egg = DVec3::new(0.9 * 0.48, 0.6 * 0.6, 0.4 * 0.64);
    assert!(egg(on_egg).abs() < 1e-12);
    assert!(egg(DVec3::ZERO) < 0.0);
    let limb = tapered(DVec3::new(2.0, 0.25, 0.0), [DVec3::X, 3.0 * DVec3::X], [0.3, 0.2]);
    assert!(limb.abs() < 1e-12);
    // A fillet only adds, by at most k / 4, and ends where the two differ by k.
    assert_eq!(smooth_union(0.3, 0.5, 0.2), 0.3);
    assert!((smooth_union(0.3, 0.3, 0.2) - 0.25).abs() < 1e-12);
    let turned = untilt(DVec3::new(0.5, 2.0 + 3.0, 1.0 + 4.0), DVec3::new(0.0, 2.0, 1.0), 0.75);
    assert!(turned.distance(DVec3::new(0.5, 2.0, 6.0)) < 1e-12, "{turned}");
}

#[test]
fn projection_goes_along_the_gradient() {
    let start = DVec3::new(0.5, 0.45, 0.3);
    let landed = project(egg, start);
    assert!(egg(landed).abs() < 1e-12);
    assert!(gradient(egg, landed).angle_between(start - landed) < 0.2);
}

#[test]
fn noise_is_bounded_smooth_and_zero_at_integers() {
    let mut extreme: f64 = 0.0;
    for i in -100..100 {
        assert_eq!(noise(DVec2::new(f64::from(i), f64::from(3 * i)), 7), 0.0);
        for k in -100..100 {
            let p = DVec2::new(f64::from(i), f64::from(k)) * 0.137;
            let value = noise(p, 7);
            extreme = extreme.max(value.abs());
            assert!((noise(p + DVec2::splat(1e-6), 7) - value).abs() < 1e-5);
        }
    }
    assert!((0.5..=1.1).contains(&extreme), "{extreme}");
    let p = DVec2::new(0.3, 0.8);
    assert_eq!(fractal(p, 3, 2), noise(p, 3) + 0.5 * noise(p * 2.0, 4));
    assert!(noise(p, 3) != noise(p, 4));
}

#[test]
fn topology_counts_known_defects() {
    let good = Topology::of(&tank());
    assert!(good.is_closed_manifold() && good.components == 1);

    let mut open = tank();
    open.triangles.pop();
    let counted = Topology::of(&open);
    assert_eq!((counted.boundary_edges, counted.boundary_loops), (3, 1));

    let mut turned = tank();
    turned.triangles[5].swap(0, 1);
    assert_eq!(Topology::of(&turned), Topology { flipped_edges: 3, ..good });

    let mut copied = tank();
    copied.triangles.push(copied.triangles[0]);
    let expected = Topology { nonmanifold_edges: 3, duplicate_triangles: 1, ..good };
    assert_eq!(Topology::of(&copied), expected);

    // Two cubes that share a corner, and a vertex that nothing uses.
    let mut pinched = tank();
    let (other, shift) = (tank(), 8 - 1);
    pinched.vertices.extend(other.vertices[1..].iter().map(|&v| v + DVec3::splat(9.0)));
    let index = |v: u32| if v == 0 { 7 } else { v + shift };
    pinched.triangles.extend(other.triangles.iter().map(|t| t.map(index)));
    pinched.push(DVec3::ZERO);
    let expected = Topology { nonmanifold_vertices: 1, unused_vertices: 1, ..good };
    assert_eq!(Topology::of(&pinched), expected);
}
