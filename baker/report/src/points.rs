//! Points in, what a map says of them out: CSV rows, or JSON.

use serde_json::{Value as Json, json};
use std::io::{Read, Write};
use volmap_runtime::{DVec3, MapDensity, Sample, VolumeMap};

/// Why points can't be answered; `line` counts from 1.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// The table has no such column.
    #[error("line 1: no column `{0}`; the first line must name the columns x, y and z")]
    NoColumn(&'static str),
    /// A coordinate isn't a number.
    #[error("line {line}: {column} is `{text}`, not a finite number")]
    NotANumber {
        /// Where.
        line: u64,
        /// Which column.
        column: &'static str,
        /// What stands there.
        text: String,
    },
    /// The table can't be read or written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The answers can't be written.
    #[error("can't write the answers: {0}")]
    Io(#[from] std::io::Error),
}

const COLUMNS: [&str; 9] = ["distance", "nx", "ny", "nz", "cx", "cy", "cz", "volume", "region"];
/// Of maps that have a density: that over rest density, and its gradient, 1/m.
const DENSITY_COLUMNS: [&str; 4] = ["density", "gx", "gy", "gz"];

/// Copies a CSV table with columns x, y, z (metres) and appends to each row distance, normal, closest point, volume
/// and region (`band`, `outside` or `deep_inside`), and density and its gradient if the map has them. Outside the band
/// only volume and region are known; density and gradient too, unless deep inside.
///
/// # Errors
/// A table without these columns, or with a coordinate that is no number.
pub fn query_csv(map: &VolumeMap, points: impl Read, out: impl Write) -> Result<(), PointsError> {
    let mut table = read(points)?;
    let mut writer = csv::Writer::from_writer(out);
    COLUMNS.iter().for_each(|name| table.header.push_field(name));
    let has_density = map.density_kernel().is_some();
    if has_density {
        DENSITY_COLUMNS.iter().for_each(|name| table.header.push_field(name));
    }
    writer.write_record(&table.header)?;
    for (record, at) in &mut table.rows {
        answer(map, map.sample(*at)).iter().for_each(|field| record.push_field(field));
        if has_density {
            density_answer(map, *at).iter().for_each(|field| record.push_field(field));
        }
        writer.write_record(&*record)?;
    }
    Ok(writer.flush()?)
}

/// As [`query_csv`], as a JSON array of objects; what isn't known is null.
///
/// # Errors
/// As [`query_csv`].
pub fn query_json(map: &VolumeMap, points: impl Read, mut out: impl Write) -> Result<(), PointsError> {
    let rows = read(points)?.rows;
    writeln!(out, "[")?;
    for (number, (_, at)) in rows.iter().enumerate() {
        let separator = if number + 1 < rows.len() { "," } else { "" };
        writeln!(out, "{}{separator}", object(map, *at))?;
    }
    Ok(writeln!(out, "]")?)
}

/// A table, read and checked as a whole, so that there are all answers or none.
struct Table {
    header: csv::StringRecord,
    rows: Vec<(csv::StringRecord, DVec3)>,
}

fn read(points: impl Read) -> Result<Table, PointsError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(points);
    let header = reader.headers()?.clone();
    let columns = coordinates(&header)?;
    let mut rows = Vec::new();
    for record in reader.into_records() {
        let record = record?;
        let at = point(&record, columns)?;
        rows.push((record, at));
    }
    Ok(Table { header, rows })
}

fn coordinates(header: &csv::StringRecord) -> Result<[usize; 3], PointsError> {
    let find = |name: &'static str| {
        let is_it = |field: &str| field.trim_start_matches('\u{feff}').eq_ignore_ascii_case(name);
        header.iter().position(is_it).ok_or(PointsError::NoColumn(name))
    };
    Ok([find("x")?, find("y")?, find("z")?])
}

fn point(record: &csv::StringRecord, columns: [usize; 3]) -> Result<DVec3, PointsError> {
    let number = |axis: usize| {
        let text = record.get(columns[axis]).unwrap_or("");
        let parsed = text.parse().ok().filter(|x: &f64| x.is_finite());
        parsed.ok_or_else(|| PointsError::NotANumber {
            line: record.position().map_or(0, |position| position.line()),
            column: ["x", "y", "z"][axis],
            text: text.to_owned(),
        })
    };
    Ok(DVec3::new(number(0)?, number(1)?, number(2)?))
}

/// Volume and region of a point.
fn known(map: &VolumeMap, sample: &Sample) -> (f64, &'static str) {
    match sample {
        Sample::Near(boundary) => (boundary.volume, "band"),
        Sample::Outside => (0.0, "outside"),
        Sample::DeepInside => (map.quadrature().ball_volume, "deep_inside"),
    }
}

fn answer(map: &VolumeMap, sample: Sample) -> [String; 9] {
    let (volume, region) = known(map, &sample);
    let mut out = [const { String::new() }; 9];
    if let Sample::Near(b) = sample {
        let [n, c] = [b.normal, b.closest_point];
        let numbers = [b.distance, n.x, n.y, n.z, c.x, c.y, c.z];
        out.iter_mut().zip(numbers).for_each(|(field, number)| *field = number.to_string());
    }
    out[7] = volume.to_string();
    out[8] = region.to_owned();
    out
}

fn density_answer(map: &VolumeMap, at: DVec3) -> [String; 4] {
    match map.density(at) {
        Some(MapDensity { value, gradient: g }) => [value, g.x, g.y, g.z].map(|number| number.to_string()),
        None => [const { String::new() }; 4],
    }
}

fn object(map: &VolumeMap, at: DVec3) -> Json {
    let sample = map.sample(at);
    let (volume, region) = known(map, &sample);
    let near = sample.near();
    let mut out = json!({
        "point": at.to_array(),
        "distance": near.map(|b| b.distance),
        "normal": near.map(|b| b.normal.to_array()),
        "closest_point": near.map(|b| b.closest_point.to_array()),
        "volume": volume,
        "region": region,
    });
    if map.density_kernel().is_some() {
        let density = map.density(at);
        out["density"] = density.map(|d| d.value).into();
        out["density_gradient"] = density.map(|d| d.gradient.to_array().to_vec()).into();
    }
    out
}
