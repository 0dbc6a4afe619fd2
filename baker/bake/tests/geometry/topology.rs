use glam::DVec3;
use volmap_bake::mesh::crossings::winding_numbers;
use volmap_bake::mesh::diagnose;
use volmap_bake::mesh::fans::count_fans;
use volmap_bake::mesh::topology::Topology;
use volmap_bake::sdf::winding::solid_angle;
use volmap_formats::mesh::TriangleMesh;

use crate::shapes;

#[test]
fn closed_shapes_are_clean() {
    for (mesh, genus) in [
        (shapes::icosphere(2), 0),
        (shapes::torus(1.0, 0.4, 30, 20), 1),
        (shapes::l_shape(), 0),
        (shapes::cuboid(DVec3::ZERO, DVec3::ONE), 0),
    ] {
        let found = diagnose(&mesh);
        assert!(found.closed && found.oriented && found.balanced);
        assert!(found.manifold_edges && found.manifold_vertices && found.nesting_complete);
        assert_eq!((found.components, found.genus), (1, Some(genus)));
        assert_eq!(found.euler_characteristic, 2 - 2 * genus);
        assert_eq!(found.boundary_loop_count, 0);
        assert!(found.volume > 0.0);
    }
}

#[test]
fn measures_of_a_box() {
    let found = diagnose(&shapes::cuboid(DVec3::new(5.0, 0.0, -1.0), DVec3::new(7.0, 3.0, 3.0)));
    assert!((found.area - 2.0 * (6.0 + 12.0 + 8.0)).abs() < 1e-12);
    assert!((found.volume - 24.0).abs() < 1e-12);
    assert_eq!(found.bounds.lower, [5.0, 0.0, -1.0]);
    assert_eq!(found.bounds.upper, [7.0, 3.0, 3.0]);
    assert_eq!((found.vertices, found.edges, found.triangles), (8, 18, 12));
}

#[test]
fn open_cylinder_has_two_loops() {
    let found = diagnose(&shapes::open_cylinder(32, 3.0));
    assert!(!found.closed && found.oriented && found.manifold_edges && !found.balanced);
    assert_eq!(found.boundary_edges.count, 64);
    assert_eq!(found.boundary_edges.places.len(), 8);
    assert_eq!(found.boundary_loop_count, 2);
    let length = 64.0 * (std::f64::consts::PI / 32.0).sin();
    let mut heights = Vec::new();
    for rim in &found.boundary_loops {
        assert_eq!(rim.edges, 32);
        assert!((rim.length - length).abs() < 1e-12);
        assert!(DVec3::from(rim.centroid).truncate().length() < 1e-12);
        assert_eq!((rim.bounds.lower[0], rim.bounds.upper[0]), (-1.0, 1.0));
        heights.push(rim.centroid[2]);
    }
    heights.sort_by(f64::total_cmp);
    assert!(heights[0].abs() < 1e-12 && (heights[1] - 3.0).abs() < 1e-12);
}

/// Two holes that touch at one vertex are two loops, the larger first.
#[test]
fn loops_that_touch_stay_apart() {
    let mut mesh = TriangleMesh::default();
    let n = 6;
    for y in 0..=n {
        for x in 0..=n {
            mesh.vertices.push([f64::from(x), f64::from(y), 0.0]);
        }
    }
    for y in 0..n {
        for x in 0..n {
            let hole = (1..3).contains(&x) && (1..3).contains(&y) || (x, y) == (3, 3);
            if !hole {
                let a = (y * (n + 1) + x) as u32;
                let [b, c, d] = [a + 1, a + n as u32 + 2, a + n as u32 + 1];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    let found = diagnose(&mesh);
    let edges: Vec<usize> = found.boundary_loops.iter().map(|l| l.edges).collect();
    assert_eq!(edges, [24, 8, 4]);
    assert_eq!(found.boundary_loops[2].centroid, [3.5, 3.5, 0.0]);
    assert_eq!(found.non_manifold_vertices.places, [[3.0, 3.0, 0.0]]);
}

#[test]
fn edge_of_three_faces_is_found() {
    let vertices = vec![[0., 0., 0.], [0., 0., 1.], [1., 0., 0.], [0., 1., 0.], [-1., -1., 0.]];
    let triangles = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    let found = diagnose(&TriangleMesh { vertices, triangles });
    assert!(!found.manifold_edges && !found.closed);
    assert_eq!(found.non_manifold_edges.count, 1);
    assert_eq!(found.non_manifold_edges.places, [[0.0, 0.0, 0.5]]);
    assert_eq!(found.components, 1);
}

/// Cubes that share an edge have no two-faced surface there, but integer winding numbers.
#[test]
fn solids_that_share_an_edge_are_balanced() {
    let mut mesh = shapes::cuboid(DVec3::ZERO, DVec3::ONE);
    let other = shapes::cuboid(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 1.0));
    let offset = mesh.vertices.len() as u32;
    let welded = |v: u32| {
        let position = other.vertices[v as usize];
        let same = mesh.vertices.iter().position(|&p| p == position);
        same.map_or(v + offset, |v| v as u32)
    };
    let triangles: Vec<[u32; 3]> = other.triangles.iter().map(|t| t.map(welded)).collect();
    mesh.vertices.extend(&other.vertices);
    mesh.triangles.extend(triangles);
    let found = diagnose(&mesh);
    assert!(found.balanced && found.closed && !found.manifold_edges);
    assert_eq!(found.genus, None);
    assert_eq!((found.non_manifold_edges.count, found.vertices), (1, 14));
    assert_eq!(found.volume, 2.0);
}

#[test]
fn vertex_of_two_fans_is_found() {
    let mut mesh = shapes::merged(&[
        shapes::cuboid(DVec3::ZERO, DVec3::ONE),
        shapes::cuboid(DVec3::ONE, DVec3::splat(2.0)),
    ]);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = if *v == 8 { 7 } else { *v });
    let found = diagnose(&mesh);
    assert!(found.closed && !found.manifold_vertices);
    assert_eq!(found.non_manifold_vertices.places, [[1.0, 1.0, 1.0]]);
    assert_eq!((found.components, found.genus), (2, None));
}

#[test]
fn nesting_is_found() {
    let ball = |radius: f64| shapes::moved(shapes::icosphere(2), radius, DVec3::new(0.1, 0.0, 0.0));
    let hollow = diagnose(&shapes::merged(&[ball(1.0), shapes::flipped(ball(0.8))]));
    assert_eq!((hollow.cavities.count, hollow.nested_solids.count), (1, 0));
    let island = shapes::merged(&[ball(1.0), shapes::flipped(ball(0.8)), ball(0.5)]);
    let island = diagnose(&island);
    assert_eq!((island.cavities.count, island.nested_solids.count), (1, 0));
    assert_eq!(island.overlapping_boxes.count, 0);
    let solid = diagnose(&shapes::merged(&[ball(0.8), ball(1.0)]));
    assert_eq!((solid.cavities.count, solid.nested_solids.count), (0, 1));
    let apart = shapes::moved(ball(1.0), 1.0, DVec3::X * 1.5);
    let overlap = diagnose(&shapes::merged(&[ball(1.0), apart]));
    assert_eq!((overlap.overlapping_boxes.count, overlap.nested_solids.count), (1, 0));
    assert_eq!(diagnose(&shapes::flipped(ball(1.0))).inside_out_components.count, 1);
}

#[test]
fn flipped_triangle_and_zero_area_are_found() {
    let mut mesh = shapes::icosphere(1);
    mesh.triangles[7].swap(0, 1);
    let found = diagnose(&mesh);
    assert!(found.closed && !found.oriented && !found.balanced);
    assert_eq!(found.misoriented_edges.count, 3);
    let line = TriangleMesh {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
        triangles: vec![[0, 1, 2]],
    };
    assert_eq!(diagnose(&line).zero_area_triangles.count, 1);
}

#[test]
fn empty_mesh_has_a_diagnosis() {
    let found = diagnose(&TriangleMesh::default());
    assert_eq!((found.triangles, found.components), (0, 0));
}

/// Edges as a map finds them.
#[test]
fn edges_are_sorted_and_complete() {
    let mut mesh =
        shapes::merged(&[shapes::soup(50, 0.3, 1), shapes::icosphere(3), shapes::moebius_strip(9)]);
    // A hundred pages bound at one edge.
    let count = mesh.vertices.len() as u32;
    mesh.vertices.extend((0..100).map(|k| [f64::from(k), 1.0, 2.0]));
    mesh.triangles.extend((0..100).map(|k| [7, count + k, 1200 - k]));
    mesh.triangles.extend((0..100).map(|k| [count + k, 3, 5]));
    let mut expected = std::collections::BTreeMap::<[u32; 2], Vec<(usize, bool)>>::new();
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for side in 0..3 {
            let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
            expected.entry([from.min(to), from.max(to)]).or_default().push((3 * face + side, from < to));
        }
    }
    let topology = Topology::new(&mesh);
    let found = topology
        .edges()
        .map(|edge| (edge.ends, edge.sides.iter().map(|half| (half.corner(), half.forward())).collect()));
    assert!(found.eq(expected));
}

/// Fans as joining corners at edges finds them, by a slow search.
#[test]
fn fans_are_sets_of_corners_joined_at_edges() {
    // Two balls in one point, a book of three pages, a ball with a scrambled neighbourhood, a strip.
    let mut mesh = shapes::merged(&[
        shapes::icosphere(1),
        shapes::moved(shapes::icosphere(1), 1.0, DVec3::X * 2.0),
        shapes::moebius_strip(5),
    ]);
    let vertices = mesh.vertices.len() as u32;
    mesh.triangles.iter_mut().skip(80).take(80).flatten().filter(|v| **v == 42).for_each(|v| *v = 0);
    mesh.triangles.iter_mut().step_by(3).for_each(|t| t.swap(0, 2));
    mesh.vertices.extend([[9.0; 3]; 3]);
    mesh.triangles.extend((0..3).map(|k| [10, 15, vertices + k]));
    let found = count_fans(&mesh, &Topology::new(&mesh));
    for (vertex, &count) in found.iter().enumerate() {
        let mut groups: Vec<Vec<u32>> = Vec::new();
        for triangle in mesh.triangles.iter().filter(|t| t.contains(&(vertex as u32))) {
            let others = triangle.iter().copied().filter(|&v| v as usize != vertex).collect::<Vec<_>>();
            let (mut joined, apart): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|group| group.iter().any(|v| others.contains(v)));
            joined.push(others);
            groups = apart;
            groups.push(joined.concat());
        }
        assert_eq!(count as usize, groups.len(), "{vertex}");
    }
    assert_eq!(found[0], 2);
    assert_eq!((found[10], found[42]), (2, 0));
}

/// Winding numbers as the sum of solid angles gives them.
#[test]
fn crossings_count_what_solid_angles_sum() {
    let mesh = shapes::merged(&[
        shapes::icosphere(2),
        shapes::flipped(shapes::moved(shapes::torus(1.0, 0.4, 20, 10), 0.5, DVec3::ZERO)),
        shapes::moved(shapes::cuboid(DVec3::ZERO, DVec3::ONE), 0.5, DVec3::splat(0.2)),
    ]);
    let mut random = shapes::Random::knuth(7);
    let mut points: Vec<DVec3> =
        (0..300).map(|_| random.point(DVec3::splat(-1.1), DVec3::splat(1.1))).collect();
    // Rays along edges and through corners.
    points.extend(mesh.vertices.iter().map(|&v| DVec3::from(v) - DVec3::X * 0.4));
    points.extend(mesh.vertices.iter().map(|&v| DVec3::from(v) - DVec3::X * 3.0));
    let triangles: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let found = winding_numbers(&mesh, &triangles, &points).unwrap();
    let corners = shapes::corners(&mesh);
    let mut seen = std::collections::BTreeSet::new();
    for (point, turns) in points.iter().zip(found) {
        let angles: f64 = corners.iter().map(|corners| solid_angle(*point, corners)).sum();
        let exact = angles / (2.0 * std::f64::consts::TAU);
        // Of the points that aren't random, some are on the surface.
        let on_surface = (exact - exact.round()).abs() > 1e-3;
        assert!(on_surface || turns == Some(exact.round() as i64), "{point} {turns:?} {exact}");
        seen.insert(turns);
    }
    assert!([0, 1, 2].iter().all(|&turns| seen.contains(&Some(turns))), "{seen:?}");
    let corners: Vec<DVec3> = mesh.vertices.iter().map(|&v| DVec3::from(v)).collect();
    let on_surface = winding_numbers(&mesh, &triangles, &corners).unwrap();
    assert!(on_surface.iter().all(Option::is_none));
}

/// Long slivers hide every point: it's given up before it takes forever.
#[test]
fn crossings_of_slivers_are_given_up() {
    let mut mesh = TriangleMesh::default();
    for k in 0..5_000 {
        let x = f64::from(k);
        mesh.vertices.extend([[x, -1.0, -1.0], [x, 3.0, -1.0], [x, -1.0, 3.0]]);
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let triangles: Vec<u32> = (0..5_000).collect();
    let mut random = shapes::Random::knuth(1);
    let points: Vec<DVec3> = (0..5_000).map(|_| random.point(DVec3::ZERO, DVec3::ONE)).collect();
    assert_eq!(winding_numbers(&mesh, &triangles, &points), None);
    assert!(winding_numbers(&mesh, &triangles[..50], &points).is_some());
}
