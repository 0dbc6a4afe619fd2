//! What a bake says of itself: the informative attributes of the asset.
//! Nothing here may depend on time or threads.

use crate::adaptive::Adapted;
use crate::input::Input;
use crate::parameters::{self, Baked};
use crate::recipe::BakeSettings;
use crate::summary::Summary;
use crate::tolerance::MeasuredError;
use crate::volume_map::quadrature::Rule;
use volmap_formats::asset::{Attributes, Value};

fn attributes<const N: usize>(pairs: [(&str, Value); N]) -> Attributes {
    pairs.map(|(name, value)| (name.to_owned(), value)).into()
}

fn count(n: usize) -> Value {
    Value::from(n as u64)
}

/// Effective value of every parameter, given or defaulted, and the error that was measured for a tolerance.
pub fn parameters(input: &Input, summary: &Summary, settings: &BakeSettings) -> Attributes {
    let mut out = parameters::describe(&Baked { input, settings, summary });
    if let Some(found) = &summary.tolerance {
        out.extend(measured_error(&found.error, found.reference));
    }
    if let Some(found) = &summary.adapted {
        out.extend(measured_error(&found.errors.volume, found.reference));
        out.extend(adapted(found));
    }
    out
}

/// How exact distance and normal are, and what stayed above the tolerance.
fn adapted(found: &Adapted) -> Attributes {
    let errors = &found.errors;
    let mut out = attributes([
        ("distance_error_max", errors.distance.max.into()),
        ("distance_error_rms", errors.distance.rms.into()),
        ("normal_error_99", errors.normal.max.to_degrees().into()),
        ("cells_above_tolerance", count(found.left)),
    ]);
    if let Some(at) = found.left_at {
        out.insert("above_tolerance_at".into(), at.into());
    }
    out
}

/// Names of what [`measured_error`] says; the first is that of the largest error.
pub const VOLUME_ERROR_MAX: &str = "volume_error_max";
/// Root mean square.
pub const VOLUME_ERROR_RMS: &str = "volume_error_rms";
/// Number of points.
pub const VOLUME_ERROR_POINTS: &str = "volume_error_points";

/// How exact the volume is, as a part of the full ball, and against what.
pub fn measured_error(error: &MeasuredError, reference: Rule) -> Attributes {
    attributes([
        (VOLUME_ERROR_MAX, error.max.into()),
        (VOLUME_ERROR_RMS, error.rms.into()),
        (VOLUME_ERROR_POINTS, count(error.points)),
        ("volume_error_reference", reference.to_string().into()),
    ])
}

/// Where the map comes from.
pub fn source(input: &Input, summary: &Summary) -> Attributes {
    attributes([
        ("file", input.source.file.as_str().into()),
        ("format", input.source.format.as_str().into()),
        ("blake3", input.source.blake3.as_str().into()),
        ("triangles", count(input.mesh.triangles.len())),
        ("vertices", count(input.mesh.vertices.len())),
        ("bounds_min", summary.bounds[0].to_array().into()),
        ("bounds_max", summary.bounds[1].to_array().into()),
        ("area", summary.diagnosis.area.into()),
        ("program", "volmap".into()),
        ("program_version", env!("CARGO_PKG_VERSION").into()),
    ])
}

/// Name of what the diagnosis says of signs that aren't exact: the part of the nodes at which they are in doubt.
pub const SIGN_DOUBT: &str = "sign_doubt";

/// What was found of the mesh.
pub fn diagnosis(summary: &Summary) -> Attributes {
    let (found, repair, cleaning) = (&summary.diagnosis, &summary.repair, &summary.cleaning);
    let mut out = attributes([
        ("closed", found.closed.into()),
        ("oriented", found.oriented.into()),
        ("manifold", (found.manifold_edges && found.manifold_vertices).into()),
        ("components", count(found.components)),
        ("euler_characteristic", Value::Real(vec![found.euler_characteristic as f64])),
        ("volume", found.volume.into()),
        ("boundary_edges", count(found.boundary_edges.count)),
        ("boundary_loops", count(found.boundary_loop_count)),
        ("non_manifold_edges", count(found.non_manifold_edges.count)),
        ("misoriented_edges", count(found.misoriented_edges.count)),
        ("inside_out_components", count(found.inside_out_components.count)),
        ("cavities", count(found.cavities.count)),
        ("nested_solids", count(found.nested_solids.count)),
        ("overlapping_pairs", count(summary.overlaps.pairs)),
        ("hidden_triangles", count(summary.overlaps.hidden)),
        ("hidden_area", summary.overlaps.hidden_area.into()),
        ("thin_walls", count(summary.thin.walls.count)),
        ("thin_gaps", count(summary.thin.gaps.count)),
        ("flipped_triangles", count(repair.flipped_triangles)),
        ("welded_vertices", count(cleaning.welded)),
        ("degenerate_faces", count(cleaning.degenerate)),
        ("duplicate_faces", count(cleaning.duplicates)),
        ("warnings", summary.warnings.join("\n").into()),
    ]);
    if summary.thin.rods.count > 0 {
        out.insert("thin_rods".into(), count(summary.thin.rods.count));
    }
    if !found.boundary_loops.is_empty() {
        let loops = || found.boundary_loops.iter();
        let centers = loops().flat_map(|rim| rim.centroid).collect();
        out.insert("boundary_loop_lengths".into(), Value::Real(loops().map(|rim| rim.length).collect()));
        out.insert("boundary_loop_centers".into(), Value::Real(centers));
    }
    if let Some(signs) = &summary.sign_comparison {
        out.insert("sign_points".into(), count(signs.points));
        out.insert("sign_disagreements".into(), count(signs.disagreeing));
    }
    if !summary.has_exact_sign {
        out.insert(SIGN_DOUBT.into(), summary.sign_doubt().into());
    }
    out
}
