//! Edges, neighbours and connected parts of a mesh, by sorting.

use rayon::prelude::*;

/// In place of a neighbour: the edge has none, or more than one.
pub const NO_FACE: u32 = u32::MAX;

/// One side of a triangle: from its corner i to corner i + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HalfEdge {
    /// The lower vertex of the edge.
    pub lower: u32,
    /// The higher vertex of the edge.
    pub upper: u32,
    /// Face times four plus side, times two, plus 1 where the side runs from higher to lower vertex.
    code: u64,
}

impl HalfEdge {
    /// Index of the triangle.
    pub fn face(&self) -> usize {
        (self.code >> 3) as usize
    }

    /// Which of its sides: 0 to 2.
    pub fn side(&self) -> usize {
        (self.code >> 1 & 3) as usize
    }

    /// True where the triangle runs through the edge from the lower vertex to the higher.
    pub fn forward(&self) -> bool {
        self.code & 1 == 0
    }
}

/// All edges of a mesh.
#[derive(Clone, Debug)]
pub struct Topology {
    half_edges: Vec<HalfEdge>,
    /// Where each edge's half-edges start, and their number at the end.
    starts: Vec<u32>,
    face_count: usize,
}

impl Topology {
    /// Sorts the edges of the triangles; O(n log n).
    pub fn new(triangles: &[[u32; 3]]) -> Topology {
        let mut half_edges: Vec<HalfEdge> = triangles
            .iter()
            .enumerate()
            .flat_map(|(face, triangle)| (0..3).map(move |side| half_edge(face, side, triangle)))
            .collect();
        half_edges.par_sort_unstable();
        let mut starts = Vec::with_capacity(half_edges.len() / 2 + 2);
        for (i, edge) in half_edges.iter().enumerate() {
            let previous = i.checked_sub(1).map(|i| &half_edges[i]);
            if previous.is_none_or(|p| (p.lower, p.upper) != (edge.lower, edge.upper)) {
                starts.push(i as u32);
            }
        }
        starts.push(half_edges.len() as u32);
        Topology { half_edges, starts, face_count: triangles.len() }
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// For each edge, its half-edges; edges in the order of their vertices, half-edges of their faces.
    pub fn edges(&self) -> impl Iterator<Item = &[HalfEdge]> {
        self.starts.windows(2).map(|range| &self.half_edges[range[0] as usize..range[1] as usize])
    }

    /// The face across each side of each face, `NO_FACE` at edges that don't have exactly two.
    pub fn neighbours(&self) -> Vec<[u32; 3]> {
        let mut neighbours = vec![[NO_FACE; 3]; self.face_count];
        for edge in self.edges() {
            if let [a, b] = edge {
                neighbours[a.face()][a.side()] = b.face() as u32;
                neighbours[b.face()][b.side()] = a.face() as u32;
            }
        }
        neighbours
    }

    /// Number of each face's component; faces that share an edge are in the same one. Components are
    /// numbered in the order of their first faces.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut sets = DisjointSets::new(self.face_count);
        for edge in self.edges() {
            for other in &edge[1..] {
                sets.union(edge[0].face() as u32, other.face() as u32);
            }
        }
        sets.numbered()
    }
}

fn half_edge(face: usize, side: usize, triangle: &[u32; 3]) -> HalfEdge {
    let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
    let code = ((face as u64) << 2 | side as u64) << 1 | u64::from(from > to);
    HalfEdge { lower: from.min(to), upper: from.max(to), code }
}

/// Union-find; the lowest member stands for its set.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Sets of one member each.
    pub fn new(count: usize) -> DisjointSets {
        DisjointSets { parent: (0..count as u32).collect() }
    }

    /// The lowest member of the set of `i`.
    pub fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    /// Joins the sets of `a` and `b`.
    pub fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// Number of each member's set, in the order of their lowest members, and how many there are.
    pub fn numbered(mut self) -> (Vec<u32>, usize) {
        let mut numbers = vec![0; self.parent.len()];
        let mut count = 0;
        for i in 0..self.parent.len() as u32 {
            let root = self.find(i);
            numbers[i as usize] = if root == i {
                count += 1;
                count - 1
            } else {
                numbers[root as usize]
            };
        }
        (numbers, count as usize)
    }
}
