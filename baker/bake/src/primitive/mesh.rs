//! Meshes that stand for primitives in pictures, in exports and where bodies touch. Circles are divided by square
//! roots alone, so that every machine has the same bits.

use super::{PlacedPrimitive, Primitive};
use crate::error::Error;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use volmap_formats::mesh::TriangleMesh;

/// Times that a quarter of a circle is halved: 128 corners, which lie 0.03 % of the radius off the circle at most.
const HALVINGS: u32 = 5;

impl PlacedPrimitive {
    /// A closed mesh whose triangles run counter-clockwise seen from outside; of a plane, of the solid within its box.
    ///
    /// # Errors
    /// A plane that doesn't cut its box.
    pub fn mesh(&self) -> Result<TriangleMesh, Error> {
        let mut mesh = match self.shape {
            Primitive::Box { size } => cuboid(0.5 * DVec3::from(size)),
            Primitive::Sphere { radius } => revolved(&half_circle(radius, 0.0)),
            Primitive::Cylinder { radius, height } => {
                let half = 0.5 * height;
                revolved(&[
                    DVec2::new(0.0, -half),
                    DVec2::new(radius, -half),
                    DVec2::new(radius, half),
                    DVec2::new(0.0, half),
                ])
            }
            Primitive::Capsule { radius, length } => revolved(&half_circle(radius, 0.5 * length)),
            Primitive::Plane { normal, .. } => return self.cut_box(normal.into()),
        };
        for vertex in &mut mesh.vertices {
            *vertex = (self.turn * DVec3::from(*vertex) + self.centre).to_array();
        }
        if self.turn.determinant() < 0.0 {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(mesh)
    }

    /// The part of the plane's box that is solid.
    fn cut_box(&self, normal: DVec3) -> Result<TriangleMesh, Error> {
        let [low, high] = self.bounds();
        let mut cut = Cut { mesh: cuboid_between(low, high), depths: Vec::new(), crossings: BTreeMap::new() };
        cut.depths = cut.mesh.vertices.iter().map(|vertex| self.distance((*vertex).into())).collect();
        if !cut.depths.iter().any(|d| *d > 0.0) || !cut.depths.iter().any(|d| *d < 0.0) {
            let reason =
                "the plane doesn't cut the box that it lies in; move one of them (`translate`, `domain`)";
            return Err(Error::setting("shape", reason));
        }
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for polygon in FACES.map(|face| cut.polygon(&face)) {
            fan(&polygon, &mut triangles);
        }
        let lid = cut.lid(normal);
        fan(&lid, &mut triangles);
        Ok(with_used_vertices(&cut.mesh.vertices, &triangles))
    }
}

/// Corners of a box by the bits of their numbers (x, y, z), counter-clockwise seen from outside.
const FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

fn cuboid(half: DVec3) -> TriangleMesh {
    cuboid_between(-half, half)
}

fn cuboid_between(low: DVec3, high: DVec3) -> TriangleMesh {
    let corner = |n: u32| {
        let bit = |axis: usize| if n >> axis & 1 == 1 { high[axis] } else { low[axis] };
        [bit(0), bit(1), bit(2)]
    };
    let mut triangles = Vec::new();
    FACES.iter().for_each(|face| fan(face, &mut triangles));
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A convex polygon as triangles.
fn fan(polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let Some((first, rest)) = polygon.split_first() else { return };
    triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
}

/// A box that is cut by a plane.
struct Cut {
    mesh: TriangleMesh,
    /// Of each corner, its distance from the plane.
    depths: Vec<f64>,
    /// Vertices on edges, by their ends.
    crossings: BTreeMap<[u32; 2], u32>,
}

impl Cut {
    /// What is left of a face.
    fn polygon(&mut self, face: &[u32; 4]) -> Vec<u32> {
        let mut out = Vec::new();
        for (n, &a) in face.iter().enumerate() {
            let b = face[(n + 1) % 4];
            let [da, db] = [a, b].map(|v| self.depths[v as usize]);
            if da <= 0.0 {
                out.push(a);
            }
            if da < 0.0 && db > 0.0 || da > 0.0 && db < 0.0 {
                out.push(self.crossing([a.min(b), a.max(b)]));
            }
        }
        out
    }

    fn crossing(&mut self, edge: [u32; 2]) -> u32 {
        let [a, b] = edge.map(|v| DVec3::from(self.mesh.vertices[v as usize]));
        let [da, db] = edge.map(|v| self.depths[v as usize]);
        let vertices = &mut self.mesh.vertices;
        *self.crossings.entry(edge).or_insert_with(|| {
            vertices.push((a + (b - a) * (da / (da - db))).to_array());
            vertices.len() as u32 - 1
        })
    }

    /// The polygon in the plane, counter-clockwise around the normal.
    fn lid(&self, normal: DVec3) -> Vec<u32> {
        let on_plane = (0..8).filter(|v| self.depths[*v as usize] == 0.0);
        let mut lid: Vec<u32> = self.crossings.values().copied().chain(on_plane).collect();
        let at = |v: u32| DVec3::from(self.mesh.vertices[v as usize]);
        let middle = lid.iter().map(|v| at(*v)).sum::<DVec3>() / lid.len() as f64;
        let (u, v) = normal.any_orthonormal_pair();
        let angle = |vertex: &u32| {
            let from = at(*vertex) - middle;
            // u x v is the normal.
            from.dot(v).atan2(from.dot(u))
        };
        lid.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        lid
    }
}

fn with_used_vertices(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriangleMesh {
    let mut numbers = BTreeMap::new();
    triangles.iter().flatten().for_each(|v| _ = numbers.insert(*v, 0));
    numbers.values_mut().enumerate().for_each(|(n, number)| *number = n as u32);
    TriangleMesh {
        vertices: numbers.keys().map(|v| vertices[*v as usize]).collect(),
        triangles: triangles.iter().map(|triangle| triangle.map(|v| numbers[&v])).collect(),
    }
}

/// A quarter of the circle of radius 1, from (1, 0) to (0, 1).
fn quarter() -> Vec<DVec2> {
    let mut points = vec![DVec2::X, DVec2::Y];
    for _ in 0..HALVINGS {
        let halved = points.windows(2).flat_map(|pair| [pair[0], (pair[0] + pair[1]).normalize()]);
        points = halved.chain([DVec2::Y]).collect();
    }
    points
}

/// From the lowest point, (0, -half - radius), to the highest; (distance from the axis, height).
fn half_circle(radius: f64, half: f64) -> Vec<DVec2> {
    let rising = quarter();
    let lower = rising.iter().rev().map(|p| DVec2::new(p.x * radius, -half - p.y * radius));
    let upper = rising.iter().map(|p| DVec2::new(p.x * radius, half + p.y * radius));
    let joined = if half == 0.0 { 1 } else { 0 };
    lower.chain(upper.skip(joined)).collect()
}

/// The solid that a line sweeps around the y axis; its ends lie on the axis.
fn revolved(line: &[DVec2]) -> TriangleMesh {
    let quarter = quarter();
    let quarter = &quarter[..quarter.len() - 1];
    let circle: Vec<DVec2> = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y]
        .iter()
        .flat_map(|turn| quarter.iter().map(|p| p.rotate(*turn)))
        .collect();
    let (count, rings) = (circle.len() as u32, &line[1..line.len() - 1]);
    let mut vertices = vec![[0.0, line[0].y, 0.0]];
    for p in rings {
        vertices.extend(circle.iter().map(|c| [p.x * c.x, p.y, p.x * c.y]));
    }
    vertices.push([0.0, line[line.len() - 1].y, 0.0]);
    let (last_ring, top) = (rings.len() as u32 - 1, vertices.len() as u32 - 1);
    let at = |ring: u32, n: u32| 1 + ring * count + n % count;
    let mut triangles = Vec::new();
    for n in 0..count {
        triangles.push([0, at(0, n), at(0, n + 1)]);
        for ring in 0..last_ring {
            let [a, b, c, d] = [at(ring, n), at(ring, n + 1), at(ring + 1, n), at(ring + 1, n + 1)];
            triangles.extend([[a, c, b], [c, d, b]]);
        }
        triangles.push([top, at(last_ring, n + 1), at(last_ring, n)]);
    }
    TriangleMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::diagnose;
    use volmap_formats::mesh::{Placement, Rotation};

    /// Closed, the right way round, and on the surface; as large as the closed form but for the facets.
    #[test]
    fn meshes_lie_on_their_surfaces() {
        let placement = Placement {
            rotation: Rotation { axis: [1.0, -2.0, 0.5], degrees: 77.0 },
            scale: [-2.0, 2.0, 2.0],
            translation: [1.0, 2.0, 3.0],
            ..Placement::default()
        };
        for text in ["box:1,2,3", "sphere:0.7", "cylinder:0.5,2", "capsule:0.5,2"] {
            let placed = PlacedPrimitive::new(text.parse().unwrap(), &placement).unwrap();
            let mesh = placed.mesh().unwrap();
            let found = diagnose(&mesh);
            assert!(found.closed && found.oriented && found.manifold_vertices && found.components == 1);
            let far = |v: &[f64; 3]| placed.distance((*v).into()).abs();
            assert!(mesh.vertices.iter().all(|v| far(v) < 1e-14), "{text}");
            let part = found.volume / placed.shape().volume();
            assert!((0.998..1.0 + 1e-12).contains(&part), "{text}: {part} of the volume");
            assert!((found.area / placed.shape().area() - 1.0).abs() < 2e-3, "{text}");
        }
    }

    #[test]
    fn planes_cut_their_box() {
        // Through a face, through corners and edges, askew.
        for (text, volume, triangles) in [
            ("plane:0,1,0,-1,-1,-1,1,3,1", 4.0, 12),
            ("plane:1,1,0,-1,-1,-1,1,1,1", 4.0, 8),
            ("plane:1,1,1,-1,-1,-1,1,1,1", 4.0, 16),
            ("plane:-2,0.5,1,-1,-1,-1,1,1,1", 4.0, 12),
        ] {
            let placed = PlacedPrimitive::new(text.parse().unwrap(), &Placement::default()).unwrap();
            let mesh = placed.mesh().unwrap();
            let found = diagnose(&mesh);
            assert!(found.closed && found.oriented && found.zero_area_triangles.count == 0, "{text}");
            assert!((found.volume - volume).abs() < 1e-14, "{text}: {}", found.volume);
            assert_eq!(mesh.triangles.len(), triangles, "{text}");
            assert!(mesh.vertices.iter().all(|v| placed.distance((*v).into()) < 1e-14));
        }
        let beside = PlacedPrimitive::new("plane:0,1,0,0,1,0,1,2,1".parse().unwrap(), &Placement::default());
        assert!(beside.unwrap().mesh().unwrap_err().to_string().contains("doesn't cut"));
    }
}
