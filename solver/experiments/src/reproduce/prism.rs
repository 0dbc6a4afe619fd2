//! Prisms with cross sections that are star-shaped around the axis: a cylinder and a washing drum.

use std::f64::consts::TAU;
use volmap_formats::mesh::TriangleMesh;

/// A prism along the z axis over a counter-clockwise cross section that is star-shaped around it.
pub fn prism(section: &[[f64; 2]], half_length: f64) -> TriangleMesh {
    let count = section.len() as u32;
    let level = |z: f64| section.iter().map(move |&[x, y]| [x, y, z]);
    let mut vertices: Vec<[f64; 3]> = level(-half_length).chain(level(half_length)).collect();
    vertices.extend([[0.0, 0.0, -half_length], [0.0, 0.0, half_length]]);
    let of_edge = |i: u32| {
        let [a, b] = [i, (i + 1) % count];
        let [c, d] = [a + count, b + count];
        [[a, b, d], [a, d, c], [2 * count, b, a], [2 * count + 1, c, d]]
    };
    TriangleMesh { vertices, triangles: (0..count).flat_map(of_edge).collect() }
}

/// The cross section of a cylinder.
pub fn circle(radius: f64, corners: u32) -> Vec<[f64; 2]> {
    let at = |n: u32| {
        let (sin, cos) = (TAU * f64::from(n) / f64::from(corners)).sin_cos();
        [radius * cos, radius * sin]
    };
    (0..corners).map(at).collect()
}

/// The cross section of a drum's hollow: a circle with paddles that point inwards, their sides along radii.
pub fn drum(radius: f64, paddles: u32, height: f64, width: f64) -> Vec<[f64; 2]> {
    let (sector, half) = (TAU / f64::from(paddles), 0.5 * width / radius);
    let at = |radius: f64, angle: f64| [radius * angle.cos(), radius * angle.sin()];
    let mut section = Vec::new();
    for paddle in 0..paddles {
        let middle = sector * f64::from(paddle);
        section.extend([-half, half].map(|angle| at(radius - height, middle + angle)));
        let arc = |n: u32| middle + half + (sector - 2.0 * half) * f64::from(n) / 16.0;
        section.extend((0..=16).map(|n| at(radius, arc(n))));
    }
    section
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_fluid::shapes::volume;

    #[test]
    fn prisms_have_the_volume_of_their_section() {
        let cylinder = prism(&circle(0.5, 4), 1.0);
        assert!((volume(&cylinder) - 2.0 * 0.5).abs() < 1e-12);
        let [plain, with] = [0, 1].map(|n| {
            let section = if n == 0 { circle(0.5, 200) } else { drum(0.5, 3, 0.2, 0.1) };
            volume(&prism(&section, 0.5))
        });
        // Three paddles, a little narrower towards the axis.
        assert!((plain - with - 3.0 * 0.2 * 0.08).abs() < 5e-3, "{plain} {with}");
    }
}
