//! What a careful person would look at before using an asset: warnings, each with its place and cure.

use crate::adaptive::Adapted;
use crate::doubt::{MAX_SIGN_DISAGREEMENTS, has_solid};
use crate::mesh::diagnosis::Defect;
use crate::recipe::BakeSettings;
use crate::sdf::Overlaps;
use crate::settings::Tolerances;
use crate::summary::Summary;
use crate::units::Lengths;
use volmap_formats::text::{number, percent, significant, thousands};

/// Steps of the coordinates that are no matter, as a part of a cell.
const COARSEST_STEP: f64 = 0.1;

/// The warnings of a bake. The texts stand in assets: other words are other bytes.
pub fn warnings(
    summary: &Summary,
    distances: &[f64],
    settings: &BakeSettings,
    lengths: &Lengths,
) -> Vec<String> {
    let mut out: Vec<String> = lengths.suspicion().into_iter().collect();
    mesh_warnings(summary, &mut out);
    overlap_warning(summary, &mut out);
    sign_warnings(summary, distances, settings, &mut out);
    size_warnings(summary, settings, &mut out);
    let [low, high] = summary.plan.cut;
    let cut = low.iter().chain(&high).copied().fold(0.0, f64::max);
    // A plane goes on beyond every domain.
    if cut > 0.0 && !summary.shape.is_some_and(|placed| placed.shape().is_unbounded()) {
        out.push(format!(
            "the domain cuts the band of 2 support radii by up to {} m; outside the domain the map \
             answers as far from the surface",
            digits(cut)
        ));
    }
    let cell = summary.plan.grid.cell_size.max_element();
    if summary.adapted.is_none() && cell > 1.5 * summary.plan.support_radius {
        out.push(format!(
            "the cells are {} support radii large: too coarse for the volume; take more cells",
            significant(cell / summary.plan.support_radius, 2)
        ));
    }
    out.extend(summary.adapted.as_ref().and_then(too_wrong));
    if settings.map.thickness != 0.0 {
        out.push(format!(
            "the surface is moved {} m out of the solid, by `thickness`",
            settings.map.thickness
        ));
    }
    out
}

/// Adaptive cells that can't be as exact as asked for.
fn too_wrong(found: &Adapted) -> Option<String> {
    let Tolerances { volume, distance, normal } = found.tolerances;
    let errors = &found.errors;
    let missed = [
        (errors.volume.max > volume)
            .then(|| format!("the volume {} of the ball", percent(errors.volume.max))),
        (errors.distance.max > distance)
            .then(|| format!("the distance {} of the support radius", percent(errors.distance.max))),
        normal
            .filter(|normal| errors.normal.max > *normal)
            .map(|_| format!("the normal {} degrees", significant(errors.normal.max.to_degrees(), 3))),
    ];
    let missed: Vec<String> = missed.into_iter().flatten().collect();
    if missed.is_empty() && found.left == 0 {
        return None;
    }
    let at = place(found.left_at.as_slice());
    let left = match found.left {
        0 => String::new(),
        n => format!("{} of the finest level stay above the tolerance{at}", counted(n, "cell")),
    };
    let missed = match missed.is_empty() {
        true => String::new(),
        false => format!("the map misses its tolerance: {} at most", missed.join(", ")),
    };
    let both = if left.is_empty() || missed.is_empty() { "" } else { "; " };
    Some(format!(
        "{missed}{both}{left}: walls and gaps much thinner than the support radius, kinks of the distance, or an open \
         mesh, whose sign jumps; give sheets a `thickness`, close the mesh, or take a larger tolerance or a finer \
         `quadrature`"
    ))
}

fn mesh_warnings(summary: &Summary, out: &mut Vec<String>) {
    let found = &summary.diagnosis;
    let cleaning = &summary.cleaning;
    out.extend(cleaning.notes.iter().map(|note| format!("{}: {note}", summary.source.format)));
    if cleaning.skipped.total() > 0 {
        out.push(format!("left out, for they hold no surface: {}", cleaning.skipped));
    }
    if let Some(hole) = found.boundary_loops.first() {
        let [x, y, z] = hole.centroid;
        out.push(format!(
            "the mesh is open: {}, the longest {} m long around ({}, {}, {}); close it, or check the sign there",
            counted(found.boundary_loop_count, "rim"),
            digits(hole.length),
            digits(x),
            digits(y),
            digits(z)
        ));
    }
    let defect = |found: &Defect, thing: &str, what: &str| {
        (found.count > 0).then(|| format!("{} {what}{}", counted(found.count, thing), place(&found.places)))
    };
    out.extend(defect(&found.non_manifold_edges, "edge", "with more than two faces"));
    out.extend(defect(&found.misoriented_edges, "edge", "whose faces don't run the same way round"));
    let flipped = summary.repair.flipped_triangles;
    if flipped > 0 {
        out.push(format!("flipped {} to a consistent orientation", counted(flipped, "triangle")));
    }
    out.extend(defect(&found.nested_solids, "part", "inside a solid; taken as solid"));
}

fn overlap_warning(summary: &Summary, out: &mut Vec<String>) {
    let Overlaps { pairs, hidden, hidden_area, place: at, certain } = &summary.overlaps;
    let at = place(at.as_slice());
    let area = significant(*hidden_area, 3);
    if *certain && *hidden > 0 {
        out.push(format!(
            "parts overlap: {} {} inside the solid, in whole or in part ({area} m^2{at}), and {} no surface there: \
             distance and volume are those of the union",
            counted(*hidden, "triangle"),
            if *hidden == 1 { "lies" } else { "lie" },
            if *hidden == 1 { "is" } else { "are" }
        ));
    } else if !*certain && *pairs > 0 {
        let left_out = match hidden {
            0 => "all still count as surface".to_owned(),
            n => format!(
                "of {}, what surely does is left out ({area} m^2), others may still count as surface",
                counted(*n, "triangle")
            ),
        };
        out.push(format!(
            "parts overlap: {} of triangles cross or cover each other{at}, and the mesh is open, so what lies inside \
             can't be told for certain: {left_out}; close the mesh",
            counted(*pairs, "pair")
        ));
    }
}

/// Lengths that the cells or the file can't resolve.
fn size_warnings(summary: &Summary, settings: &BakeSettings, out: &mut Vec<String>) {
    let cell = summary.thin.cell;
    for (thin, what, way, result) in [
        (&summary.thin.walls, "walls thinner", "goes through", "the map may leak there or miss them"),
        (&summary.thin.gaps, "gaps narrower", "goes through", "the map may close them"),
        (&summary.thin.rods, "rods thinner", "passes", "the map may miss them"),
    ] {
        if thin.count == 0 {
            continue;
        }
        let cure = match settings.map.thickness == 0.0 && what.ends_with("thinner") {
            true => ", or a `thickness`, which thickens them",
            false => "",
        };
        out.push(format!(
            "{what} than a cell ({} m): a line of the grid {way} one some {} {}, the thinnest {} m wide{}; \
             {result}; cells of that size resolve them (`cell_size`){cure}",
            number(cell),
            thousands(thin.count as u64),
            things(thin.count, "time"),
            significant(thin.width, 2),
            place(&thin.places)
        ));
    }
    if let Some(step) = summary.coordinate_step.filter(|step| *step > COARSEST_STEP * cell) {
        out.push(format!(
            "the file's coordinates lie {} m apart, at cells of {} m: they look rounded, to single precision or few \
             digits, as happens far from the origin; write the mesh near the origin, or in double precision",
            significant(step, 2),
            number(cell)
        ));
    }
}

/// Why a map has no solid.
fn no_solid(summary: &Summary) -> String {
    let found = &summary.diagnosis;
    let cure = if found.inside_out_components.count > 0 {
        "its faces point inwards: turn them (without `keep_orientation`, parts that are inside out are turned), or \
         `invert` the map if the fluid is inside"
    } else if summary.overlaps.pairs > 0 && found.balanced {
        "its faces lie on each other the opposite way round, so that they enclose nothing: delete one of each two"
    } else {
        "give sheets a `thickness`, thin parts smaller cells, and turn faces that point inwards"
    };
    format!("no node lies inside: the map has no solid; {cure}")
}

fn sign_warnings(summary: &Summary, distances: &[f64], settings: &BakeSettings, out: &mut Vec<String>) {
    let rounding = 1e-9 * summary.plan.support_radius;
    if !has_solid(distances.iter().copied(), summary.plan.support_radius) {
        out.push(no_solid(summary));
    }
    if !distances.iter().any(|phi| *phi > rounding) {
        let cure = match (settings.map.invert, settings.map.thickness > 0.0) {
            (_, true) => "the `thickness` fills it; take a smaller one",
            (true, _) => "the container has no inside; check its faces, and `invert`",
            (false, _) => "the domain lies inside the solid; check `domain` and `invert`",
        };
        out.push(format!("no node lies outside: nothing is left for the fluid; {cure}"));
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
            "the sign is in doubt at about {} of the nodes, up to {} m from the surface{at}; close the \
             holes, or turn the faces one way round",
            percent(doubt),
            digits(distance)
        ));
    }
    if let Some(signs) = signs.filter(|signs| settings.check_sign && signs.disagreeing > 0) {
        out.push(format!(
            "pseudonormals and winding numbers differ at {} of {} nodes, the farthest {} m from the \
             surface{at}",
            signs.disagreeing,
            signs.points,
            digits(distance)
        ));
    }
}

/// Lengths with four digits.
fn digits(length: f64) -> String {
    significant(length, 4)
}

/// "1 edge", "2 edges".
fn counted(n: usize, thing: &str) -> String {
    format!("{n} {}", things(n, thing))
}

fn things(n: usize, thing: &str) -> String {
    format!("{thing}{}", if n == 1 { "" } else { "s" })
}

fn place(places: &[[f64; 3]]) -> String {
    match places.first() {
        Some(place) => format!(", as at ({})", place.map(digits).join(", ")),
        None => String::new(),
    }
}
