//! Maps whose domain ends before their solid or their hollow does: there the fluid meets a wall that no mesh has, or
//! gets into the solid. Domains are made so only on request; the run can't know whether the fluid gets there, so it
//! goes on and says so.

use super::body::Source;
use super::numbers::Region;
use super::prepare::PreparedBody;
use super::spread::face;
use volmap_formats::asset::Exterior;
use volmap_runtime::{DVec3, PosedMap, Values, VolumeMap};

/// Depths below this part of a cell may be a map's error.
const TOLERANCE: f64 = 0.25;
/// Steps along an edge of the domain at most.
const MOST_STEPS: u32 = 256;

/// Notes on bodies whose map is cut where fluid can be: within the scene's domain, out of other bodies. `fluid` is
/// where it comes from; of the places, the nearest to its middle is told.
pub fn notes(bodies: &[PreparedBody], fluid: &[DVec3], domain: Option<&Region>) -> Vec<String> {
    let middle = fluid.iter().sum::<DVec3>() / fluid.len().max(1) as f64;
    let posed: Vec<PosedMap> = bodies.iter().map(PreparedBody::posed).collect();
    let mut notes = Vec::new();
    for (i, body) in bodies.iter().enumerate() {
        let cell = body.map.finest_cell_size().max_element();
        // A plane's map ends where the scene does.
        let in_domain = |place: DVec3| {
            let corners = domain.map(Region::corners);
            corners.is_none_or(|[min, max]| (place - min).min(max - place).min_element() > cell)
        };
        let mut places: Vec<DVec3> = cut(&body.map).map(|place| body.pose.to_world(place)).collect();
        places.retain(|&place| in_domain(place));
        let others = posed.iter().enumerate().filter(|(j, _)| *j != i);
        others.for_each(|(_, other)| retain_outside(&mut places, other));
        let nearest = places.into_iter().min_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)));
        notes.extend(nearest.map(|place| note(body, place)));
    }
    notes
}

fn note(body: &PreparedBody, DVec3 { x, y, z }: DVec3) -> String {
    let what = match body.map.exterior() {
        Exterior::Solid => "its hollow: there stands a wall that its mesh has not",
        Exterior::Fluid => "its solid: there it is open, and fluid that comes there gets into it",
    };
    let cure = match body.settings.source() {
        Some(Source::Map(_)) => "bake it again with a larger `--domain`, or without one",
        _ => "take a larger `bake.domain`, or leave it out",
    };
    format!(
        "body `{}`: the domain of its map cuts {what}, as at ({x:.3}, {y:.3}, {z:.3}) m; {cure}, or let the scene's \
         `domain` end before",
        body.name
    )
}

/// Points of the domain's border, in the map's frame, where the map isn't what is outside of it.
fn cut(map: &VolumeMap) -> impl Iterator<Item = DVec3> {
    let grid = map.grid();
    let side = if map.exterior() == Exterior::Solid { 1.0 } else { -1.0 };
    let least = TOLERANCE * map.finest_cell_size().max_element();
    let points = border([grid.origin, grid.max_corner()], grid.resolution.to_array());
    let mut values: Vec<Values> = Vec::new();
    map.sample_batch(&points, &mut values);
    points.into_iter().zip(values).filter(move |(_, at)| side * at.distance > least).map(|(point, _)| point)
}

/// The middles of equal parts of a box's faces: cells, or what [`MOST_STEPS`] parts an edge are.
fn border([low, high]: [DVec3; 2], cells: [u32; 3]) -> Vec<DVec3> {
    let parts = cells.map(|n| n.clamp(1, MOST_STEPS));
    let ends = |axis: usize| [low[axis], high[axis].next_down()].map(|at| face([low, high], axis, at, parts));
    (0..3).flat_map(|axis| ends(axis).concat()).collect()
}

/// Drops the places that lie in a body.
fn retain_outside(places: &mut Vec<DVec3>, body: &PosedMap) {
    let mut values: Vec<Values> = Vec::new();
    body.sample_batch(places, &mut values);
    let mut distances = values.iter().map(|at| at.distance);
    places.retain(|_| distances.next().is_some_and(|distance| distance >= 0.0));
}
