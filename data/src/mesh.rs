//! A triangle mesh with shared vertices, and its simplest measures.

use glam::DVec3;

/// Vertices in metres; triangles are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, m.
    pub vertices: Vec<DVec3>,
    /// Three vertex indices a triangle, from 0.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The corners of one triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }

    /// Adds a vertex and returns its index.
    pub fn push(&mut self, position: DVec3) -> u32 {
        self.vertices.push(position);
        (self.vertices.len() - 1) as u32
    }

    /// Adds the quadrilateral a, b, c, d (counter-clockwise), split along its shorter diagonal.
    pub fn push_quad(&mut self, [a, b, c, d]: [u32; 4]) {
        let length2 = |i: u32, j: u32| self.vertices[i as usize].distance_squared(self.vertices[j as usize]);
        if length2(a, c) <= length2(b, d) {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            self.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }

    /// Smallest and largest coordinates, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
    }

    /// Enclosed volume, m^3: positive when the triangles face outwards.
    pub fn volume(&self) -> f64 {
        self.triangles
            .iter()
            .map(|&t| {
                let [a, b, c] = self.corners(t);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Moves and scales each axis so that the box becomes `low` to `high`.
    pub fn fit(&mut self, low: DVec3, high: DVec3) {
        let (old_low, old_high) = self.bounds();
        for v in &mut self.vertices {
            *v = low + (*v - old_low) * (high - low) / (old_high - old_low);
        }
    }

    /// Drops vertices that no triangle uses.
    pub fn compact(&mut self) {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        for &v in self.triangles.as_flattened() {
            new_index[v as usize] = 0;
        }
        let mut kept = Vec::new();
        for (old, &vertex) in self.vertices.iter().enumerate() {
            if new_index[old] == 0 {
                new_index[old] = kept.len() as u32;
                kept.push(vertex);
            }
        }
        self.vertices = kept;
        for v in self.triangles.as_flattened_mut() {
            *v = new_index[*v as usize];
        }
    }
}
