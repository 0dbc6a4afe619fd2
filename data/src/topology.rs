//! Counts what keeps a mesh from being a closed, oriented, manifold surface, by its edges.

use std::collections::BTreeMap;

use crate::mesh::Mesh;

/// Counts; all zero for a good mesh, except `components`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Edges with exactly one triangle.
    pub boundary_edges: usize,
    /// Closed chains of boundary edges, each of whose vertices has two boundary edges.
    pub boundary_loops: usize,
    /// Edges with three triangles or more.
    pub nonmanifold_edges: usize,
    /// Edges whose two triangles run along them in the same direction.
    pub flipped_edges: usize,
    /// Vertices whose triangles, joined by shared edges, fall into more than one group.
    pub nonmanifold_vertices: usize,
    /// Triangles with the same three vertices as an earlier one.
    pub duplicate_triangles: usize,
    /// Triangles that use a vertex twice.
    pub degenerate_triangles: usize,
    /// Vertices that no triangle uses.
    pub unused_vertices: usize,
    /// Parts that share no vertex with each other.
    pub components: usize,
}

impl Topology {
    /// Counts for `mesh`, whose indices must be in range.
    pub fn of(mesh: &Mesh) -> Self {
        let mut edges: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
        let mut seen: BTreeMap<[u32; 3], usize> = BTreeMap::new();
        let mut degenerate_triangles = 0;
        for (triangle, t) in mesh.triangles.iter().enumerate() {
            for corner in 0..3 {
                let (a, b) = (t[corner], t[(corner + 1) % 3]);
                edges.entry([a.min(b), a.max(b)]).or_default().push((triangle, a < b));
            }
            let mut sorted = *t;
            sorted.sort_unstable();
            *seen.entry(sorted).or_default() += 1;
            degenerate_triangles += usize::from(sorted[0] == sorted[1] || sorted[1] == sorted[2]);
        }
        let boundary: Vec<[u32; 2]> = edges.iter().filter(|(_, s)| s.len() == 1).map(|(e, _)| *e).collect();
        let (components, unused_vertices) = components(mesh);
        Self {
            boundary_edges: boundary.len(),
            boundary_loops: loops(&boundary, mesh.vertices.len()),
            nonmanifold_edges: edges.values().filter(|s| s.len() > 2).count(),
            flipped_edges: edges.values().filter(|s| s.len() == 2 && s[0].1 == s[1].1).count(),
            nonmanifold_vertices: nonmanifold_vertices(mesh, &edges),
            duplicate_triangles: seen.values().map(|n| n - 1).sum(),
            degenerate_triangles,
            unused_vertices,
            components,
        }
    }

    /// Whether the mesh bounds a solid: closed, manifold and consistently oriented.
    pub fn is_closed_manifold(&self) -> bool {
        *self == Self { components: self.components, ..Self::default() }
    }
}

/// Disjoint sets (union-find with path halving).
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn find(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.find(i), self.find(j));
        self.0[i.max(j)] = i.min(j);
    }
}

fn loops(boundary: &[[u32; 2]], vertex_count: usize) -> usize {
    let mut sets = Sets::new(vertex_count);
    let mut degree = vec![0; vertex_count];
    for &[a, b] in boundary {
        sets.join(a as usize, b as usize);
        degree[a as usize] += 1;
        degree[b as usize] += 1;
    }
    let mut closed = vec![true; vertex_count];
    for v in 0..vertex_count {
        closed[sets.find(v)] &= degree[v] == 2;
    }
    (0..vertex_count).filter(|&v| sets.find(v) == v && closed[v]).count()
}

fn nonmanifold_vertices(mesh: &Mesh, edges: &BTreeMap<[u32; 2], Vec<(usize, bool)>>) -> usize {
    // One element per triangle corner; an edge joins the corners at each of its two ends.
    let mut sets = Sets::new(3 * mesh.triangles.len());
    let corner = |triangle: usize, v: u32| {
        3 * triangle + mesh.triangles[triangle].iter().position(|&w| w == v).expect("an end of its edge")
    };
    for (ends, sides) in edges {
        for pair in sides.windows(2) {
            for &v in ends {
                sets.join(corner(pair[0].0, v), corner(pair[1].0, v));
            }
        }
    }
    let mut fans = vec![0; mesh.vertices.len()];
    for (i, &v) in mesh.triangles.as_flattened().iter().enumerate() {
        fans[v as usize] += usize::from(sets.find(i) == i);
    }
    fans.into_iter().filter(|&n| n > 1).count()
}

/// The number of connected parts, and of unused vertices.
fn components(mesh: &Mesh) -> (usize, usize) {
    let mut sets = Sets::new(mesh.vertices.len());
    let mut used = vec![false; mesh.vertices.len()];
    for t in &mesh.triangles {
        for &v in t {
            sets.join(t[0] as usize, v as usize);
            used[v as usize] = true;
        }
    }
    let roots = (0..used.len()).filter(|&v| used[v] && sets.find(v) == v).count();
    (roots, used.iter().filter(|&&u| !u).count())
}
