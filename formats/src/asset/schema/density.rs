//! The boundary density as it is stored: Koschier and Bender 2017, *Density Maps for Improved SPH Boundary Handling*;
//! Eq. 9 to 11 of Bender et al. 2020. Only files of versions 2 and 4 have it.

use super::{DENSITY, Reader};
use crate::asset::error::AssetError;
#[cfg(feature = "write")]
use crate::asset::tree::Dataset;
use crate::asset::tree::{Array, Tree};

/// Eq. 11, the one extension function of the density.
const EXTENSION: &str = "linear";

/// Boundary density at the nodes, and what it depends on beside the geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityField {
    /// The kernel W in the integral, whose support is the asset's: `cubic_spline`, `wendland_c2`.
    pub kernel: String,
    /// Distance from the surface where the extension function becomes 0, metres: r in Eq. 11.
    pub extension_length: f64,
    /// Name of the rule that integrated it.
    pub quadrature: String,
    /// Polynomial exactness of the rule.
    pub degree: u32,
    /// Points of the rule inside the ball.
    pub points: u64,
    /// What the rule gives the integral of W over the ball; the exact one is 1.
    pub kernel_integral: f64,
    /// rho_B / rho0 (Eq. 9) at the nodes, without unit, in the precision of the other fields.
    pub values: Array,
}

#[cfg(feature = "write")]
pub(super) fn dataset(field: &DensityField) -> Dataset {
    let description = "boundary density over rest density, Eq. 9 of Bender et al. 2020";
    let mut dataset = super::field_dataset(&field.values, "1", description);
    dataset.attributes.extend(super::attributes([
        ("kernel", field.kernel.as_str().into()),
        ("extension_function", EXTENSION.into()),
        ("extension_length", field.extension_length.into()),
        ("quadrature", field.quadrature.as_str().into()),
        ("degree", u64::from(field.degree).into()),
        ("points", field.points.into()),
        ("kernel_integral", field.kernel_integral.into()),
    ]));
    dataset
}

/// The density of a tree, if it has one.
pub(super) fn from_tree(tree: &mut Tree) -> Result<Option<DensityField>, AssetError> {
    let Some(dataset) = tree.datasets.get(DENSITY) else { return Ok(None) };
    let attributes = Reader { path: DENSITY, attributes: Some(&dataset.attributes) };
    attributes.expect("extension_function", EXTENSION)?;
    let [degree] = attributes.integers("degree")?;
    let [points] = attributes.integers("points")?;
    let field = DensityField {
        kernel: attributes.text("kernel")?,
        extension_length: attributes.real("extension_length")?,
        quadrature: attributes.text("quadrature")?,
        degree: u32::try_from(degree).map_err(|_| attributes.invalid("degree", "is too large"))?,
        points,
        kernel_integral: attributes.real("kernel_integral")?,
        values: Array::F32(Vec::new()),
    };
    Ok(Some(DensityField { values: super::field(tree, DENSITY)?, ..field }))
}
