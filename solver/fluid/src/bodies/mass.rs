//! Mass, centre of mass and inertia of an evenly filled solid: Mirtich 1996, *Fast and Accurate Computation
//! of Polyhedral Mass Properties*, in the form of signed tetrahedra (Blow and Binstock 2004); or from a
//! volume map.

use glam::DMat3;
use rayon::prelude::*;
use volmap_bake::iso_surface::{IsoSurface, iso_surface};
use volmap_bake::primitive::{Moments as ShapeMoments, PlacedPrimitive};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DQuat, DVec3, Grid, Values, VolumeMap};

/// Points along each edge of a cell that the surface may cross.
const SUBCELLS: u32 = 4;

/// A volume below this part of the map's domain is rounding, as that of a sheet.
const NOTHING: f64 = 1e-12;

/// How heavy a body is, and where; in the map's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mass {
    /// kg.
    pub mass: f64,
    /// Volume of the solid, m^3.
    pub volume: f64,
    /// Centre of mass, metres.
    pub centre: DVec3,
    /// Inertia tensor about the centre of mass, kg m^2.
    pub inertia: DMat3,
}

/// Integrals of 1, x and x x^T over a solid.
#[derive(Clone, Copy)]
struct Moments {
    volume: f64,
    first: DVec3,
    second: DMat3,
}

impl Moments {
    const ZERO: Moments = Moments { volume: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    fn and(self, other: Moments) -> Moments {
        Moments {
            volume: self.volume + other.volume,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    /// Of a box, `part` of which is solid, evenly.
    fn of_box(centre: DVec3, size: DVec3, part: f64) -> Moments {
        let volume = part * size.element_product();
        let spread = DMat3::from_diagonal(size * size / 12.0);
        Moments { volume, first: volume * centre, second: (outer(centre, centre) + spread) * volume }
    }

    /// Of the tetrahedron between the origin and a triangle.
    fn of_tetrahedron([a, b, c]: [DVec3; 3]) -> Moments {
        let volume = a.cross(b).dot(c) / 6.0;
        let sum = a + b + c;
        let squares = outer(a, a) + outer(b, b) + outer(c, c);
        Moments { volume, first: sum * (volume / 4.0), second: (outer(sum, sum) + squares) * (volume / 20.0) }
    }

    /// With a density, from integrals about `origin`.
    fn mass(self, origin: DVec3, density: f64) -> Mass {
        let offset = self.first / self.volume;
        let spread = (self.second - outer(offset, offset) * self.volume) * density;
        let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        Mass {
            mass: self.volume * density,
            volume: self.volume,
            centre: origin + offset,
            inertia: DMat3::from_diagonal(DVec3::splat(trace)) - spread,
        }
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl Mass {
    /// Of what a mesh encloses, exactly; density in kg/m^3. `None` for an open mesh, whose area vectors have
    /// a sum.
    pub fn of_mesh(mesh: &TriangleMesh, density: f64) -> Option<Mass> {
        let at = |v: u32| DVec3::from(mesh.vertices[v as usize]);
        let count = mesh.vertices.len().max(1) as f64;
        // Differences of large numbers otherwise.
        let origin = mesh.vertices.iter().map(|&v| DVec3::from(v)).sum::<DVec3>() / count;
        let (mut moments, mut area, mut open) = (Moments::ZERO, 0.0, DVec3::ZERO);
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|v| at(v) - origin);
            let normal = (b - a).cross(c - a);
            (area, open) = (area + normal.length(), open + normal);
            moments = moments.and(Moments::of_tetrahedron([a, b, c]));
        }
        (open.length() <= 1e-9 * area && moments.volume > 0.0).then(|| moments.mass(origin, density))
    }

    /// Of a shape, in closed form; none of a plane.
    pub fn of_shape(shape: &PlacedPrimitive, density: f64) -> Option<Mass> {
        let ShapeMoments { volume, centre, inertia } = shape.moments()?;
        Some(Mass { mass: volume * density, volume, centre, inertia: inertia * density })
    }

    /// Of a map's solid within its domain: of what its surface encloses, as a mesh with corners at thirds of the
    /// cells. A surface that the domain cuts encloses nothing; then of parts of the cells.
    pub fn of_map(map: &VolumeMap, density: f64) -> Mass {
        let surface = iso_surface(map, 0.0, None, &Default::default()).ok().filter(|surface| !surface.is_cut);
        let mesh = surface.map(|IsoSurface { vertices, triangles, .. }| TriangleMesh { vertices, triangles });
        let domain = (map.grid().max_corner() - map.grid().origin).element_product();
        mesh.and_then(|mesh| Mass::of_mesh(&mesh, density))
            .filter(|mass| mass.volume > NOTHING * domain)
            .unwrap_or_else(|| Mass::of_cells(map, density))
    }

    /// From the distances at parts of a map's cells. A surface cuts such a part on average as if it were
    /// perpendicular to the part's edges, so the error shrinks with the cell's square.
    fn of_cells(map: &VolumeMap, density: f64) -> Mass {
        let grid = map.finest_grid(super::MOST_CELLS);
        let origin = 0.5 * (grid.origin + grid.max_corner());
        let layers: Vec<Moments> =
            (0..grid.resolution.z).into_par_iter().map(|z| layer_moments(map, &grid, origin, z)).collect();
        layers.into_iter().fold(Moments::ZERO, Moments::and).mass(origin, density)
    }

    /// The same body, evenly heavier or lighter.
    pub fn with_mass(self, mass: f64) -> Mass {
        Mass { mass, inertia: self.inertia * (mass / self.mass), ..self }
    }

    /// Angular momentum about the centre of mass in the world, kg m^2/s.
    pub fn angular_momentum(&self, rotation: DQuat, angular_velocity: DVec3) -> DVec3 {
        rotation * (self.inertia * (rotation.conjugate() * angular_velocity))
    }

    /// The angular velocity that belongs to an angular momentum.
    pub fn angular_velocity(&self, rotation: DQuat, angular_momentum: DVec3) -> DVec3 {
        rotation * (self.inertia.inverse() * (rotation.conjugate() * angular_momentum))
    }

    /// Whether something can move by it.
    pub(super) fn is_usable(&self) -> bool {
        let [a, b, c] = [self.inertia.x_axis, self.inertia.y_axis, self.inertia.z_axis];
        // Positive definite (Sylvester).
        let minors = [a.x, a.x * b.y - a.y * b.x, a.cross(b).dot(c)];
        self.mass > 0.0
            && self.mass.is_finite()
            && self.mass.recip().is_finite()
            && self.centre.is_finite()
            && minors.iter().all(|minor| minor.is_finite() && *minor > 0.0)
            && self.inertia.inverse().is_finite()
    }
}

/// Of the cells with this z.
fn layer_moments(map: &VolumeMap, grid: &Grid, origin: DVec3, z: u32) -> Moments {
    let part = grid.cell_size / f64::from(SUBCELLS);
    let width = part.element_product().cbrt();
    let mut moments = Moments::ZERO;
    let (mut points, mut values, mut parts) = (Vec::new(), Vec::<Values>::new(), Vec::new());
    for y in 0..grid.resolution.y {
        let centre = |x: u32| grid.cell_corner([x, y, z].into()) + 0.5 * grid.cell_size;
        points.clear();
        points.extend((0..grid.resolution.x).map(centre));
        map.sample_batch(&points, &mut values);
        parts.clear();
        for (centre, value) in points.iter().zip(&values) {
            if value.distance == f64::NEG_INFINITY {
                moments = moments.and(Moments::of_box(*centre - origin, grid.cell_size, 1.0));
            } else if value.distance.is_finite() {
                parts.extend((0..SUBCELLS.pow(3)).map(|n| {
                    let at = [n % SUBCELLS, n / SUBCELLS % SUBCELLS, n / SUBCELLS / SUBCELLS];
                    *centre - 0.5 * grid.cell_size + part * (DVec3::from(at.map(f64::from)) + 0.5)
                }));
            }
        }
        map.sample_batch(&parts, &mut values);
        for (point, value) in parts.iter().zip(&values) {
            let solid = (0.5 - value.distance / width).clamp(0.0, 1.0);
            if solid > 0.0 {
                moments = moments.and(Moments::of_box(*point - origin, part, solid));
            }
        }
    }
    moments
}
