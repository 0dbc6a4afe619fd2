//! A duck with known damage, to test what diagnoses and repairs meshes.

use glam::DVec3;

use crate::duck::duck_of_cell;
use crate::mesh::Mesh;

/// The damage, place by place; the places are far enough apart not to share a vertex.
///
/// Three holes: one triangle (in the chest), one vertex with its triangles (in the head), and all triangles
/// with a vertex within 0.16 m of a point (in the back). Four triangles turned over, one triangle listed
/// twice, and one triangle that stands on an edge of the surface like a fin.
pub fn bad_duck() -> Mesh {
    let mut mesh = duck_of_cell(0.055);
    for place in [[0.45, -0.3, 0.35], [-0.45, -0.3, 0.35], [0.3, -0.4, -0.4], [-0.3, -0.4, -0.4]] {
        let triangle = nearest_triangle(&mesh, DVec3::from(place));
        mesh.triangles[triangle].swap(1, 2);
    }
    let copy = mesh.triangles[nearest_triangle(&mesh, DVec3::new(0.0, -0.6, 0.0))];
    mesh.triangles.push(copy);
    add_fin(&mut mesh, DVec3::new(0.1, 0.45, -0.15));

    let chest = nearest_triangle(&mesh, DVec3::new(0.0, -0.25, 0.7));
    mesh.triangles.remove(chest);
    remove_vertex(&mut mesh, DVec3::new(0.35, 0.4, 0.1));
    let back = DVec3::new(0.0, 0.1, -0.4);
    let positions = mesh.vertices.clone();
    mesh.triangles.retain(|t| t.iter().all(|&v| positions[v as usize].distance(back) > 0.16));
    mesh.compact();
    mesh
}

/// The triangle whose middle is nearest to p.
fn nearest_triangle(mesh: &Mesh, p: DVec3) -> usize {
    let distance2 = |&t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(t);
        ((a + b + c) / 3.0).distance_squared(p)
    };
    let nearest = (0..mesh.triangles.len())
        .min_by(|&s, &t| distance2(&mesh.triangles[s]).total_cmp(&distance2(&mesh.triangles[t])));
    nearest.expect("the duck has triangles")
}

/// Removes the triangles around the vertex nearest to p.
fn remove_vertex(mesh: &mut Mesh, p: DVec3) {
    let distance2 = |v: &u32| mesh.vertices[*v as usize].distance_squared(p);
    let nearest = (0..mesh.vertices.len() as u32).min_by(|a, b| distance2(a).total_cmp(&distance2(b)));
    let vertex = nearest.expect("the duck has vertices");
    mesh.triangles.retain(|t| !t.contains(&vertex));
}

/// A triangle that stands upright on the second edge of the triangle nearest to p.
fn add_fin(mesh: &mut Mesh, p: DVec3) {
    let [c, a, b] = mesh.triangles[nearest_triangle(mesh, p)];
    let [pa, pb, pc] = mesh.corners([a, b, c]);
    let normal = (pb - pa).cross(pc - pa).normalize();
    let tip = mesh.push((pa + pb) * 0.5 + normal * 0.15);
    mesh.triangles.push([a, b, tip]);
}
