//! Free bodies that begin where they can't stay: in another body, in the solid around a container, out of the domain.
//! The run can't know whether that is meant, so it goes on and says so.

use super::body::Motion;
use super::numbers::Region;
use super::prepare::PreparedBody;
use super::spread::spread;
use crate::output::bodies::surface_of_map;
use volmap_formats::asset::Exterior;
use volmap_runtime::{DVec3, Values};

/// Depths below this part of a cell, and of a particle's radius, may be a map's error.
const TOLERANCE: f64 = 0.25;
/// With this part of its surface in the solid around a container, a body isn't in the container.
const OUTSIDE: f64 = 0.95;

/// Notes on free bodies; `rp` is the particles' radius.
pub fn notes(bodies: &[PreparedBody], rp: f64, domain: Option<&Region>) -> Vec<String> {
    if !bodies.iter().any(is_free) {
        return Vec::new();
    }
    let surfaces: Vec<Vec<DVec3>> = bodies.iter().map(|body| surface(body, rp)).collect();
    let mut notes = Vec::new();
    for (i, body) in bodies.iter().enumerate().filter(|(_, body)| is_free(body)) {
        for (j, other) in bodies.iter().enumerate() {
            // Two free ones are told of once.
            if i == j || (is_free(other) && j < i) {
                continue;
            }
            notes.extend(meeting([body, other], [&surfaces[i], &surfaces[j]], rp));
        }
        let out = domain.map_or(0, |domain| surfaces[i].iter().filter(|&&at| !domain.contains(at)).count());
        if out > 0 {
            let how = if out == surfaces[i].len() { "begins outside" } else { "reaches out of" };
            notes.push(format!(
                "body `{}` {how} the domain; particles are removed there, so the fluid won't carry it: move it, or \
                 widen `domain`",
                body.name
            ));
        }
    }
    notes
}

fn is_free(body: &PreparedBody) -> bool {
    matches!(body.settings.motion, Motion::Free(_))
}

/// What is wrong between a free body and another one.
fn meeting([body, other]: [&PreparedBody; 2], [surface, others]: [&[DVec3]; 2], rp: f64) -> Option<String> {
    let names = format!("body `{}`", body.name);
    let (inside, deepest) = depth(surface, other, rp);
    if other.map.exterior() == Exterior::Solid {
        if inside as f64 >= OUTSIDE * surface.len() as f64 && inside > 0 {
            return Some(format!(
                "{names} begins in the solid outside of the container `{}`, where nothing holds it: move it into the \
                 container, or leave out bake.invert of `{}` if that is no container",
                other.name, other.name
            ));
        }
        let at = place(deepest?);
        return Some(format!(
            "{names} begins with a part in the wall of `{}`, as at {at}; contacts push it out",
            other.name
        ));
    }
    let (_, within) = depth(others, body, rp);
    let at = place(deepest.or(within)?);
    Some(format!(
        "{names} and body `{}` overlap at the start, as at {at}; contacts push them apart",
        other.name
    ))
}

fn place(DVec3 { x, y, z }: DVec3) -> String {
    format!("({x:.3}, {y:.3}, {z:.3}) m")
}

/// How many points lie in a body's solid, and the deepest of them.
fn depth(points: &[DVec3], body: &PreparedBody, rp: f64) -> (usize, Option<DVec3>) {
    let least = TOLERANCE * rp.max(body.map.finest_cell_size().max_element());
    let mut values: Vec<Values> = Vec::new();
    body.posed().sample_batch(points, &mut values);
    let inside = points.iter().zip(&values).filter(|(_, at)| at.distance < -least);
    let deepest = inside.clone().min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
    (inside.count(), deepest.map(|(point, _)| *point))
}

/// Points spread over a body's surface, in the world; none without a surface.
fn surface(body: &PreparedBody, rp: f64) -> Vec<DVec3> {
    let points = match &body.surface.mesh {
        Some(mesh) => spread(mesh, rp),
        None => surface_of_map(&body.map).map(|mesh| spread(&mesh, rp)).unwrap_or_default(),
    };
    points.into_iter().map(|point| body.pose.to_world(point)).collect()
}
