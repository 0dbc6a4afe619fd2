//! Cubic lattices of particles: the order in which a fluid at rest begins.

use volmap_runtime::DVec3;

/// Particles of a source at most.
pub const MAX_PARTICLES: u64 = 100_000_000;
/// Part of a spacing that rounding may take from an edge.
const SLACK: f64 = 1e-6;

/// How many particles fit along each edge of a box, which is given by its lowest and highest corner.
pub fn counts([min, max]: [DVec3; 2], spacing: f64) -> [u64; 3] {
    std::array::from_fn(|axis| {
        let fits = ((max[axis] - min[axis]) / spacing + SLACK).floor();
        // A cast of what is too large or no number saturates.
        fits.max(0.0) as u64
    })
}

/// Particles in a box between two corners, metres: half a spacing from the faces of `min`, x running fastest.
pub fn fill_box(corners: [DVec3; 2], spacing: f64) -> impl Iterator<Item = DVec3> {
    let first = corners[0] + 0.5 * spacing;
    points(first, spacing, counts(corners, spacing))
}

/// A lattice from its first point, x running fastest.
pub fn points(first: DVec3, spacing: f64, [nx, ny, nz]: [u64; 3]) -> impl Iterator<Item = DVec3> {
    let row = move |y: u64, z: u64| {
        (0..nx).map(move |x| first + spacing * DVec3::new(x as f64, y as f64, z as f64))
    };
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| row(y, z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metre_holds_twenty_particles_of_25_mm_along_each_edge() {
        let cube = [DVec3::splat(0.1), DVec3::splat(1.1)];
        assert_eq!(counts(cube, 0.05), [20; 3]);
        let all: Vec<DVec3> = fill_box(cube, 0.05).collect();
        assert_eq!(all.len(), 8000);
        assert!((all[0] - DVec3::splat(0.125)).length() < 1e-12);
        assert!((all[7999] - DVec3::splat(1.075)).length() < 1e-12);
        assert!((all[1] - all[0] - DVec3::X * 0.05).length() < 1e-12);
    }

    #[test]
    fn the_rest_of_an_edge_stays_empty() {
        assert_eq!(counts([DVec3::ZERO, DVec3::new(0.049, 0.051, 0.1)], 0.05), [0, 1, 2]);
    }
}
