//! The frame of the tree, in which distances fit into single precision.

use glam::DVec3;

/// The tree's frame: a point x of the mesh is at (x - centre) * scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub centre: DVec3,
    /// A power of two, so that scaling is exact.
    pub scale: f64,
}

impl Frame {
    pub fn local(&self, p: DVec3) -> [f32; 3] {
        ((p - self.centre) * self.scale).to_array().map(|x| x as f32)
    }

    /// By how much a distance in the frame can be too long in single precision, other than relatively:
    /// the query point is rounded by half a unit in its last place.
    pub fn slack(local: [f32; 3]) -> f64 {
        let size = local[0].abs().max(local[1].abs()).max(local[2].abs());
        2e-7 * f64::from(size) + 1e-15
    }

    /// Search radius in the frame, rounded up by more than a box test can err. Its square is finite, so
    /// that an empty box, at infinity, is beyond it.
    #[inline]
    pub fn radius(&self, distance_squared: f64, slack: f64) -> f32 {
        let radius = (distance_squared.sqrt() * self.scale + slack) * (1.0 + 1e-6);
        (radius as f32).min(1.8e19)
    }
}
