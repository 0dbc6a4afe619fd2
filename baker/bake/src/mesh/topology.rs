//! Edges, neighbours and connected parts of a mesh, by a counting sort.

use volmap_formats::mesh::TriangleMesh;

/// One side of a triangle: from its corner i to corner i + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HalfEdge {
    /// Face times three plus side, times two, plus 1 where the side runs from higher to lower vertex.
    code: u32,
}

impl HalfEdge {
    fn new(corner: usize, backward: bool) -> HalfEdge {
        HalfEdge { code: (corner as u32) << 1 | u32::from(backward) }
    }

    /// Face times three plus side.
    pub fn corner(self) -> usize {
        (self.code >> 1) as usize
    }

    /// Index of the triangle.
    pub fn face(self) -> usize {
        self.corner() / 3
    }

    /// Which of its sides: 0 to 2.
    pub fn side(self) -> usize {
        self.corner() % 3
    }

    /// True where the triangle runs through the edge from the lower vertex to the higher.
    pub fn forward(self) -> bool {
        self.code & 1 == 0
    }

    /// The same side when the triangle's second and third corner change places.
    fn flipped(self) -> HalfEdge {
        HalfEdge::new(3 * self.face() + 2 - self.side(), self.forward())
    }
}

/// An edge with the sides of triangles that run along it.
#[derive(Clone, Copy, Debug)]
pub struct Edge<'a> {
    /// Its lower and its higher vertex.
    pub ends: [u32; 2],
    /// In the order of the faces.
    pub sides: &'a [HalfEdge],
}

/// All edges of a mesh; by default of one without triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    half_edges: Vec<HalfEdge>,
    /// The vertices of each edge.
    ends: Vec<[u32; 2]>,
    /// Where each edge's half-edges start, and their number at the end.
    starts: Vec<u32>,
    /// What lies across each side of each face.
    neighbours: Vec<[Neighbour; 3]>,
}

impl Topology {
    /// Sorts the edges of a mesh by their vertices, in linear time. At most 2^31 / 3 triangles.
    pub fn new(mesh: &TriangleMesh) -> Topology {
        let (mut sides, ends) = sides_by_lower_vertex(mesh);
        let mut topology = Topology {
            half_edges: Vec::with_capacity(sides.len()),
            ends: Vec::with_capacity(sides.len() / 2 + 1),
            starts: Vec::with_capacity(sides.len() / 2 + 2),
            neighbours: vec![[Neighbour::NONE; 3]; mesh.triangles.len()],
        };
        let mut start = 0;
        for (lower, &end) in ends.iter().enumerate() {
            let around = &mut sides[start..end as usize];
            start = end as usize;
            sort(around);
            let mut last = None;
            for &side in around.iter() {
                let upper = (side >> 32) as u32;
                if last.replace(upper) != Some(upper) {
                    topology.starts.push(topology.half_edges.len() as u32);
                    topology.ends.push([lower as u32, upper]);
                }
                topology.half_edges.push(HalfEdge { code: side as u32 });
            }
        }
        topology.starts.push(topology.half_edges.len() as u32);
        topology.find_neighbours();
        topology
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.ends.len()
    }

    /// All edges, in the order of their vertices.
    pub fn edges(&self) -> impl Iterator<Item = Edge<'_>> {
        let ranges = self.starts.windows(2).map(|range| range[0] as usize..range[1] as usize);
        self.ends.iter().zip(ranges).map(|(&ends, range)| Edge { ends, sides: &self.half_edges[range] })
    }

    /// What lies across each side of each face.
    pub fn neighbours(&self) -> &[[Neighbour; 3]] {
        &self.neighbours
    }

    fn find_neighbours(&mut self) {
        for range in self.starts.windows(2) {
            if let [a, b] = self.half_edges[range[0] as usize..range[1] as usize] {
                let same_way = a.forward() == b.forward();
                self.neighbours[a.face()][a.side()] = Neighbour::new(b, same_way);
                self.neighbours[b.face()][b.side()] = Neighbour::new(a, same_way);
            }
        }
    }

    /// Follows the mesh where the second and third corner of triangles change places.
    pub fn flip(&mut self, flip: &[bool]) {
        for half in self.half_edges.iter_mut().filter(|half| flip[half.face()]) {
            *half = half.flipped();
        }
        self.neighbours.fill([Neighbour::NONE; 3]);
        self.find_neighbours();
    }

    /// Number of each face's component; faces that share an edge are in the same one. Components are
    /// numbered in the order of their first faces.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut sets = DisjointSets::new(self.neighbours.len());
        for edge in self.edges() {
            for other in &edge.sides[1..] {
                sets.union(edge.sides[0].face() as u32, other.face() as u32);
            }
        }
        sets.numbered()
    }
}

/// What lies across a side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbour {
    /// As of its half-edge, but the last bit is set where it runs along the edge the same way.
    code: u32,
}

impl Neighbour {
    /// The edge has no other side, or more than one.
    pub const NONE: Neighbour = Neighbour { code: u32::MAX };

    fn new(side: HalfEdge, same_way: bool) -> Neighbour {
        Neighbour { code: HalfEdge::new(side.corner(), same_way).code }
    }

    /// Face times three plus side, if there is exactly one.
    pub fn corner(self) -> Option<usize> {
        (self != Neighbour::NONE).then_some((self.code >> 1) as usize)
    }

    /// Index of the triangle, if there is exactly one.
    pub fn face(self) -> Option<usize> {
        self.corner().map(|corner| corner / 3)
    }

    /// True where both triangles run along the edge the same way: one should be turned.
    pub fn same_way(self) -> bool {
        self != Neighbour::NONE && self.code & 1 == 1
    }
}

/// For each side its higher vertex (upper half) and its half-edge, grouped by lower vertex and in the
/// order of the faces; and where each vertex' group ends.
fn sides_by_lower_vertex(mesh: &TriangleMesh) -> (Vec<u64>, Vec<u32>) {
    let mut ends = vec![0u32; mesh.vertices.len() + 1];
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            ends[*from.min(to) as usize + 1] += 1;
        }
    }
    for vertex in 1..ends.len() {
        ends[vertex] += ends[vertex - 1];
    }
    let mut sides = vec![0u64; 3 * mesh.triangles.len()];
    for (face, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        for (side, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            let half = HalfEdge::new(3 * face + side, from > to);
            // From where the vertex' group starts to where it ends.
            let next = &mut ends[from.min(to) as usize];
            sides[*next as usize] = u64::from(from.max(to)) << 32 | u64::from(half.code);
            *next += 1;
        }
    }
    ends.pop();
    (sides, ends)
}

/// Sorts few numbers by insertion.
fn sort(numbers: &mut [u64]) {
    if numbers.len() > 32 {
        return numbers.sort_unstable();
    }
    for i in 1..numbers.len() {
        let number = numbers[i];
        let mut k = i;
        while k > 0 && numbers[k - 1] > number {
            numbers[k] = numbers[k - 1];
            k -= 1;
        }
        numbers[k] = number;
    }
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

    /// Joins the sets of `a` and `b`; true if they were two.
    pub fn union(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
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
