//! Distances to the surface of the union of overlapping parts, against closed forms and points spread over the parts'
//! surfaces.

use glam::{DMat3, DVec3};
use volmap_bake::mesh::diagnose;
use volmap_bake::sdf::{MeshDistance, SignMethod, brute_force};
use volmap_formats::mesh::TriangleMesh;

use crate::distance::distance_to;
use crate::shapes::{Random, cuboid, flipped, icosphere, merged, moved};

/// A box, turned about its centre.
#[derive(Clone, Copy)]
struct Solid {
    centre: DVec3,
    half: DVec3,
    turn: DMat3,
}

impl Solid {
    fn new(lower: DVec3, upper: DVec3) -> Solid {
        Solid { centre: 0.5 * (lower + upper), half: 0.5 * (upper - lower), turn: DMat3::IDENTITY }
    }

    fn mesh(&self) -> TriangleMesh {
        let mut mesh = cuboid(-self.half, self.half);
        mesh.vertices.iter_mut().for_each(|v| *v = (self.centre + self.turn * DVec3::from(*v)).to_array());
        mesh
    }

    /// How deep inside a point is; negative outside.
    fn depth(&self, p: DVec3) -> f64 {
        (self.half - (self.turn.transpose() * (p - self.centre)).abs()).min_element()
    }

    /// Points on its faces, `n` along each edge.
    fn spread(&self, n: usize) -> Vec<DVec3> {
        let mut points = Vec::new();
        for axis in 0..3 {
            for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
                let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
                for side in [-1.0, 1.0] {
                    let mut unit = DVec3::ZERO;
                    (unit[axis], unit[(axis + 1) % 3], unit[(axis + 2) % 3]) = (side, at(i), at(j));
                    points.push(self.centre + self.turn * (unit * self.half));
                }
            }
        }
        points
    }
}

fn distance_to_solids(solids: &[Solid]) -> MeshDistance {
    distance_to(&merged(&solids.iter().map(Solid::mesh).collect::<Vec<_>>()))
}

/// The distance of the union is that to the points of all faces that lie in no solid, and its sign that of the
/// solids' own.
fn assert_union(solids: &[Solid], seed: u64) {
    const N: usize = 40;
    let distance = distance_to_solids(solids);
    let on_surface: Vec<DVec3> = solids
        .iter()
        .flat_map(|solid| solid.spread(N))
        .filter(|p| solids.iter().all(|solid| solid.depth(*p) < 1e-9))
        .collect();
    let spacing = solids.iter().map(|solid| solid.half.max_element() * 2.0 / N as f64).fold(0.0, f64::max);
    let mut random = Random::new(seed);
    for _ in 0..200 {
        let p = DVec3::from([(); 3].map(|()| 3.0 * random.unit() - 1.0));
        let expected = on_surface.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
        let found = distance.signed_distance(p);
        let depth = solids.iter().map(|solid| solid.depth(p)).fold(f64::NEG_INFINITY, f64::max);
        // Spread points are never nearer than the surface, and miss it by their spacing at most.
        assert!(found.abs() <= expected + 1e-9, "{p}: {found}, {expected}");
        assert!(found.abs() >= expected - 1.1 * spacing, "{p}: {found}, {expected}");
        assert_eq!(found < 0.0, depth > 0.0, "{p}: {found}, {depth}");
        if depth < 0.0 {
            // Outside, it is the distance to the nearest of the solids, in closed form.
            let outside = |solid: &Solid| {
                let local = (solid.turn.transpose() * (p - solid.centre)).abs() - solid.half;
                local.max(DVec3::ZERO).length()
            };
            let nearest = solids.iter().map(outside).fold(f64::INFINITY, f64::min);
            assert!((found - nearest).abs() < 1e-9, "{p}: {found}, {nearest}");
        }
    }
}

#[test]
fn crossing_boxes_have_the_distance_of_their_union() {
    let boxes = [
        Solid::new(DVec3::ZERO, DVec3::ONE),
        Solid::new(DVec3::new(0.5, 0.25, 0.25), DVec3::new(2.5, 0.75, 0.75)),
    ];
    assert_union(&boxes, 1);
    let distance = distance_to_solids(&boxes);
    // On the hidden part of the first box's face: a quarter from the second's walls.
    assert!((distance.signed_distance(DVec3::new(1.0, 0.5, 0.5)) + 0.25).abs() < 1e-12);
    assert!((distance.volume() - (1.0 + 2.0 * 0.25 - 0.5 * 0.25)).abs() < 1e-12);
    assert_eq!(distance.overlaps().hidden, 12);
    assert!((distance.overlaps().hidden_area - 1.5).abs() < 1e-12);
    assert!(distance.overlaps().certain);
}

#[test]
fn boxes_with_faces_in_one_plane_are_one_box() {
    let whole = distance_to(&cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)));
    // Overlapping, touching in a face, and the same twice.
    for (end, start) in [(1.25, 0.75), (1.0, 1.0), (2.0, 0.0)] {
        let left = Solid::new(DVec3::ZERO, DVec3::new(end, 1.0, 1.0));
        let right = Solid::new(DVec3::new(start, 0.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
        let both = distance_to_solids(&[left, right]);
        let mut random = Random::new(2);
        for _ in 0..500 {
            let p = DVec3::from([(); 3].map(|()| 3.0 * random.unit() - 1.0));
            let (found, expected) = (both.signed_distance(p), whole.signed_distance(p));
            assert!((found - expected).abs() < 1e-12, "{end} {start} {p}: {found}, {expected}");
        }
        assert!((both.volume() - 2.0).abs() < 1e-12, "{end} {start}: {}", both.volume());
    }
}

#[test]
fn a_face_that_only_part_of_another_covers_is_cut() {
    // The second box stands on the middle of the first one's side; edges of the two meet nowhere.
    assert_union(
        &[
            Solid::new(DVec3::ZERO, DVec3::ONE),
            Solid::new(DVec3::new(1.0, 0.25, 0.25), DVec3::new(1.5, 0.75, 0.75)),
        ],
        3,
    );
}

#[test]
fn turned_boxes_that_cross_have_the_distance_of_their_union() {
    let mut random = Random::new(4);
    for seed in 0..12 {
        let solids: Vec<Solid> = (0..3)
            .map(|_| {
                let mut vector = |scale: f64| DVec3::from([(); 3].map(|()| scale * random.unit()));
                let (centre, half, axis) = (vector(1.0), 0.2 + vector(0.4), vector(1.0).normalize());
                Solid { centre, half, turn: DMat3::from_axis_angle(axis, 6.0 * random.unit()) }
            })
            .collect();
        assert_union(&solids, seed);
    }
}

#[test]
fn copies_within_rounding_and_micrometres_count_once() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    for shift in [1e-6, 1e-3] {
        let twice = distance_to(&merged(&[cube.clone(), moved(cube.clone(), 1.0, DVec3::splat(shift))]));
        let expected = 2.0 - (1.0 - shift).powi(3);
        assert!((twice.volume() - expected).abs() < 1e-12, "{shift}: {}", twice.volume());
        assert!((twice.signed_distance(DVec3::splat(0.5)) + 0.5).abs() < 1e-12);
    }
}

#[test]
fn nested_solids_are_hidden_and_hollows_are_not() {
    let (outer, inner) = (icosphere(2), moved(icosphere(2), 0.5, DVec3::ZERO));
    let nested = distance_to(&merged(&[outer.clone(), inner.clone()]));
    assert_eq!(nested.overlaps().hidden, inner.triangles.len());
    let alone = distance_to(&outer);
    for p in [DVec3::ZERO, DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.1, -0.4, 0.3)] {
        assert_eq!(nested.signed_distance(p), alone.signed_distance(p));
    }
    let hollow = distance_to(&merged(&[outer, flipped(inner)]));
    assert!(hollow.union_surface().is_none());
    assert!(hollow.signed_distance(DVec3::ZERO) > 0.4);
}

#[test]
fn surfaces_that_do_not_overlap_are_left_alone() {
    for mesh in [icosphere(3), merged(&[icosphere(1), moved(icosphere(1), 1.0, DVec3::new(3.0, 0.0, 0.0))])] {
        let distance = distance_to(&mesh);
        assert_eq!(distance.overlaps().pairs, 0);
        assert!(distance.union_surface().is_none());
        assert!(distance.union_mesh().is_none());
    }
}

#[test]
fn many_balls_have_the_volume_of_their_union() {
    // Two balls of radius 1 at a distance of 1: each loses a cap of height 1/2, in closed form.
    let fine = icosphere(4);
    let pair = distance_to(&merged(&[fine.clone(), moved(fine, 1.0, DVec3::new(1.0, 0.003, 0.001))]));
    let cap = std::f64::consts::PI * 0.25 * (3.0 - 0.5) / 3.0;
    let expected = 2.0 * 4.0 / 3.0 * std::f64::consts::PI - 2.0 * cap;
    assert!((pair.volume() / expected - 1.0).abs() < 5e-3, "{} {expected}", pair.volume());
    let mesh = pair.union_mesh().unwrap();
    // The pieces close up: area vectors have no sum.
    let sum: DVec3 = crate::shapes::corners(&mesh).iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).sum();
    assert!(sum.length() < 1e-10, "{sum}");
}

#[test]
fn in_an_open_mesh_only_what_surely_lies_inside_is_left_out() {
    let mut first = cuboid(DVec3::ZERO, DVec3::ONE);
    // Without half of a side.
    first.triangles.remove(0);
    let mesh = merged(&[first, cuboid(DVec3::new(0.8, 0.3, 0.3), DVec3::new(1.8, 0.7, 0.7))]);
    let distance = MeshDistance::new(&mesh, SignMethod::Auto, &diagnose(&mesh));
    assert!(!distance.overlaps().certain && distance.overlaps().pairs > 0);
    // Far from the hole, the far box's end in the first is hidden.
    assert!(distance.overlaps().hidden > 0);
    assert!(distance.unsigned_distance(DVec3::new(0.8, 0.5, 0.5)) > 0.15);
}

/// Few hidden triangles among many: the tree is changed in its leaves, not built anew.
#[test]
fn a_large_mesh_with_a_small_overlap_has_the_distance_of_its_union() {
    let ball = icosphere(5);
    for (size, at) in [(0.02, 1.0), (0.2, 0.99), (0.004, 0.998)] {
        let peg = Solid {
            centre: DVec3::new(at, 0.01, 0.02),
            half: DVec3::splat(size),
            turn: DMat3::from_rotation_y(0.3),
        };
        let mesh = merged(&[ball.clone(), peg.mesh()]);
        let distance = distance_to(&mesh);
        assert!(distance.overlaps().hidden > 0);
        let surface = distance.union_mesh().unwrap();
        let triangles = crate::shapes::corners(&surface);
        let mut random = Random::new(5);
        for k in 0..600 {
            let spread = if k % 2 == 0 { 3.0 * size } else { 2.0 };
            let p = peg.centre + DVec3::from([(); 3].map(|()| spread * (random.unit() - 0.5)));
            let (found, expected) = (distance.closest(p), brute_force::closest(&triangles, p));
            let (found, expected) = (found.distance_squared.sqrt(), expected.distance_squared.sqrt());
            assert!((found - expected).abs() < 1e-13, "{size} {p}: {found} {expected}");
        }
    }
}

/// An open cup, a pole that stands in it and far out of it, and a bar through the cup's wall: the pole's triangles are
/// in the cup in part only.
#[test]
fn what_stands_out_of_an_open_mesh_is_kept() {
    let mut cup = cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    cup.triangles.retain(|t| !t.iter().all(|&v| cup.vertices[v as usize][2] == 1.0));
    let pole = cuboid(DVec3::new(-0.1, -0.1, -0.5), DVec3::new(0.1, 0.1, 3.0));
    let bar = cuboid(DVec3::new(0.9, -0.05, -0.05), DVec3::new(1.2, 0.05, 0.05));
    let mesh = merged(&[cup, pole.clone(), bar]);
    let distance = MeshDistance::new(&mesh, SignMethod::Auto, &diagnose(&mesh));
    assert!(!distance.overlaps().certain && distance.overlaps().pairs > 0);
    let alone = distance_to(&pole);
    for p in [DVec3::new(0.2, 0.0, 2.9), DVec3::new(0.0, 0.0, 2.8), DVec3::new(0.0, -0.3, 2.0)] {
        assert!((distance.signed_distance(p) - alone.signed_distance(p)).abs() < 1e-12, "{p}");
    }
}
