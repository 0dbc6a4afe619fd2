//! Closures: from the volume of the boundary to its density and density gradient at a particle, which the map leaves
//! open. Bender et al. 2020, section 4.3, and what makes it exact at a flat wall.
//!
//! - `paper` (Eq. 14 and 15): all of V at the closest point x*, rho_B = rho_0 V W(|x - x*|). At a flat wall and
//!   r = 4 rp this is 18 to 40 times the integral of W over the solid, so particles keep 2.3 to 2.8 rp away.
//! - `offset`: what SPlisHSPlasH computes up to version 2.18, x* = x - max(Phi + rp/2, 2 rp) n, with 0.8 V;
//!   4 to 12 times the integral.
//! - `calibrated`: with the half space's density R(d), its volume V_plane(d) and beta(d) ([`plane`])
//!   ```text
//!   rho_B      = rho_0 R(Phi)  (V / V_plane(Phi))^beta(Phi)
//!   grad rho_B = rho_0 R'(Phi) (V / V_plane(Phi))^beta(Phi) n
//!   ```
//!   the integral itself at a flat wall, and to first order in curvature on bowls and balls.
//! - `wedge`: the same, but where V < V_plane the exponent grows with the deficit up to what a convex edge of 90 degrees
//!   needs ([`wedge`]); a second look at the map, into the solid, tells edges from balls
//!   ([`Closure::density_probing`]).
//! - `lattice`: as `calibrated`, R being what a half space of particles on a lattice adds instead of a continuum
//!   ([`lattice`]), so that a fluid's layers rest at rp, 3 rp, ..
//! - `mirror`: what the fluid's mirror image adds ([`mirror`]), as a function of the volume alone, of a map with a quarter of
//!   the kernel's support radius ([`image`]): value, slope and mirrored pressure belong together, so that a fluid comes to
//!   rest, at rp from walls and calmly, in edges and corners too.
//!
//! The gradient of these is that along the normal, at constant V / V_plane; with the gradient of V, which the map
//! gives too, it is the true one ([`Closure::density_with_gradient`]).
//!
//! The map is the same for all kernels; its support radius is that of the kernel, or for `mirror` a quarter of it
//! ([`ClosureKind::map_radius`]). Tables are computed when a [`Closure`] is made, which takes milliseconds, and only read
//! afterwards.
//!
//! Inside the solid (Phi < 0) every closure's density grows with depth and its gradient keeps its direction, so that
//! pressure pushes a particle out: `paper` continues W oddly about the surface (2 W(0) - W, slope W'), the others
//! continue R along its tangent, `mirror` until the ball is full of solid, at a depth of r / 4.

mod image;
mod lattice;
mod mirror;
mod plane;
pub(crate) mod quadrature;
mod table;
mod wall;
mod wedge;

use crate::kernel::Kernel;
use crate::query::{Boundary, Sample};
use glam::DVec3;
use image::Image;
use std::fmt;
use std::str::FromStr;
use wall::Walls;

/// How a volume becomes a density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ClosureKind {
    /// All the volume at the closest point: Bender et al. 2020, Eq. 14.
    Paper,
    /// The volume at a point behind the surface, as SPlisHSPlasH has it.
    Offset,
    /// Exact at a flat wall and to first order in curvature.
    #[default]
    Calibrated,
    /// As `calibrated`, and close to exact at convex edges.
    Wedge,
    /// As `calibrated`, from a lattice of particles in the wall: for fluids whose particles lie in layers.
    Lattice,
    /// From the fluid's mirror image, by maps of a quarter of the kernel's support radius: particles rest at one particle
    /// radius from a wall, calmly.
    Mirror,
}

impl ClosureKind {
    /// All of them.
    pub const ALL: [ClosureKind; 6] = [
        ClosureKind::Paper,
        ClosureKind::Offset,
        ClosureKind::Calibrated,
        ClosureKind::Wedge,
        ClosureKind::Lattice,
        ClosureKind::Mirror,
    ];

    /// Whether there is one for kernels in two dimensions.
    pub fn is_in_plane(self) -> bool {
        matches!(self, ClosureKind::Paper | ClosureKind::Offset | ClosureKind::Mirror)
    }

    /// The support radius (metres) of the maps that it takes, for a kernel of this one.
    pub fn map_radius(self, support_radius: f64) -> f64 {
        match self {
            ClosureKind::Mirror => support_radius / image::MAPS_PER_RADIUS,
            _ => support_radius,
        }
    }

    fn name(self) -> &'static str {
        match self {
            ClosureKind::Paper => "paper",
            ClosureKind::Offset => "offset",
            ClosureKind::Calibrated => "calibrated",
            ClosureKind::Wedge => "wedge",
            ClosureKind::Lattice => "lattice",
            ClosureKind::Mirror => "mirror",
        }
    }
}

impl fmt::Display for ClosureKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ClosureKind {
    type Err = String;

    fn from_str(text: &str) -> Result<ClosureKind, String> {
        let known = ClosureKind::ALL.into_iter().find(|kind| kind.name() == text);
        known.ok_or_else(|| {
            format!("`{text}` is no closure; take {}", ClosureKind::ALL.map(Self::name).join(", "))
        })
    }
}

/// What the boundary adds to the density of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryDensity {
    /// rho_B over the fluid's rest density.
    pub density: f64,
    /// Its gradient at the particle, 1/m; against the normal.
    pub gradient: DVec3,
    /// The sample point x*, metres: where forces on the body act.
    pub point: DVec3,
}

/// The factor on V that SPlisHSPlasH applies up to version 2.18: its particles have 0.8 (2 rp)^3 instead of the cube's
/// volume, and so its boundaries have less as well.
const OFFSET_FACTOR: f64 = 0.8;

/// Depth below the surface, in support radii, at which a probe tells an edge from a ball.
const PROBE_DEPTH: f64 = 0.25;

/// How much nearer than [`PROBE_DEPTH`] to the surface, in parts of it, a probe at an edge is: of 90 degrees 0.29, of
/// 120 degrees 0.13. Below it the exponent is led over to that of a ball.
const PROBE_EDGE: f64 = 0.15;

/// A closure for one kernel and particle size.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    kind: ClosureKind,
    kernel: Kernel,
    particle_radius: f64,
    tables: Tables,
}

/// What the kinds need.
#[derive(Clone, Debug, PartialEq)]
enum Tables {
    /// All the volume at one point.
    Point,
    Walls(Walls),
    Image(Image),
}

impl Closure {
    /// A closure for particles of radius rp = `particle_radius` (metres, positive and finite; half of their spacing), and for
    /// maps of [`ClosureKind::map_radius`]. With a kernel in two dimensions for maps in two, of the kinds that
    /// [`ClosureKind::is_in_plane`]; the others are then of no use.
    pub fn new(kind: ClosureKind, kernel: Kernel, particle_radius: f64) -> Closure {
        let tables = match kind {
            ClosureKind::Paper | ClosureKind::Offset => Tables::Point,
            ClosureKind::Mirror => Tables::Image(Image::new(kernel, particle_radius)),
            _ => Tables::Walls(Walls::new(kind, kernel, particle_radius)),
        };
        Closure { kind, kernel, particle_radius, tables }
    }

    /// Which one it is.
    pub fn kind(&self) -> ClosureKind {
        self.kind
    }

    /// The kernel it was made for.
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// The particle radius it was made for, metres.
    pub fn particle_radius(&self) -> f64 {
        self.particle_radius
    }

    /// Density, gradient and sample point for a particle at `position` that sees `boundary`; `None` where the boundary
    /// adds nothing. `wedge` takes what bends away from the particle for an edge.
    #[inline]
    pub fn density(&self, boundary: &Boundary, position: DVec3) -> Option<BoundaryDensity> {
        self.answer(boundary, position, None, |_| 1.0)
    }

    /// As [`Closure::density`], with the true gradient of the density, from that of the volume
    /// ([`VolumeMap::sample_with_gradient`](crate::VolumeMap::sample_with_gradient); m^2). `paper` and `offset` have no
    /// use for it.
    #[inline]
    pub fn density_with_gradient(
        &self,
        boundary: &Boundary,
        volume_gradient: DVec3,
        position: DVec3,
    ) -> Option<BoundaryDensity> {
        self.answer(boundary, position, Some(volume_gradient), |_| 1.0)
    }

    /// As [`Closure::density`], or with a gradient of the volume as [`Closure::density_with_gradient`], where `wedge` asks
    /// for the distance (metres) at a second point below the surface, for particles that see much less volume than a
    /// flat wall's: `|x| map.values(x).distance`. The other closures don't ask.
    #[inline]
    pub fn density_probing(
        &self,
        boundary: &Boundary,
        volume_gradient: Option<DVec3>,
        position: DVec3,
        distance: impl FnOnce(DVec3) -> f64,
    ) -> Option<BoundaryDensity> {
        let depth = PROBE_DEPTH * self.kernel.support_radius();
        self.answer(boundary, position, volume_gradient, |boundary| {
            let nearer = 1.0 + distance(boundary.closest_point - depth * boundary.normal) / depth;
            (nearer / PROBE_EDGE).clamp(0.0, 1.0)
        })
    }

    /// [`Closure::density`] of every sample and its position, into `densities`, whose old content is dropped. A sample
    /// deep inside gives `None`, as one outside does: the way out is unknown there.
    pub fn density_batch(
        &self,
        samples: &[Sample],
        positions: &[DVec3],
        densities: &mut Vec<Option<BoundaryDensity>>,
    ) {
        densities.clear();
        let density = |(sample, position): (&Sample, &DVec3)| self.density(&sample.near()?, *position);
        densities.extend(samples.iter().zip(positions).map(density));
    }

    /// The solid's volume (m^3) in the ball of the kernel's support radius r, for what else than density weighs a boundary by it.
    /// A map of a smaller radius doesn't know it: it is then that of a flat wall, led to zero between r/4 and r/2, where
    /// the map ends.
    pub fn volume(&self, boundary: &Boundary) -> f64 {
        match &self.tables {
            Tables::Image(image) => image.wide_volume(boundary.distance),
            Tables::Point | Tables::Walls(_) => boundary.volume,
        }
    }

    /// `sharpness` says how much of an edge, 0 to 1, a place is that could be one.
    #[inline]
    fn answer(
        &self,
        boundary: &Boundary,
        position: DVec3,
        volume_gradient: Option<DVec3>,
        sharpness: impl FnOnce(&Boundary) -> f64,
    ) -> Option<BoundaryDensity> {
        if !(boundary.volume > 0.0 && boundary.distance < self.kernel.support_radius()) {
            return None;
        }
        match &self.tables {
            Tables::Point if self.kind == ClosureKind::Paper => Some(self.paper(boundary)),
            Tables::Point => self.offset(boundary, position),
            Tables::Walls(walls) => Some(walls.density(boundary, volume_gradient, || sharpness(boundary))),
            Tables::Image(image) => image.density(boundary, volume_gradient),
        }
    }

    fn paper(&self, boundary: &Boundary) -> BoundaryDensity {
        let distance = boundary.distance.abs();
        let value = self.kernel.value(distance);
        let value = if boundary.distance < 0.0 { 2.0 * self.kernel.value(0.0) - value } else { value };
        BoundaryDensity {
            density: boundary.volume * value,
            gradient: boundary.volume * self.kernel.derivative(distance) * boundary.normal,
            point: boundary.closest_point,
        }
    }

    fn offset(&self, boundary: &Boundary, position: DVec3) -> Option<BoundaryDensity> {
        let distance = (boundary.distance + 0.5 * self.particle_radius).max(2.0 * self.particle_radius);
        let volume = OFFSET_FACTOR * boundary.volume;
        (distance < self.kernel.support_radius()).then(|| BoundaryDensity {
            density: volume * self.kernel.value(distance),
            gradient: volume * self.kernel.derivative(distance) * boundary.normal,
            point: position - distance * boundary.normal,
        })
    }
}

#[cfg(test)]
mod tests;
