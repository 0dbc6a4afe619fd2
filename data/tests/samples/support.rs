//! Reads the committed meshes and measures them, by other means than those that made them.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::{DVec3, IVec3};
use volmap_data::mesh::Mesh;

/// The text of a file in `data/`.
pub fn text(file: &str) -> String {
    let path = format!("{}/{file}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// A committed mesh: `v x y z` and `f a b c` lines after comments.
pub fn read(file: &str) -> Mesh {
    let mut mesh = Mesh::default();
    for line in text(file).lines().filter(|line| !line.starts_with('#')) {
        let (kind, rest) = line.split_once(' ').expect("a word and numbers");
        let mut numbers = rest.split(' ').map(|n| n.parse::<f64>().expect("a number"));
        let three = [(); 3].map(|()| numbers.next().expect("three numbers"));
        assert!(numbers.next().is_none());
        match kind {
            "v" => mesh.vertices.push(DVec3::from(three)),
            "f" => mesh.triangles.push(three.map(|n| n as u32 - 1)),
            _ => panic!("{line}"),
        }
    }
    mesh
}

/// The smallest angle of each triangle, degrees.
pub fn min_angles(mesh: &Mesh) -> Vec<f64> {
    let smallest = |t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(*t);
        let angle = |p: DVec3, q: DVec3, r: DVec3| (q - p).angle_between(r - p).to_degrees();
        angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
    };
    mesh.triangles.iter().map(smallest).collect()
}

/// The largest angle between the normals of two triangles that share an edge of a closed mesh, degrees.
pub fn sharpest_fold(mesh: &Mesh) -> f64 {
    let sides = directed_edges(mesh);
    let normal = |triangle: usize| {
        let [a, b, c] = mesh.corners(mesh.triangles[triangle]);
        (b - a).cross(c - a)
    };
    let fold = |(&[a, b], s): (&[u32; 2], &Vec<usize>)| normal(s[0]).angle_between(normal(sides[&[b, a]][0]));
    sides.iter().map(fold).fold(0.0, f64::max).to_degrees()
}

/// The triangles that run along each edge from its first to its second end.
fn directed_edges(mesh: &Mesh) -> BTreeMap<[u32; 2], Vec<usize>> {
    let mut sides: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (i, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        for edge in [[a, b], [b, c], [c, a]] {
            sides.entry(edge).or_default().push(i);
        }
    }
    sides
}

/// The number of pairs of an edge and a triangle without a common vertex that pierce each other. Where two
/// triangles of a mesh intersect other than at shared vertices, an edge of one pierces the other.
pub fn intersections(mesh: &Mesh) -> usize {
    let edge_lengths = directed_edges(mesh).into_keys().map(|e| {
        let [a, b] = e.map(|v| mesh.vertices[v as usize]);
        a.distance(b)
    });
    let (sum, count) = edge_lengths.fold((0.0, 0.0), |(sum, count), length| (sum + length, count + 1.0));
    let cell = 2.0 * sum / count;

    let mut buckets: HashMap<IVec3, Vec<usize>> = HashMap::new();
    for (i, &t) in mesh.triangles.iter().enumerate() {
        for key in cells(&mesh.corners(t), cell) {
            buckets.entry(key).or_default().push(i);
        }
    }
    let mut found = BTreeSet::new();
    for [a, b] in directed_edges(mesh).into_keys() {
        let ends = [a, b].map(|v| mesh.vertices[v as usize]);
        for i in cells(&ends, cell).filter_map(|key| buckets.get(&key)).flatten() {
            let t = mesh.triangles[*i];
            if !t.contains(&a) && !t.contains(&b) && pierces(ends, mesh.corners(t)) {
                found.insert((a.min(b), a.max(b), *i));
            }
        }
    }
    found.len()
}

/// The cells of a cubic lattice that the points' box overlaps.
fn cells(points: &[DVec3], cell: f64) -> impl Iterator<Item = IVec3> + use<> {
    let low = points.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    let (low, high) = ((low / cell).floor().as_ivec3(), (high / cell).floor().as_ivec3());
    (low.z..=high.z).flat_map(move |z| {
        (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec3::new(x, y, z)))
    })
}

fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let side = |u: DVec3, v: DVec3, w: DVec3, x: DVec3| (v - u).cross(w - u).dot(x - u);
    let across = side(a, b, c, p) * side(a, b, c, q) < 0.0;
    let around = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    across && (around.iter().all(|&s| s > 0.0) || around.iter().all(|&s| s < 0.0))
}

/// The edges without a second triangle, from end to start: walking them keeps the hole on the left.
fn hole_edges(mesh: &Mesh) -> BTreeMap<u32, u32> {
    let sides = directed_edges(mesh);
    let count = |e: &[u32; 2]| sides.get(e).map_or(0, Vec::len);
    sides.keys().filter(|&&[a, b]| count(&[a, b]) + count(&[b, a]) == 1).map(|&[a, b]| (b, a)).collect()
}

/// The closed loops of boundary edges, each as the vertices in turn.
fn holes(mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut next = hole_edges(mesh);
    let mut holes = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut ring = vec![start];
        while at != start {
            ring.push(at);
            let Some(further) = next.remove(&at) else {
                break;
            };
            at = further;
        }
        if at == start {
            holes.push(ring);
        }
    }
    holes
}

/// Numbers of edges of the closed boundary loops, ascending.
pub fn boundary_loop_lengths(mesh: &Mesh) -> Vec<usize> {
    let mut lengths: Vec<usize> = holes(mesh).iter().map(Vec::len).collect();
    lengths.sort_unstable();
    lengths
}

/// How many triangles run along each edge of a triangle: in its own direction, and in either.
fn edge_counts(mesh: &Mesh) -> Vec<[(usize, usize); 3]> {
    let sides = directed_edges(mesh);
    let count = |a: u32, b: u32| sides.get(&[a, b]).map_or(0, Vec::len);
    let both = |[a, b]: [u32; 2]| (count(a, b), count(a, b) + count(b, a));
    mesh.triangles.iter().map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(both)).collect()
}

/// The triangles that disagree in orientation with each of their three neighbours.
pub fn turned(mesh: &Mesh) -> Vec<usize> {
    let counts = edge_counts(mesh);
    (0..counts.len()).filter(|&i| counts[i] == [(2, 2); 3]).collect()
}

/// The triangles that hang on an edge of two others, with both other edges free.
pub fn fins(mesh: &Mesh) -> Vec<usize> {
    let is_fin = |edges: &[(usize, usize); 3]| {
        let number = |n: usize| edges.iter().filter(|(_, both)| *both == n).count();
        number(1) == 2 && number(3) == 1
    };
    let counts = edge_counts(mesh);
    (0..counts.len()).filter(|&i| is_fin(&counts[i])).collect()
}

/// The triangles with the same vertices as an earlier one.
pub fn copies(mesh: &Mesh) -> Vec<usize> {
    let mut seen = BTreeSet::new();
    let mut is_copy = |i: &usize| {
        let mut key = mesh.triangles[*i];
        key.sort_unstable();
        !seen.insert(key)
    };
    (0..mesh.triangles.len()).filter(|i| is_copy(i)).collect()
}

/// Turns triangles that disagree with all of their neighbours, drops fins and copies, closes holes by fans.
pub fn repair(mesh: &mut Mesh) {
    for i in turned(mesh) {
        mesh.triangles[i].swap(1, 2);
    }
    let mut dropped = [fins(mesh), copies(mesh)].concat();
    dropped.sort_unstable();
    for i in dropped.into_iter().rev() {
        mesh.triangles.remove(i);
    }
    mesh.compact();
    for ring in holes(mesh) {
        let sum: DVec3 = ring.iter().map(|&v| mesh.vertices[v as usize]).sum();
        let middle = mesh.push(sum / ring.len() as f64);
        for (i, &from) in ring.iter().enumerate() {
            mesh.triangles.push([middle, from, ring[(i + 1) % ring.len()]]);
        }
    }
}
