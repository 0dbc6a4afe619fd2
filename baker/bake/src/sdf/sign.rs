//! How inside and outside are told apart.

use crate::mesh::diagnosis::Diagnosis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How inside and outside are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum SignMethod {
    /// The best method for the mesh.
    #[default]
    Auto,
    /// Angle-weighted pseudonormals: fast, right only for closed, oriented surfaces that don't intersect
    /// themselves.
    Pseudonormal,
    /// Winding number above one half: for holes, overlaps and soups.
    Winding,
}

/// A method, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignChoice {
    /// Never `Auto`.
    pub method: SignMethod,
    /// For a report.
    pub reason: String,
}

/// Winding numbers, whatever the mesh, and how far they can be trusted.
///
/// Pseudonormals are wrong wherever a surface intersects itself, and no cheap test rules that out: of 84
/// closed meshes from modelling, scanning and CAD that were tried, 6 of a single component did (two of
/// them because concave polygons had been cut into fans), one in so small a place that it showed at 1 of
/// 41,000 points near the surface. Winding numbers take the union, and cost about as much as the
/// distance. Pseudonormals are there for comparison, and on demand.
pub fn choose_sign(diagnosis: &Diagnosis) -> SignChoice {
    let trust = if diagnosis.balanced {
        "exact, because the mesh is closed and consistently oriented"
    } else if !diagnosis.oriented {
        "doubtful, because triangles do not run the same way round"
    } else {
        "an approximation near holes, because the surface is not closed"
    };
    SignChoice { method: SignMethod::Winding, reason: format!("winding number: {trust}") }
}
