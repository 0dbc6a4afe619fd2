//! The rims of a mesh's holes: its boundary edges, taken apart into loops.

use glam::DVec3;
use serde::Serialize;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::parts::Bounds;
use crate::mesh::topology::Topology;

/// The rim of a hole.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundaryLoop {
    /// Number of edges.
    pub edges: usize,
    /// Sum of their lengths.
    pub length: f64,
    /// Mean of the edges' middles, weighted by length.
    pub centroid: [f64; 3],
    /// The loop's box.
    pub bounds: Bounds,
}

/// All boundary loops, the longest first. Each passes a vertex once: loops that touch are apart.
pub fn boundary_loops(mesh: &TriangleMesh, topology: &Topology) -> Vec<BoundaryLoop> {
    let edges: Vec<[u32; 2]> =
        topology.edges().filter(|edge| edge.sides.len() == 1).map(|edge| edge.ends).collect();
    let mut loops: Vec<BoundaryLoop> = simple_loops(&edges)
        .iter()
        .map(|members| measure(mesh, members.iter().map(|&edge| edges[edge])))
        .collect();
    loops.sort_by(|a, b| b.length.total_cmp(&a.length));
    loops
}

/// Edges at each vertex, and which of them have been walked.
struct Walk<'a> {
    edges: &'a [[u32; 2]],
    /// Vertex and edge, sorted.
    incidences: Vec<(u32, usize)>,
    /// For each vertex, its first incidence whose edge may not have been walked.
    next: Vec<usize>,
    walked: Vec<bool>,
}

impl Walk<'_> {
    /// Takes the first edge at `vertex` that hasn't been walked, and returns it and its other end.
    fn step(&mut self, vertex: u32) -> Option<(usize, u32)> {
        let next = &mut self.next[vertex as usize];
        while let Some(&(_, edge)) = self.incidences.get(*next).filter(|i| i.0 == vertex)
            && self.walked[edge]
        {
            *next += 1;
        }
        let &(_, edge) = self.incidences.get(*next).filter(|i| i.0 == vertex)?;
        self.walked[edge] = true;
        let [a, b] = self.edges[edge];
        Some((edge, if a == vertex { b } else { a }))
    }
}

/// Walks along the edges and cuts a loop off whenever the way crosses itself. A way that ends, as can
/// happen where edges have three faces, counts as a loop too.
fn simple_loops(edges: &[[u32; 2]]) -> Vec<Vec<usize>> {
    let mut incidences: Vec<(u32, usize)> =
        edges.iter().enumerate().flat_map(|(i, edge)| edge.map(|v| (v, i))).collect();
    incidences.sort_unstable();
    let highest = edges.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    let mut next = vec![0; highest];
    for (k, &(vertex, _)) in incidences.iter().enumerate().rev() {
        next[vertex as usize] = k;
    }
    let mut walk = Walk { edges, incidences, next, walked: vec![false; edges.len()] };
    const NOT_ON_WAY: usize = usize::MAX;
    let mut place_on_way = vec![NOT_ON_WAY; highest];
    let mut loops = Vec::new();
    for start in edges.iter().map(|edge| edge[0]) {
        // The way so far: vertices, and the edges between them.
        let (mut vertices, mut way) = (vec![start], Vec::new());
        place_on_way[start as usize] = 0;
        while let Some((edge, next)) = walk.step(vertices[vertices.len() - 1]) {
            way.push(edge);
            let place = place_on_way[next as usize];
            if place == NOT_ON_WAY {
                place_on_way[next as usize] = vertices.len();
                vertices.push(next);
            } else {
                loops.push(way.split_off(place));
                for vertex in vertices.drain(place + 1..) {
                    place_on_way[vertex as usize] = NOT_ON_WAY;
                }
            }
        }
        vertices.iter().for_each(|&vertex| place_on_way[vertex as usize] = NOT_ON_WAY);
        if !way.is_empty() {
            loops.push(way);
        }
    }
    loops
}

fn measure(mesh: &TriangleMesh, edges: impl Iterator<Item = [u32; 2]>) -> BoundaryLoop {
    let mut bounds = Bounds::EMPTY;
    let (mut count, mut length) = (0, 0.0);
    let (mut weighted, mut first) = (DVec3::ZERO, DVec3::ZERO);
    for edge in edges {
        let [a, b] = edge.map(|v| DVec3::from(mesh.vertices[v as usize]));
        bounds.grow(a);
        bounds.grow(b);
        if count == 0 {
            first = a;
        }
        count += 1;
        length += a.distance(b);
        weighted += a.distance(b) * ((a - first) * 0.5 + (b - first) * 0.5);
    }
    BoundaryLoop {
        edges: count,
        length,
        centroid: (first + weighted / length.max(f64::MIN_POSITIVE)).to_array(),
        bounds,
    }
}
