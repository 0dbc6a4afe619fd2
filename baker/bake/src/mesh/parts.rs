//! A mesh split into parts, with area, volume and bounds of each.

use glam::DVec3;
use serde::Serialize;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::topology::{HalfEdge, Topology};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Lowest coordinates.
    pub lower: [f64; 3],
    /// Highest coordinates.
    pub upper: [f64; 3],
}

impl Bounds {
    /// The box around nothing: from infinity to minus infinity.
    pub const EMPTY: Bounds = Bounds { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    /// Extends the box to a point.
    pub fn grow(&mut self, point: DVec3) {
        self.lower = DVec3::from(self.lower).min(point).to_array();
        self.upper = DVec3::from(self.upper).max(point).to_array();
    }

    /// The box around both.
    pub fn joined(&self, other: &Bounds) -> Bounds {
        Bounds {
            lower: DVec3::from(self.lower).min(DVec3::from(other.lower)).to_array(),
            upper: DVec3::from(self.upper).max(DVec3::from(other.upper)).to_array(),
        }
    }

    /// True where the boxes have a point in common.
    pub fn overlaps(&self, other: &Bounds) -> bool {
        (0..3).all(|i| self.lower[i] <= other.upper[i] && other.lower[i] <= self.upper[i])
    }

    /// True where `other` lies in this box.
    pub fn contains(&self, other: &Bounds) -> bool {
        (0..3).all(|i| self.lower[i] <= other.lower[i] && other.upper[i] <= self.upper[i])
    }
}

/// What is known of one part.
#[derive(Clone, Debug)]
pub struct MeshPart {
    /// Surface area.
    pub area: f64,
    /// Signed volume; means nothing where the part isn't `balanced`.
    pub volume: f64,
    /// Its box.
    pub bounds: Bounds,
    /// Each of its edges is run through as often one way as the other, so that its winding number is
    /// an integer everywhere.
    pub balanced: bool,
}

/// The parts of a mesh.
#[derive(Clone, Debug)]
pub struct Parts {
    /// What is known of each.
    pub list: Vec<MeshPart>,
    order: Vec<u32>,
    starts: Vec<usize>,
}

impl Parts {
    /// Splits by `label`, one number below `count` for each triangle.
    pub fn new(mesh: &TriangleMesh, topology: &Topology, label: &[u32], count: usize) -> Parts {
        let (order, starts) = group(label, count);
        let balanced = balanced_parts(topology, label, count);
        let list = (0..count).map(|i| measure(mesh, &order[starts[i]..starts[i + 1]], balanced[i])).collect();
        Parts { list, order, starts }
    }

    /// Follows the mesh where all triangles of parts are turned.
    pub fn turn(&mut self, turned: &[bool]) {
        for (part, _) in self.list.iter_mut().zip(turned).filter(|(_, turned)| **turned) {
            part.volume = -part.volume;
        }
    }

    /// The triangles of part `i`, in the order of the mesh.
    pub fn triangles(&self, i: usize) -> &[u32] {
        &self.order[self.starts[i]..self.starts[i + 1]]
    }
}

/// Positions of a triangle's corners.
pub fn corners(mesh: &TriangleMesh, triangle: usize) -> [DVec3; 3] {
    mesh.triangles[triangle].map(|v| DVec3::from(mesh.vertices[v as usize]))
}

/// Members of each group, by a counting sort.
fn group(label: &[u32], count: usize) -> (Vec<u32>, Vec<usize>) {
    let mut starts = vec![0; count + 1];
    for &l in label {
        starts[l as usize + 1] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut order = vec![0; label.len()];
    for (triangle, &l) in label.iter().enumerate() {
        order[next[l as usize]] = triangle as u32;
        next[l as usize] += 1;
    }
    (order, starts)
}

fn balanced_parts(topology: &Topology, label: &[u32], count: usize) -> Vec<bool> {
    let mut balanced = vec![true; count];
    // Sides of an edge by part.
    let mut sides: Vec<(u32, HalfEdge)> = Vec::new();
    for edge in topology.edges() {
        if edge.sides.len() == 2 && surplus(edge.sides.iter().copied()) == 0 && same_part(edge.sides, label) {
            continue;
        }
        sides.clear();
        sides.extend(edge.sides.iter().map(|&half| (label[half.face()], half)));
        sides.sort_unstable();
        for part in sides.chunk_by(|a, b| a.0 == b.0) {
            balanced[part[0].0 as usize] &= surplus(part.iter().map(|&(_, half)| half)) == 0;
        }
    }
    balanced
}

fn same_part(sides: &[HalfEdge], label: &[u32]) -> bool {
    sides.iter().all(|half| label[half.face()] == label[sides[0].face()])
}

/// How much more often an edge is run through forwards than backwards.
pub fn surplus(half_edges: impl Iterator<Item = HalfEdge>) -> i64 {
    half_edges.map(|half| if half.forward() { 1 } else { -1 }).sum()
}

fn measure(mesh: &TriangleMesh, triangles: &[u32], balanced: bool) -> MeshPart {
    // Volumes are taken from a point of the part, for accuracy far from the origin.
    let origin = corners(mesh, triangles[0] as usize)[0];
    let mut bounds = Bounds::EMPTY;
    let (mut area, mut volume) = (0.0, 0.0);
    for &triangle in triangles {
        let absolute = corners(mesh, triangle as usize);
        absolute.iter().for_each(|&corner| bounds.grow(corner));
        let [a, b, c] = absolute.map(|corner| corner - origin);
        area += 0.5 * (b - a).cross(c - a).length();
        volume += a.dot(b.cross(c)) / 6.0;
    }
    MeshPart { area, volume, bounds, balanced }
}
