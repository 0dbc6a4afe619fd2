//! What a density map can be asked for.

use crate::volume_map::quadrature::{Point, Rule};
use volmap_formats::asset::{Array, DensityField};
use volmap_formats::text::number;
use volmap_runtime::KernelKind;

/// The SPH kernels W that a density map can be baked for: those of the file's format.
pub const KERNELS: [KernelKind; 2] = [KernelKind::CubicSpline, KernelKind::WendlandC2];

/// One of [`KERNELS`] by its name, or `cubic` or `wendland` for short.
///
/// # Errors
/// Another name; the message has those that can be taken.
pub fn parse_kernel(text: &str) -> Result<KernelKind, String> {
    let known = text.parse().ok().filter(|kernel| KERNELS.contains(kernel));
    known.ok_or_else(|| {
        format!("`{text}` is no kernel of density maps; take {}", KERNELS.map(KernelKind::name).join(" or "))
    })
}

/// What a density map depends on beside the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensitySettings {
    /// The SPH kernel W, whose support radius is the map's.
    pub kernel: KernelKind,
    /// How the density is integrated. W vanishes at the edge of the ball, so the Gauss-Legendre rules, whose error
    /// comes from there, are better here than those made for the ball; and a gradient takes an exact rule.
    pub rule: Rule,
    /// Where gamma becomes 0, in support radii: 1 in Eq. 11; SPlisHSPlasH takes 1/5.
    pub extension: f64,
}

/// Part of the kernel's integral that a rule may miss.
const MOST_MISSED: f64 = 0.25;

impl Default for DensitySettings {
    fn default() -> Self {
        DensitySettings { kernel: KernelKind::default(), rule: Rule::GaussLegendre(50), extension: 1.0 }
    }
}

impl DensitySettings {
    /// The rule's points in the unit ball, with W of unit support in their weights.
    pub fn points(&self) -> Vec<Point> {
        let weighted =
            |p: Point| Point { weight: p.weight * self.kernel.unit_value(p.position.length()), ..p };
        self.rule.points().into_iter().map(weighted).collect()
    }

    /// Whether the rule knows the kernel at all: W integrates to 1, which coarse rules miss.
    ///
    /// # Errors
    /// In words, with the cure.
    pub fn check(&self) -> Result<(), String> {
        let integral: f64 = self.points().iter().map(|p| p.weight).sum();
        if (integral - 1.0).abs() <= MOST_MISSED {
            return Ok(());
        }
        let by = Self::default().rule;
        Err(format!(
            "{} is too coarse for the kernel {}: its integral comes out as {}, not 1; take {by}",
            self.rule,
            self.kernel,
            number(integral)
        ))
    }

    /// The largest density, over rest density, at points up to `depth` inside the solid (metres): that of a half space.
    pub fn largest(&self, depth: f64, support_radius: f64) -> f64 {
        1.0 + depth / (self.extension * support_radius)
    }

    /// What is stored of a density.
    pub fn field(&self, support_radius: f64, values: Array) -> DensityField {
        let points = self.points();
        DensityField {
            kernel: self.kernel.to_string(),
            extension_length: self.extension * support_radius,
            quadrature: self.rule.to_string(),
            degree: self.rule.degree(),
            points: points.len() as u64,
            kernel_integral: points.iter().map(|p| p.weight).sum(),
            values,
        }
    }
}
