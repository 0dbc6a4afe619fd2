//! Points in, what a map says of them out: CSV rows, or JSON.

use serde_json::{Value as Json, json};
use std::io::{self, Read, Write};
use volmap_formats::text::quoted;
use volmap_runtime::{DVec3, MapDensity, Sample, VolumeMap};

/// Why points can't be answered; `line` counts from 1.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// The table has no such column; what it has instead, and the cure.
    #[error("line 1: {0}")]
    Columns(String),
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
    /// The table isn't UTF-8.
    #[error("{0}: save the table as UTF-8 text")]
    Encoding(String),
    /// The table can't be read as comma-separated values.
    #[error("{0}")]
    Csv(String),
    /// The points can't be read or the answers not be written.
    #[error("can't read the points or write the answers: {0}")]
    Io(#[from] io::Error),
}

impl From<csv::Error> for PointsError {
    fn from(error: csv::Error) -> PointsError {
        let text = error.to_string();
        match error.into_kind() {
            csv::ErrorKind::Io(error) => PointsError::Io(error),
            csv::ErrorKind::Utf8 { pos, .. } => {
                PointsError::Encoding(format!("line {} is not UTF-8", pos.map_or(1, |pos| pos.line())))
            }
            _ => PointsError::Csv(text),
        }
    }
}

const COLUMNS: [&str; 9] = ["distance", "nx", "ny", "nz", "cx", "cy", "cz", "volume", "region"];
/// Of maps that have a density: that over rest density, and its gradient, 1/m.
const DENSITY_COLUMNS: [&str; 4] = ["density", "gx", "gy", "gz"];

/// Copies a CSV table with columns x, y, z (metres) and appends to each row distance, normal, closest point, volume
/// and region (`band`, `outside` or `deep_inside`), and density and its gradient if the map has them. Outside the band
/// only volume and region are known; density and gradient too, unless deep inside.
///
/// Where the table has a column of such a name already, as the answers of an earlier query have, the new one is called
/// `distance_2` and so on. Returns those names.
///
/// # Errors
/// A table without these columns or with two of them, with a coordinate that is no number, or that isn't UTF-8.
pub fn query_csv(map: &VolumeMap, points: impl Read, out: impl Write) -> Result<Vec<String>, PointsError> {
    let mut table = read(points)?;
    let mut writer = csv::Writer::from_writer(out);
    let has_density = map.density_kernel().is_some();
    let names = COLUMNS.iter().chain(DENSITY_COLUMNS.iter().filter(|_| has_density));
    let mut renamed = Vec::new();
    for name in names {
        let free = free_name(&table.header, name);
        renamed.extend((free != *name).then(|| free.clone()));
        table.header.push_field(&free);
    }
    writer.write_record(&table.header)?;
    for (record, at) in &mut table.rows {
        answer(map, map.sample(*at)).iter().for_each(|field| record.push_field(field));
        if has_density {
            density_answer(map, *at).iter().for_each(|field| record.push_field(field));
        }
        writer.write_record(&*record)?;
    }
    writer.flush()?;
    Ok(renamed)
}

/// The name, or the name with the least number from 2 on that no column has.
fn free_name(header: &csv::StringRecord, name: &str) -> String {
    let taken = |name: &String| header.iter().any(|field| field == name);
    let numbered = (2..).map(|n| format!("{name}_{n}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
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

fn read(mut points: impl Read) -> Result<Table, PointsError> {
    let mut bytes = Vec::new();
    points.read_to_end(&mut bytes)?;
    if bytes.starts_with(b"\xFF\xFE")
        || bytes.starts_with(b"\xFE\xFF")
        || bytes.iter().take(4).any(|byte| *byte == 0)
    {
        return Err(PointsError::Encoding("the table is UTF-16 text or no text at all".into()));
    }
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&*bytes);
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

const AXES: [&str; 3] = ["x", "y", "z"];

fn coordinates(header: &csv::StringRecord) -> Result<[usize; 3], PointsError> {
    let mut columns = [0; 3];
    for (column, name) in columns.iter_mut().zip(AXES) {
        let is_it = |field: &str| field.trim_start_matches('\u{feff}').eq_ignore_ascii_case(name);
        let found: Vec<usize> = (0..header.len()).filter(|&k| is_it(&header[k])).collect();
        *column = match found[..] {
            [one] => one,
            [] => return Err(PointsError::Columns(no_column(header, name))),
            _ => {
                return Err(PointsError::Columns(format!(
                    "{} columns are called `{name}`: rename all but one",
                    found.len()
                )));
            }
        };
    }
    Ok(columns)
}

/// What a table's first line has instead of a column, and the cure.
fn no_column(header: &csv::StringRecord, name: &str) -> String {
    const LONGEST: usize = 80;
    let line = quoted(&header.iter().collect::<Vec<_>>().join(","), LONGEST);
    let is_number = |field: &str| field.parse::<f64>().is_ok();
    let separator = match header.get(0).filter(|_| header.len() == 1).unwrap_or("") {
        field if field.contains(';') => Some("semicolons"),
        field if field.contains('\t') => Some("tabs"),
        field if field.contains(' ') => Some("blanks"),
        _ => None,
    };
    if let Some(separator) = separator {
        return format!(
            "no column `{name}` in `{line}`: it is parted by {separator}; write commas between the columns, and points \
             in decimal numbers"
        );
    }
    if !header.is_empty() && header.iter().all(is_number) {
        return format!(
            "no column `{name}`, but the numbers `{line}`; the first line must name the columns: add `x,y,z`"
        );
    }
    format!("no column `{name}`; the columns are `{line}`: call those with the places, in metres, x, y and z")
}

fn point(record: &csv::StringRecord, columns: [usize; 3]) -> Result<DVec3, PointsError> {
    let number = |axis: usize| {
        let text = record.get(columns[axis]).unwrap_or("");
        let parsed = text.parse().ok().filter(|x: &f64| x.is_finite());
        parsed.ok_or_else(|| PointsError::NotANumber {
            line: record.position().map_or(0, |position| position.line()),
            column: AXES[axis],
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
