//! Meshes the zero set of an implicit function by surface nets: one vertex in each cell that the surface
//! crosses, one quadrilateral around each lattice edge that it crosses.
//!
//! Gibson, *Constrained Elastic Surface Nets*, MICCAI 1998 (the net); its relaxation is replaced by
//! projection onto the implicit surface.

use glam::{DVec3, UVec3};

use crate::mesh::Mesh;

/// An implicit solid: negative inside, about a distance near the surface.
pub type Field = fn(DVec3) -> f64;

/// Where to look for the surface, and how finely.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Lower corner, m; the box must hold the whole solid with a cell to spare.
    pub low: DVec3,
    /// Upper corner, m.
    pub high: DVec3,
    /// Edge length of the cubic cells, m.
    pub cell: f64,
}

/// Triangles of the zero set inside the lattice's box, outwards, with vertices on the surface.
pub fn mesh(field: Field, lattice: Lattice) -> Mesh {
    let samples = Samples::new(field, lattice);
    let mut mesh = Mesh::default();
    let net = place_vertices(&samples, &mut mesh);
    for v in &mut mesh.vertices {
        *v = project(field, *v);
    }
    for axis in 0..3 {
        connect(&samples, &net, axis, &mut mesh);
    }
    mesh
}

/// Moves a point near the surface onto it, by Newton steps along the gradient.
pub fn project(field: Field, mut p: DVec3) -> DVec3 {
    for _ in 0..4 {
        let gradient = gradient(field, p);
        p -= gradient * (field(p) / gradient.length_squared());
    }
    p
}

/// Gradient by central differences.
pub fn gradient(field: Field, p: DVec3) -> DVec3 {
    const STEP: f64 = 1.0 / 65536.0;
    let slope = |axis: DVec3| (field(p + axis * STEP) - field(p - axis * STEP)) / (2.0 * STEP);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
}

/// The function's values at the lattice points, x fastest.
struct Samples {
    lattice: Lattice,
    /// Number of points per axis.
    size: UVec3,
    values: Vec<f64>,
}

impl Samples {
    fn new(field: Field, lattice: Lattice) -> Self {
        let size = ((lattice.high - lattice.low) / lattice.cell).ceil().as_uvec3() + 1;
        let mut samples = Self { lattice, size, values: Vec::new() };
        for z in 0..size.z {
            for y in 0..size.y {
                for x in 0..size.x {
                    samples.values.push(field(samples.position(UVec3::new(x, y, z))));
                }
            }
        }
        samples
    }

    fn position(&self, point: UVec3) -> DVec3 {
        self.lattice.low + point.as_dvec3() * self.lattice.cell
    }

    fn index(&self, point: UVec3) -> usize {
        ((point.z * self.size.y + point.y) * self.size.x + point.x) as usize
    }

    fn value(&self, point: UVec3) -> f64 {
        self.values[self.index(point)]
    }

    /// The lattice points from `low` to before `high`.
    fn points(low: UVec3, high: UVec3) -> impl Iterator<Item = UVec3> {
        (low.z..high.z).flat_map(move |z| {
            (low.y..high.y).flat_map(move |y| (low.x..high.x).map(move |x| UVec3::new(x, y, z)))
        })
    }
}

/// One vertex per crossed cell, at the mean of the crossings of its edges; returns the vertex of each cell,
/// indexed like its lower corner.
fn place_vertices(samples: &Samples, mesh: &mut Mesh) -> Vec<u32> {
    let mut net = vec![u32::MAX; samples.values.len()];
    for cell in Samples::points(UVec3::ZERO, samples.size - 1) {
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        for corner in 0..8 {
            for axis in (0..3).filter(|axis| corner >> axis & 1 == 0) {
                let a = cell + UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
                let b = a + UVec3::AXES[axis];
                let (value_a, value_b) = (samples.value(a), samples.value(b));
                if (value_a < 0.0) != (value_b < 0.0) {
                    let t = value_a / (value_a - value_b);
                    sum += samples.position(a).lerp(samples.position(b), t);
                    count += 1;
                }
            }
        }
        if count > 0 {
            net[samples.index(cell)] = mesh.push(sum / f64::from(count));
        }
    }
    net
}

/// The quadrilaterals around the crossed lattice edges along one axis.
fn connect(samples: &Samples, net: &[u32], axis: usize, mesh: &mut Mesh) {
    let along = UVec3::AXES[axis];
    let (u, v) = (UVec3::AXES[(axis + 1) % 3], UVec3::AXES[(axis + 2) % 3]);
    for a in Samples::points(u + v, samples.size - 1) {
        let inside = samples.value(a) < 0.0;
        if inside == (samples.value(a + along) < 0.0) {
            continue;
        }
        let mut quad = [a - u - v, a - v, a, a - u].map(|cell| net[samples.index(cell)]);
        if !inside {
            quad.reverse();
        }
        mesh.push_quad(quad);
    }
}
