//! Meshes made in code, all closed and oriented outwards unless their names say otherwise.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;
use volmap_formats::mesh::TriangleMesh;

pub use volmap_bake::random::Random;

pub fn corners(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    let position = |v: u32| DVec3::from(mesh.vertices[v as usize]);
    mesh.triangles.iter().map(|t| t.map(position)).collect()
}

pub fn merged(meshes: &[TriangleMesh]) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let offset = all.vertices.len() as u32;
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + offset)));
    }
    all
}

pub fn flipped(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

pub fn moved(mut mesh: TriangleMesh, scale: f64, by: DVec3) -> TriangleMesh {
    for v in &mut mesh.vertices {
        *v = (DVec3::from(*v) * scale + by).to_array();
    }
    mesh
}

/// A box, two triangles a side.
pub fn cuboid(lower: DVec3, upper: DVec3) -> TriangleMesh {
    let corner = |i: usize| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 1 { upper[axis] } else { lower[axis] }
        };
        [pick(0), pick(1), pick(2)]
    };
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    TriangleMesh {
        vertices: (0..8).map(corner).collect(),
        triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// An L of two unit squares' width, extruded from z = 0 to 1: the square [0, 2]^2 without (1, 2]^2.
pub fn l_shape() -> TriangleMesh {
    let outline = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
    let vertices = [0., 1.].iter().flat_map(|&z| outline.map(|[x, y]| [x, y, z]));
    let mut triangles = Vec::new();
    for cap in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.push([cap[0], cap[2], cap[1]]);
        triangles.push(cap.map(|v| v + 6));
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    TriangleMesh { vertices: vertices.collect(), triangles }
}

/// The unit sphere: an icosahedron whose faces are split in four, `level` times.
pub fn icosphere(level: usize) -> TriangleMesh {
    let t = (1.0 + 5f64.sqrt()) / 2.0;
    let mut vertices: Vec<DVec3> = Vec::new();
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        vertices.push(DVec3::new(a, b, 0.0));
    }
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        vertices.push(DVec3::new(0.0, a, b));
    }
    for (a, b) in [(t, -1.0), (t, 1.0), (-t, -1.0), (-t, 1.0)] {
        vertices.push(DVec3::new(a, 0.0, b));
    }
    #[rustfmt::skip]
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        triangles = split_in_four(&mut vertices, &triangles);
    }
    TriangleMesh { vertices: vertices.iter().map(|v| v.normalize().to_array()).collect(), triangles }
}

fn split_in_four(vertices: &mut Vec<DVec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let (p, q) = (vertices[a as usize].normalize(), vertices[b as usize].normalize());
            vertices.push(p + q);
            vertices.len() as u32 - 1
        })
    };
    let mut split = Vec::new();
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    split
}

/// A torus around the z axis, radii `major` and `minor`.
pub fn torus(major: f64, minor: f64, around: u32, along: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..around {
        for j in 0..along {
            let (u, v) = (f64::from(i) / f64::from(around) * TAU, f64::from(j) / f64::from(along) * TAU);
            let r = major + minor * v.cos();
            mesh.vertices.push([r * u.cos(), r * u.sin(), minor * v.sin()]);
            let at = |i: u32, j: u32| (i % around) * along + j % along;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A tube of unit radius from z = 0 to `height`, without its ends.
pub fn open_cylinder(around: u32, height: f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..around {
        let u = f64::from(i) / f64::from(around) * TAU;
        mesh.vertices.push([u.cos(), u.sin(), 0.0]);
        mesh.vertices.push([u.cos(), u.sin(), height]);
        let [a, b] = [2 * i, 2 * ((i + 1) % around)];
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh
}

/// A band with half a twist: one side, one rim.
pub fn moebius_strip(around: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..around {
        let u = f64::from(i) / f64::from(around) * TAU;
        for w in [-0.3, 0.3] {
            let r = 1.0 + w * (u / 2.0).cos();
            mesh.vertices.push([r * u.cos(), r * u.sin(), w * (u / 2.0).sin()]);
        }
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i + 1 < around { [a + 2, b + 2] } else { [1, 0] };
        mesh.triangles.extend([[a, c, d], [a, d, b]]);
    }
    mesh
}

/// A wedge of half angle atan(`slope`) with its edge on the z axis, opening towards +x.
pub fn wedge(slope: f64) -> TriangleMesh {
    let mut mesh = cuboid(DVec3::new(0., -1., -1.), DVec3::new(1., 1., 1.));
    for v in &mut mesh.vertices {
        v[1] *= if v[0] == 0.0 { 0.0 } else { slope };
    }
    // The side x = 0 has collapsed: its corners are welded and its triangles are gone.
    for v in mesh.triangles.iter_mut().flatten() {
        *v = match *v {
            2 => 0,
            6 => 4,
            other => other,
        };
    }
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    mesh
}

/// Triangles anywhere in the unit cube, of which some are slivers and some have no area.
pub fn soup(count: usize, size: f64, seed: u64) -> TriangleMesh {
    let mut random = Random::knuth(seed);
    let mut mesh = TriangleMesh::default();
    for i in 0..count as u32 {
        let a = random.point(DVec3::ZERO, DVec3::ONE);
        let mut offset = || random.point(DVec3::splat(-size), DVec3::splat(size));
        let (b, mut c) = (a + offset(), a + offset());
        if i % 7 == 0 {
            c = a + (b - a) * 0.4 + offset() * 1e-9;
        }
        if i % 11 == 0 {
            c = a + (b - a) * 2.0;
        }
        mesh.vertices.extend([a, b, c].map(|v| v.to_array()));
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}
