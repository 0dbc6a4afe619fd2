//! From the world to pixels: a perspective or a parallel projection.

use glam::Vec3;

/// A projection. Places on the picture are pixels from its upper left corner, depth is along `forward`, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye; for a parallel view any point of depth 0.
    pub origin: Vec3,
    /// To the right on the picture.
    pub right: Vec3,
    /// Up on the picture.
    pub up: Vec3,
    /// Into the picture.
    pub forward: Vec3,
    /// Pixels.
    pub size: [usize; 2],
    /// Pixels a metre; of a perspective view at depth 1 m.
    pub scale: f32,
    /// Parallel rays instead of rays through the eye.
    pub parallel: bool,
    /// Nothing nearer is seen, metres.
    pub near: f32,
}

impl View {
    /// A point as metres to the right, up, and into the picture, from the origin.
    #[inline]
    pub fn local(&self, point: Vec3) -> Vec3 {
        let from = point - self.origin;
        Vec3::new(from.dot(self.right), from.dot(self.up), from.dot(self.forward))
    }

    /// Pixels a metre at a depth.
    #[inline]
    pub fn scale_at(&self, depth: f32) -> f32 {
        if self.parallel { self.scale } else { self.scale / depth }
    }

    /// Where a point of [`View::local`] is on the picture.
    #[inline]
    pub fn pixel(&self, local: Vec3) -> [f32; 2] {
        let scale = self.scale_at(local.z);
        let [width, height] = self.size.map(|n| n as f32);
        [0.5 * width + scale * local.x, 0.5 * height - scale * local.y]
    }

    /// The direction from the eye through a place of the picture, of length 1 along `forward`.
    #[inline]
    pub fn ray(&self, [x, y]: [f32; 2]) -> Vec3 {
        let [width, height] = self.size.map(|n| n as f32);
        // In a loop over pixels it is divided once.
        let pixel = 1.0 / self.scale;
        let (across, up) = ((x - 0.5 * width) * pixel, (0.5 * height - y) * pixel);
        self.forward + across * self.right + up * self.up
    }

    /// The same view in so many times as many pixels.
    pub fn finer(&self, times: usize) -> View {
        View { size: self.size.map(|n| n * times), scale: self.scale * times as f32, ..*self }
    }
}
