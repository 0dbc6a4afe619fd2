//! What a bake says of itself: the informative attributes of the asset, and warnings.
//! Nothing here may depend on time or threads.

use crate::doubt::{MAX_SIGN_DISAGREEMENTS, has_solid};
use crate::input::Input;
use crate::maps::Maps;
use crate::parameters::{self, Baked};
use crate::recipe::BakeSettings;
use crate::summary::Summary;
use crate::tolerance::MeasuredError;
use crate::units::Lengths;
use crate::volume_map::quadrature::Rule;
use volmap_formats::asset::{Attributes, Value};
use volmap_formats::text::percent;

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
        ("flipped_triangles", count(repair.flipped_triangles)),
        ("welded_vertices", count(cleaning.welded)),
        ("degenerate_faces", count(cleaning.degenerate)),
        ("duplicate_faces", count(cleaning.duplicates)),
        ("warnings", summary.warnings.join("\n").into()),
    ]);
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

/// What a careful person would look at before using the asset. The texts stand in assets: other words would be other
/// bytes, so these still name the command line's options.
pub fn warnings(summary: &Summary, maps: &Maps, settings: &BakeSettings, lengths: &Lengths) -> Vec<String> {
    let mut out: Vec<String> = lengths.suspicion().into_iter().collect();
    mesh_warnings(summary, &mut out);
    sign_warnings(summary, maps, settings.check_sign, &mut out);
    let [low, high] = summary.plan.cut;
    let cut = low.iter().chain(&high).copied().fold(0.0, f64::max);
    if cut > 0.0 {
        out.push(format!(
            "the domain cuts the band of 2 support radii by up to {cut:.4} m; outside the domain the map \
             answers as far from the surface"
        ));
    }
    let cell = summary.plan.grid.cell_size.max_element();
    if cell > 1.5 * summary.plan.support_radius {
        out.push(format!(
            "the cells are {:.1} support radii large: too coarse for the volume; take more cells",
            cell / summary.plan.support_radius
        ));
    }
    if settings.map.thickness != 0.0 {
        out.push(format!("the surface is moved {} m out of the solid (--thickness)", settings.map.thickness));
    }
    out
}

fn mesh_warnings(summary: &Summary, out: &mut Vec<String>) {
    let found = &summary.diagnosis;
    if let Some(hole) = found.boundary_loops.first() {
        let [x, y, z] = hole.centroid;
        out.push(format!(
            "the mesh is open: {} rim{}, the longest {:.4} m long around ({x:.4}, {y:.4}, {z:.4}); close it, or \
             check the sign there",
            found.boundary_loop_count,
            plural(found.boundary_loop_count),
            hole.length
        ));
    }
    if found.non_manifold_edges.count > 0 {
        let n = found.non_manifold_edges.count;
        out.push(format!(
            "{n} edge{} with more than two faces{}",
            plural(n),
            place(&found.non_manifold_edges.places)
        ));
    }
    if found.misoriented_edges.count > 0 {
        let n = found.misoriented_edges.count;
        let places = place(&found.misoriented_edges.places);
        out.push(format!("{n} edge{} whose faces don't run the same way round{places}", plural(n)));
    }
    let flipped = summary.repair.flipped_triangles;
    if flipped > 0 {
        out.push(format!("flipped {flipped} triangle{} to a consistent orientation", plural(flipped)));
    }
    if found.nested_solids.count > 0 {
        let n = found.nested_solids.count;
        out.push(format!(
            "{n} part{} inside a solid; taken as solid{}",
            plural(n),
            place(&found.nested_solids.places)
        ));
    }
}

fn sign_warnings(summary: &Summary, maps: &Maps, all_compared: bool, out: &mut Vec<String>) {
    if !has_solid(maps.distance.iter().copied(), summary.plan.support_radius) {
        out.push(
            "no node lies inside: the map has no solid; give sheets a --thickness, and thin parts smaller \
            cells"
                .into(),
        );
    }
    let leaks = summary.leaks;
    if leaks > 0 {
        out.push(format!(
            "the sign flips across {leaks} cell faces far from the surface: a hole is wider than two support radii; \
             close the mesh or enlarge the support radius"
        ));
    }
    let signs = summary.sign_comparison.as_ref();
    let worst = signs.and_then(|signs| signs.worst.first()).map(|(at, distance)| (place(&[*at]), *distance));
    let (at, distance) = worst.unwrap_or_default();
    let doubt = summary.sign_doubt();
    if doubt > MAX_SIGN_DISAGREEMENTS {
        out.push(format!(
            "the sign is in doubt at about {} of the nodes, up to {distance:.4} m from the surface{at}; close the \
             holes, or turn the faces one way round",
            percent(doubt)
        ));
    }
    if let Some(signs) = signs.filter(|signs| all_compared && signs.disagreeing > 0) {
        out.push(format!(
            "pseudonormals and winding numbers differ at {} of {} nodes, the farthest {distance:.4} m from the \
             surface{at}",
            signs.disagreeing, signs.points
        ));
    }
}

fn plural(n: usize) -> &'static str {
    if n == 1 { "" } else { "s" }
}

fn place(places: &[[f64; 3]]) -> String {
    match places.first() {
        Some([x, y, z]) => format!(", as at ({x:.4}, {y:.4}, {z:.4})"),
        None => String::new(),
    }
}
