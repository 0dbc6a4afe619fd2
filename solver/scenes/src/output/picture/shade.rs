//! Light: surfaces of bodies, the ground, the fluid over them. Blinn 1977, *Models of Light Reflection for Computer
//! Synthesized Pictures*; Schlick 1994, *An Inexpensive BRDF Model for Physically-Based Rendering*. No function of the
//! system's mathematics library is used, as their last bits differ from machine to machine.

use super::shadow::Shadow;
use super::splat::Fluid;
use glam::Vec3;
use volmap_figures::raster::{Fragment, View};

/// Above and below the horizon.
const SKY: [Vec3; 2] = [Vec3::new(0.925, 0.945, 0.97), Vec3::new(0.985, 0.988, 0.992)];
const GROUND: Vec3 = Vec3::new(0.955, 0.955, 0.95);
/// What the fluid mirrors.
const MIRRORED: Vec3 = Vec3::new(0.94, 0.97, 1.0);

/// The eye and the light.
#[derive(Clone, Copy)]
pub struct Light {
    /// The eye.
    pub view: View,
    /// Towards the light.
    pub direction: Vec3,
    /// Against gravity.
    pub up: Vec3,
}

/// What the light falls on but fluid.
pub struct Scenery<'a> {
    /// The light, and the eye with its samples.
    pub light: Light,
    /// Height of the ground along `up`, metres.
    pub ground: f32,
    /// Middle and size of what is shown, metres: the ground fades into the background around it.
    pub shown: (Vec3, f32),
    /// What lies in shadow.
    pub shadow: &'a Shadow,
    /// Colours of the materials.
    pub colours: &'a [Vec3],
}

impl Scenery<'_> {
    /// Colour and depth of the surface or ground at a place of the picture: of one of the pixel's four samples, or of
    /// the whole pixel.
    pub fn behind(&self, at: [f32; 2], solid: Fragment, phase: Option<usize>) -> (Vec3, f32) {
        let ray = self.light.view.ray(at);
        let height = at[1] / self.light.view.size[1] as f32;
        let sky = SKY[0].lerp(SKY[1], (1.6 * height).min(1.0));
        let ground = self.ground_depth(ray);
        if solid.depth == f32::INFINITY || ground < solid.depth {
            return (self.ground(ray, ground, sky, phase), ground);
        }
        let point = self.light.view.origin + solid.depth * ray;
        let normal = solid.normal.try_normalize().unwrap_or(self.light.up);
        let lit = normal.dot(self.light.direction).max(0.0);
        let lit = if lit > 0.0 { lit * self.light_at(point, phase) } else { 0.0 };
        let colour = self.colours.get(solid.material as usize).copied().unwrap_or(GROUND);
        let brightness = 0.67 + 0.10 * normal.dot(self.light.up) + 0.34 * lit;
        let gloss = 0.16 * lit.min(1.0) * self.light.gloss(normal, ray, 5);
        (colour * brightness + gloss, solid.depth)
    }

    fn light_at(&self, point: Vec3, phase: Option<usize>) -> f32 {
        match phase {
            Some(phase) => self.shadow.light_at(point, phase),
            None => self.shadow.mean_light_at(point),
        }
    }

    fn ground_depth(&self, ray: Vec3) -> f32 {
        let (fall, above) = (ray.dot(self.light.up), self.light.view.origin.dot(self.light.up) - self.ground);
        if fall < 0.0 && above > 0.0 { -above / fall } else { f32::INFINITY }
    }

    fn ground(&self, ray: Vec3, depth: f32, sky: Vec3, phase: Option<usize>) -> Vec3 {
        let (centre, size) = self.shown;
        let point = self.light.view.origin + depth * ray;
        let far = (point - centre).length() / (1.5 * size);
        // Also where it is NaN.
        if far.is_nan() || far >= 1.0 {
            return sky;
        }
        let light = self.light_at(point, phase);
        sky.lerp(GROUND * (0.66 + 0.34 * light), (1.0 - far * far) * (1.0 - far * far))
    }
}

impl Light {
    /// The light's mirror image: the cosine of the half angle to the power of 2^n.
    fn gloss(&self, normal: Vec3, ray: Vec3, n: u32) -> f32 {
        let half = (self.direction - ray.normalize_or_zero()).normalize_or_zero();
        (0..n).fold(normal.dot(half).max(0.0), |x, _| x * x)
    }

    /// The fluid's surface of this colour and normal.
    pub fn fluid(&self, at: [f32; 2], normal: Vec3, colour: Vec3) -> Vec3 {
        let ray = self.view.ray(at);
        let lit = normal.dot(self.direction).max(0.0);
        let brightness = 0.60 + 0.14 * normal.dot(self.up) + 0.34 * lit;
        let glance = (1.0 + normal.dot(ray) / ray.length()).clamp(0.0, 1.0);
        let mirrored = 0.42 * glance * glance * glance;
        (colour * brightness).lerp(MIRRORED, mirrored) + 0.55 * self.gloss(normal, ray, 6)
    }

    /// The normal of the fluid's surface at a pixel, by the smaller of the differences to both sides.
    pub fn fluid_normal(&self, fluid: &[Fluid], [column, row]: [usize; 2]) -> Vec3 {
        let [width, height] = self.view.size;
        let place = |column: usize, row: usize| {
            let depth = fluid[row * width + column].depth;
            depth * self.view.ray([column as f32 + 0.5, row as f32 + 0.5])
        };
        let depth = |column: usize, row: usize| fluid[row * width + column].depth;
        let here = depth(column, row);
        let centre = place(column, row);
        let slope = |before: Option<[usize; 2]>, after: Option<[usize; 2]>| -> Option<Vec3> {
            let change =
                |at: Option<[usize; 2]>| at.map_or(f32::INFINITY, |[c, r]| (depth(c, r) - here).abs());
            let (a, b) = (change(before), change(after));
            if a.min(b) == f32::INFINITY {
                return None;
            }
            match (before, after) {
                // Alike: their mean, which is smoother.
                (Some([c, r]), Some([d, s])) if a.max(b) < 4.0 * a.min(b) => Some(place(d, s) - place(c, r)),
                (Some([c, r]), _) if a <= b => Some(centre - place(c, r)),
                (_, Some([c, r])) => Some(place(c, r) - centre),
                _ => None,
            }
        };
        let left = column.checked_sub(1).map(|c| [c, row]);
        let right = (column + 1 < width).then(|| [column + 1, row]);
        let upper = row.checked_sub(1).map(|r| [column, r]);
        let lower = (row + 1 < height).then(|| [column, row + 1]);
        let to_eye = -self.view.ray([column as f32 + 0.5, row as f32 + 0.5]);
        match (slope(left, right), slope(upper, lower)) {
            (Some(across), Some(down)) => {
                let normal = down.cross(across).normalize_or(to_eye);
                if normal.dot(to_eye) < 0.0 { -normal } else { normal }
            }
            _ => to_eye.normalize(),
        }
    }
}

/// Part of the light that comes through so much fluid, in particle radii: thin films stay visible, bodies shine through
/// shallow water.
pub fn transmittance(thickness: f32) -> f32 {
    0.72 * falling(thickness) + 0.28 * falling(thickness / 14.0)
}

/// About exp(-x): 1 / (1 + x/16)^16.
fn falling(x: f32) -> f32 {
    let root = 1.0 / (1.0 + x / 16.0);
    (0..4).fold(root, |y, _| y * y)
}
