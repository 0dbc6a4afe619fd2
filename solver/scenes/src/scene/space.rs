//! The space that a source's fluid may fill: a box or a solid, less the bodies, and how much that is.

use super::numbers::Region;
use super::solid::{Solid, depth_in};
use rayon::prelude::*;
use volmap_runtime::{DVec3, PosedMap, Values};

/// Where a source's fluid may be.
#[derive(Clone, Copy)]
pub(super) struct Space<'a> {
    /// Of a box, or of a part of a solid.
    pub region: Option<Region>,
    /// The solid.
    pub solid: Option<&'a Solid>,
    /// What takes room away.
    pub bodies: &'a [PosedMap],
    /// How far from bodies the fluid's space begins, metres: by so much its first layer rests farther from them than a
    /// particle's radius.
    pub gap: f64,
    /// Particle radius, metres.
    pub rp: f64,
}

/// Cubes of this edge, in rp, are full, empty, or divided along each axis into so many.
const CUBE: f64 = 2.0;
const PARTS: usize = 4;
/// From a cube's middle to its corner, in its edges.
const TO_CORNER: f64 = 0.866_025_403_784_438_6;

impl Space<'_> {
    /// A box around it, metres; none if it is empty.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let endless = [DVec3::NEG_INFINITY, DVec3::INFINITY];
        let [low, high] = self.region.map_or(endless, |region| region.corners());
        let [a, b] = self.solid.map_or(endless, |solid| solid.bounds());
        let [low, high] = [low.max(a), high.min(b)];
        (low.cmplt(high).all() && low.is_finite() && high.is_finite()).then_some([low, high])
    }

    /// How deep points are in the space, metres: about the distance to its surface; negative out of it.
    pub fn depths(&self, points: &[DVec3]) -> Vec<f64> {
        let of_region = |&x: &DVec3| {
            self.region.map_or(f64::INFINITY, |region| {
                let [low, high] = region.corners();
                (x - low).min_element().min((high - x).min_element())
            })
        };
        let mut out: Vec<f64> = points.iter().map(of_region).collect();
        let mut values: Vec<Values> = Vec::new();
        if let Some(solid) = self.solid {
            solid.map.sample_batch(points, &mut values);
            for ((depth, &point), at) in out.iter_mut().zip(points).zip(&values) {
                *depth = depth.min(depth_in(solid, point, at.distance, self.rp));
            }
        }
        for body in self.bodies {
            body.sample_batch(points, &mut values);
            for (depth, at) in out.iter_mut().zip(&values) {
                *depth = depth.min(at.distance - self.gap);
            }
        }
        out
    }

    /// Its volume, m^3: that of cubes, the part of each that is in it by the depth of its middle.
    pub fn volume(&self) -> f64 {
        let Some([low, high]) = self.bounds() else { return 0.0 };
        let edge = CUBE * self.rp;
        let counts = ((high - low) / edge).ceil().as_uvec3();
        let layers: Vec<f64> = (0..counts.z)
            .into_par_iter()
            .map(|z| {
                let at = |x: u32, y: u32| low + edge * (DVec3::new(x.into(), y.into(), z.into()) + 0.5);
                let middles: Vec<DVec3> =
                    (0..counts.y).flat_map(|y| (0..counts.x).map(move |x| at(x, y))).collect();
                let depths = self.depths(&middles);
                middles.iter().zip(depths).map(|(&middle, depth)| self.part(middle, depth, high)).sum()
            })
            .collect();
        layers.iter().sum::<f64>() * edge.powi(3)
    }

    /// The part of a cube that is in the space and below `high`.
    fn part(&self, middle: DVec3, depth: f64, high: DVec3) -> f64 {
        let edge = CUBE * self.rp;
        let is_whole = (middle + 0.5 * edge).cmple(high).all();
        if depth > TO_CORNER * edge && is_whole {
            return 1.0;
        }
        if depth < -TO_CORNER * edge {
            return 0.0;
        }
        let small = edge / PARTS as f64;
        let along = |n: usize| (n as f64 + 0.5) * small - 0.5 * edge;
        let point = |n: usize| {
            middle + DVec3::new(along(n % PARTS), along(n / PARTS % PARTS), along(n / (PARTS * PARTS)))
        };
        let points: Vec<DVec3> = (0..PARTS.pow(3)).map(point).collect();
        let parts = self.depths(&points).into_iter().map(|depth| (0.5 + depth / small).clamp(0.0, 1.0));
        parts.sum::<f64>() / points.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_its_volume() {
        for size in [DVec3::new(0.3, 0.2, 0.1), DVec3::new(0.31, 0.27, 0.123)] {
            let min = DVec3::new(0.7, -3.0, 0.013);
            let region = Some(Region { min: min.to_array(), max: (min + size).to_array() });
            let space = Space { region, solid: None, bodies: &[], gap: 0.0, rp: 0.025 };
            let exact = size.element_product();
            assert!((space.volume() / exact - 1.0).abs() < 5e-3, "{} {exact}", space.volume());
        }
    }
}
