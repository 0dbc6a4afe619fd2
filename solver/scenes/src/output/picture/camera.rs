//! Where the eye is: given, or found so that a box fills the picture.

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use volmap_figures::raster::View;

/// Where pictures are seen from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Its place, metres.
    pub position: [f64; 3],
    /// What it looks at, metres.
    pub target: [f64; 3],
    /// Angle from the picture's lower to its upper edge, degrees. Default: 40.
    #[serde(default = "field_of_view")]
    pub field_of_view: f64,
}

fn field_of_view() -> f64 {
    40.0
}

/// The same where no camera is given, degrees.
const DISTANT: f64 = 28.0;

/// A box, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest corner.
    pub low: Vec3,
    /// Highest corner.
    pub high: Vec3,
}

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Bounds = Bounds { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Grows to hold a point.
    pub fn add(&mut self, point: Vec3) {
        if point.is_finite() {
            self.low = self.low.min(point);
            self.high = self.high.max(point);
        }
    }

    /// A box that holds something of some size.
    pub fn or_unit(self) -> Bounds {
        match self.low.cmple(self.high).all() && self.size() > 0.0 {
            true => self,
            false if self.low.is_finite() => Bounds { low: self.low - 0.5, high: self.low + 0.5 },
            false => Bounds { low: Vec3::splat(-0.5), high: Vec3::splat(0.5) },
        }
    }

    /// Its diagonal.
    pub fn size(self) -> f32 {
        (self.high - self.low).length()
    }

    /// Its middle.
    pub fn centre(self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    fn corners(self) -> [Vec3; 8] {
        std::array::from_fn(|n| {
            let pick = |axis: usize| if n >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        })
    }
}

/// Parts of the picture's width and height that the box may fill; the legend is below.
const FILLED: [f32; 2] = [0.92, 0.76];
/// How far the box is moved up, parts of the height.
const RAISED: f32 = 0.035;

/// The view of a camera, or one that shows the box from the front, the left and above.
pub fn view(camera: Option<&Camera>, bounds: Bounds, up: Vec3, size: [usize; 2]) -> View {
    let angle = camera.map_or(DISTANT, |camera| camera.field_of_view).clamp(1.0, 150.0);
    let scale = (0.5 * size[1] as f64 / (0.5 * angle.to_radians()).tan()) as f32;
    let near = 1e-3 * bounds.size();
    let view = |origin: Vec3, forward: Vec3| {
        let right = forward.cross(up).try_normalize().unwrap_or(forward.any_orthonormal_vector());
        View { origin, right, up: right.cross(forward), forward, size, scale, parallel: false, near }
    };
    if let Some(camera) = camera {
        let [from, to] = [camera.position, camera.target].map(|p| Vec3::from_array(p.map(|x| x as f32)));
        return view(from, (to - from).try_normalize().unwrap_or(Vec3::NEG_Z));
    }
    let forward = -direction(bounds, up);
    let place = |local: View| {
        // Far enough for each corner to be in the picture, then centred, and once more.
        let room = [0, 1].map(|axis| 0.5 * FILLED[axis] * size[axis] as f32 / scale);
        let seen = bounds.corners().map(|corner| local.local(corner));
        let needed = |p: Vec3| (p.x.abs() / room[0]).max(p.y.abs() / room[1]) - p.z;
        local.origin - local.forward * seen.map(needed).into_iter().fold(f32::NEG_INFINITY, f32::max)
    };
    let mut found = view(bounds.centre(), forward);
    for _ in 0..4 {
        found.origin = place(found);
        let mut seen = Bounds::EMPTY;
        for corner in bounds.corners() {
            let [x, y] = found.pixel(found.local(corner));
            seen.add(Vec3::new(x, y, 0.0));
        }
        let off = seen.centre() - 0.5 * Vec3::new(size[0] as f32, size[1] as f32, 0.0);
        let metres = found.local(bounds.centre()).z / scale;
        found.origin += metres * (off.x * found.right - off.y * found.up);
    }
    found.origin -= RAISED * size[1] as f32 * found.local(bounds.centre()).z / scale * found.up;
    found
}

/// From the box to the eye.
fn direction(bounds: Bounds, up: Vec3) -> Vec3 {
    // The box's long side lies across the picture.
    let extent = bounds.high - bounds.low;
    let level = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().filter(|axis| axis.dot(up).abs() < 0.5);
    let shortest = level.min_by(|a, b| a.dot(extent).total_cmp(&b.dot(extent)));
    // Of two equal ones the last, so that x goes across.
    let front = match shortest {
        Some(axis) if axis == Vec3::X && (extent.x - extent.z).abs() < 1e-3 * extent.z => Vec3::Z,
        Some(axis) => axis,
        None => up.any_orthonormal_vector(),
    };
    let side = up.cross(front);
    (front - 0.42 * side + 0.42 * up).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_fill_the_picture() {
        let flat = Bounds { low: Vec3::new(-2.0, 0.0, 1.0), high: Vec3::new(4.0, 0.2, 2.0) };
        let tall = Bounds { low: Vec3::ZERO, high: Vec3::new(0.1, 5.0, 0.2) };
        for bounds in [flat, tall, Bounds::EMPTY.or_unit()] {
            for up in [Vec3::Y, Vec3::Z] {
                let view = view(None, bounds, up, [1280, 720]);
                let pixels = bounds.corners().map(|corner| view.pixel(view.local(corner)));
                assert!(
                    pixels.iter().all(|p| p[0] > 0.0 && p[0] < 1280.0 && p[1] > 0.0 && p[1] < 720.0),
                    "{pixels:?}"
                );
                let extent = |axis: usize| {
                    let at = pixels.map(|p| p[axis]);
                    at.into_iter().fold(0.0, f32::max) - at.into_iter().fold(f32::INFINITY, f32::min)
                };
                assert!(extent(0) > 1100.0 || extent(1) > 500.0, "{bounds:?}: {} x {}", extent(0), extent(1));
            }
        }
    }
}
