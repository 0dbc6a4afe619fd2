//! What a map answers.

use glam::DVec3;

/// What the map says of a point: where it is, and in the band what was asked for ([`Surface`] as a rule).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample<T = Surface> {
    /// In the band: the surface is near.
    Near(T),
    /// Farther from the solid than the band: no boundary volume.
    Outside,
    /// Deeper in the solid than the band: the whole ball is solid, the way out is unknown.
    DeepInside,
}

/// The solid's surface as a particle near it sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Signed distance Phi, metres, negative inside the solid (Eq. 10).
    pub distance: f64,
    /// Direction of the gradient of Phi, away from the solid, of length 1; zero where the gradient vanishes.
    pub normal: DVec3,
    /// Point of the surface closest to the sample, x - Phi n, metres.
    pub closest_point: DVec3,
    /// Volume of the solid in the ball of the support radius, m^3 (Eq. 12); in two dimensions area in the disc, m^2.
    pub volume: f64,
}

/// The surface, and how its volume changes from place to place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceWithGradient {
    /// The surface.
    pub surface: Surface,
    /// Gradient of the volume, m^2 (m in two dimensions): that of the interpolated volume, which jumps a little between
    /// cells.
    pub volume_gradient: DVec3,
}

/// Distance and volume alone, where the direction doesn't matter; defined everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// Signed distance Phi, metres; infinite where it is unknown: positive outside the band, negative deep inside.
    pub distance: f64,
    /// Volume of the solid in the ball of the support radius, m^3; 0 outside, that of the full ball deep inside.
    pub volume: f64,
}

/// The density that a map holds, as a particle sees it; the caller multiplies by its rest density rho0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapDensity {
    /// rho_B / rho0 (Eq. 9), without unit. About 1 at the surface of a flat wall, and more in the solid.
    pub value: f64,
    /// Its gradient, 1/m, towards the solid.
    pub gradient: DVec3,
}

impl<T> Sample<T> {
    /// What was asked for, if the surface is near.
    pub fn near(self) -> Option<T> {
        match self {
            Sample::Near(near) => Some(near),
            Sample::Outside | Sample::DeepInside => None,
        }
    }

    /// The same place with another content.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Sample<U> {
        match self {
            Sample::Near(near) => Sample::Near(change(near)),
            Sample::Outside => Sample::Outside,
            Sample::DeepInside => Sample::DeepInside,
        }
    }
}
