//! A map of SPlisHSPlasH (`.cdm`) as an asset: the nodes' values stay as they are, to the bit.
//!
//! The file has no support radius, says nothing of inside and outside, and may store cells far from the surface. Here
//! the cells with a point of |Phi| <= 2 r, as far as their nodes tell, become the band; the others fluid or solid.

mod removed;

use crate::error::Error;
use glam::{DVec3, UVec3};
use removed::fill_removed;
use std::f64::consts::PI;
use std::path::Path;
use volmap_formats::asset::{
    Array, Asset, Attributes, CellRun, Dimension, Exterior, GridSpec, MAX_CELLS_PER_AXIS, MAX_ROWS,
    QuadratureSpec, Value,
};
use volmap_formats::export::cdm::{self, DiscreteGrid, NODES, REMOVED, UNSAMPLED, local_node};
use volmap_formats::text::{number, significant};
use volmap_runtime::VolumeMap;
use volmap_runtime::layout::{Cell, CellIndex, Nodes};

/// What the file doesn't say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportSettings {
    /// Support radius r of the kernels that the volume is for, metres.
    pub support_radius: f64,
    /// What lies outside the domain; by default what all cells at its border are.
    pub exterior: Option<Exterior>,
}

/// An asset, and what a careful person would look at.
#[derive(Clone, Debug)]
pub struct Import {
    /// The asset, its fields of double precision.
    pub asset: Asset,
    /// What is odd about it; the asset holds it too.
    pub warnings: Vec<String>,
    /// What differs between the programs, if it may matter here.
    pub notes: Vec<String>,
}

/// Reads a map of SPlisHSPlasH.
///
/// # Errors
/// A file that can't be read, isn't such a map or is damaged; one that has no volume, or none near the surface; one
/// whose border is fluid and solid, without a word on what is outside; one that holds a density or another field
/// instead of a volume; a radius that isn't a length.
pub fn import(path: &Path, settings: &ImportSettings) -> Result<Import, Error> {
    let r = settings.support_radius;
    if !(r > 0.0 && r.is_finite() && (r * r * r).is_normal()) {
        return Err(Error::setting("support_radius", format!("{r} is not a positive length")));
    }
    let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
    let refuse = |reason: String| Error::unusable(path, reason);
    let grid = cdm::from_bytes(&bytes).map_err(|error| refuse(error.to_string()))?;
    let mut import = from_grid(&grid, settings).map_err(refuse)?;
    VolumeMap::from_asset(&import.asset)?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let hash = blake3::hash(&bytes).to_hex().to_string();
    import.asset.source.extend([("file".to_owned(), file.into()), ("blake3".to_owned(), hash.into())]);
    Ok(import)
}

/// The same from what was read.
///
/// # Errors
/// As [`import`]: the reason.
pub fn from_grid(grid: &DiscreteGrid, settings: &ImportSettings) -> Result<Import, String> {
    let [distance, volume, ..] = grid.fields.as_slice() else {
        return Err("holds a distance without a volume: bake the mesh instead".into());
    };
    let [_, y, z] = grid.resolution.map(u64::from);
    if grid.resolution.iter().any(|&n| n > MAX_CELLS_PER_AXIS) || y * z > MAX_ROWS {
        return Err(format!("{:?} cells are more than an asset can have", grid.resolution));
    }
    let near = 2.0 * settings.support_radius + KEPT_IN_DOUBT * DVec3::from(grid.cell_size).length();
    let count = distance.cell_map.len();
    let mut kinds: Vec<Kind> = (0..count).map(|cell| kind(distance, volume, cell, near)).collect();
    let lacks_volume = |cell: usize| {
        let is_near = |d: &f64| d.abs() < settings.support_radius;
        matches!(kinds[cell], Kind::Solid | Kind::Fluid)
            && cell_values(distance, cell).is_some_and(|values| values.iter().any(is_near))
    };
    if (0..count).any(lacks_volume) {
        return Err("has no volume in cells within a support radius of the surface".into());
    }
    fill_removed(grid, &mut kinds)?;
    if !kinds.contains(&Kind::Band) {
        return Err(format!(
            "no cell with both fields is within 2 support radii of {} m of the surface: check `support_radius`",
            settings.support_radius
        ));
    }
    let band_cells = runs(grid, &kinds, Kind::Band);
    let signed_distance = node_values(grid, distance, &band_cells)?;
    let volumes = node_values(grid, volume, &band_cells)?;
    check_is_volume(&signed_distance, &volumes, settings.support_radius)?;
    let exterior = exterior(grid, &kinds, settings)?;
    let (ball_volume, warnings) = ball_volume(&signed_distance, &volumes, settings.support_radius);
    let asset = Asset {
        dimension: Dimension::Three,
        grid: GridSpec { origin: grid.min, cell_size: grid.cell_size, resolution: grid.resolution },
        support_radius: settings.support_radius,
        exterior,
        quadrature: QuadratureSpec { name: "unknown".into(), degree: 0, points: 0, ball_volume },
        solid_cells: runs(grid, &kinds, Kind::Solid),
        finer: Vec::new(),
        band_cells,
        signed_distance: Array::F64(signed_distance),
        volume: Array::F64(volumes),
        density: None,
        plane_weight: None,
        bake: parameters(grid, settings),
        source: text([
            ("format", "cdm"),
            ("program", "volmap"),
            ("program_version", env!("CARGO_PKG_VERSION")),
        ]),
        diagnosis: text([("warnings", &warnings.join("\n"))]),
    };
    let notes = other_thickness(&asset).into_iter().collect();
    Ok(Import { asset, warnings, notes })
}

/// The program moves the surface out of the mesh, and inverts what comes of it.
fn other_thickness(asset: &Asset) -> Option<String> {
    (asset.exterior == Exterior::Solid).then(|| {
        "the outside is solid: if it was made with `mapInvert` and a `mapThickness` of T, its hollow is wider than the \
         mesh by T on each side; to bake the same from the mesh, give `invert` and a `thickness` of -T, as ours \
         thickens the walls"
            .into()
    })
}

/// A point of a cell is at most half its diagonal from a node, so a cell without a node within 2 r and that much of the
/// surface has no point within 2 r. The eighth more is by how much a bake keeps cells in doubt (`sdf/band.rs`): what
/// was exported comes back.
const KEPT_IN_DOUBT: f64 = 0.5 + 0.125;

/// What a cell of the grid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Band,
    Solid,
    Fluid,
    /// Not known yet.
    Removed,
}

/// The values at a cell's nodes, in the asset's order; `None` if it isn't stored.
fn cell_values(field: &cdm::Field, cell: usize) -> Option<[f64; NODES]> {
    let nodes = match field.cell_map[cell] {
        REMOVED => return None,
        stored => &field.cells[stored as usize],
    };
    Some(std::array::from_fn(|a| field.nodes[nodes[local_node(a)] as usize]))
}

fn kind(distance: &cdm::Field, volume: &cdm::Field, cell: usize, near: f64) -> Kind {
    let all_sampled = |values: &[f64; NODES]| !values.contains(&UNSAMPLED);
    let Some(distances) = cell_values(distance, cell).filter(all_sampled) else { return Kind::Removed };
    let is_negative = distances[0] < 0.0;
    let is_near = distances.iter().any(|d| d.abs() <= near || (*d < 0.0) != is_negative);
    match is_near && cell_values(volume, cell).is_some_and(|values| all_sampled(&values)) {
        true => Kind::Band,
        false if is_negative => Kind::Solid,
        false => Kind::Fluid,
    }
}

/// The cells of a kind.
fn runs(grid: &DiscreteGrid, kinds: &[Kind], kind: Kind) -> Vec<CellRun> {
    let [nx, ny, _] = grid.resolution;
    let mut out: Vec<CellRun> = Vec::new();
    for (row, cells) in kinds.chunks(nx as usize).enumerate() {
        let (j, k) = (row as u32 % ny, row as u32 / ny);
        for i in (0..nx).filter(|&i| cells[i as usize] == kind) {
            match out.last_mut().filter(|run| (run.i + run.len, run.j, run.k) == (i, j, k)) {
                Some(run) => run.len += 1,
                None => out.push(CellRun { i, j, k, len: 1 }),
            }
        }
    }
    out
}

/// A field at the nodes of the asset.
fn node_values(grid: &DiscreteGrid, field: &cdm::Field, band: &[CellRun]) -> Result<Vec<f64>, String> {
    let resolution = UVec3::from(grid.resolution);
    let nodes = Nodes::new(resolution, band).ok_or("has more than 2^32 nodes")?;
    let index = CellIndex::new(resolution, band, &[], &nodes);
    let mut out = vec![UNSAMPLED; nodes.count()];
    for cell in band.iter().flat_map(|run| (run.i..run.i + run.len).map(|i| UVec3::new(i, run.j, run.k))) {
        let n = resolution.as_usizevec3();
        let at = cell.as_usizevec3();
        let values = cell_values(field, at.x + n.x * (at.y + n.y * at.z));
        let (Cell::Band(numbers), Some(values)) = (index.find(cell), values) else { continue };
        for (number, value) in numbers.all().into_iter().zip(values) {
            let node = &mut out[number as usize];
            if *node != UNSAMPLED && node.to_bits() != value.to_bits() {
                return Err(format!("the cells around node {number} disagree: {node} and {value}"));
            }
            *node = value;
        }
    }
    Ok(out)
}

/// What the cells at the domain's border are, if they are all the same.
fn exterior(grid: &DiscreteGrid, kinds: &[Kind], settings: &ImportSettings) -> Result<Exterior, String> {
    if let Some(exterior) = settings.exterior {
        return Ok(exterior);
    }
    let (mut solid, mut fluid) = (false, false);
    let [nx, ny, nz] = grid.resolution.map(|n| n as usize);
    for (cell, kind) in kinds.iter().enumerate() {
        let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        if at.iter().zip([nx, ny, nz]).all(|(&at, n)| at > 0 && at < n - 1) {
            continue;
        }
        let values = cell_values(&grid.fields[0], cell).filter(|_| *kind == Kind::Band);
        solid |= *kind == Kind::Solid || values.is_some_and(|values| values.iter().any(|d| *d < 0.0));
        fluid |= *kind == Kind::Fluid || values.is_some_and(|values| values.iter().any(|d| *d > 0.0));
    }
    match (solid, fluid) {
        (true, false) => Ok(Exterior::Solid),
        (false, true) => Ok(Exterior::Fluid),
        _ => {
            Err("the border of its domain is solid here and fluid there: say with `exterior` what is outside"
                .into())
        }
    }
}

/// How many times the full ball a volume may be: that of a support radius 1.6 times as large, or half as large.
const POSSIBLE: std::ops::RangeInclusive<f64> = 0.125..=4.0;

/// Refuses values that can't be volumes: density maps and tube maps have the same file, and other numbers in it.
fn check_is_volume(distances: &[f64], values: &[f64], r: f64) -> Result<(), String> {
    let ball = 4.0 / 3.0 * PI * r * r * r;
    let largest = values.iter().copied().fold(0.0, f64::max);
    let smallest = values.iter().copied().fold(0.0, f64::min);
    let is_deep = distances.iter().any(|d| *d <= -r);
    let kind = "it is probably a density map or a tube map of SPlisHSPlasH, which holds no volume: \
     bake the mesh instead";
    if smallest < -1e-3 * ball {
        return Err(format!(
            "its second field is {} in places, and a volume is not negative; {kind}",
            number(smallest)
        ));
    }
    let part = largest / ball;
    if part > *POSSIBLE.end() || (is_deep && part < *POSSIBLE.start()) {
        let fits = significant((0.75 / PI * largest).cbrt(), 4);
        return Err(format!(
            "its second field is up to {}, {} times the full ball of a support radius of {} m; {kind}, or give the \
             `support_radius` that it was made for ({fits} m would fit)",
            number(largest),
            number(part),
            number(r)
        ));
    }
    Ok(())
}

/// The largest volume at least r deep in the solid, where the whole ball is solid: that of the full ball as the
/// program integrated it. And whether that is odd.
fn ball_volume(distances: &[f64], volumes: &[f64], r: f64) -> (f64, Vec<String>) {
    let exact = 4.0 / 3.0 * PI * r * r * r;
    let deep = distances.iter().zip(volumes).filter(|(d, v)| **d <= -r && **v > 0.0);
    let Some(ball) = deep.map(|(_, v)| *v).reduce(f64::max) else {
        return (
            exact,
            vec!["no node is deep in the solid: the volume of the full ball is taken as 4/3 pi r^3".into()],
        );
    };
    let mut warnings = Vec::new();
    if !(0.95..1.05).contains(&(ball / exact)) {
        warnings.push(format!(
            "deep in the solid the volume is {} of the full ball: another `support_radius`, or a map of \
             SPlisHSPlasH before 2.19, which multiplies all volumes by 0.8",
            number(ball / exact)
        ));
    }
    (ball, warnings)
}

fn parameters(grid: &DiscreteGrid, settings: &ImportSettings) -> Attributes {
    let domain = [grid.min, grid.max].concat();
    let numbers = [
        ("support_radius", Value::from(settings.support_radius)),
        ("particle_radius", (settings.support_radius / 4.0).into()),
        ("band_width", (2.0 * settings.support_radius).into()),
        ("grid", "imported".into()),
        ("domain", Value::Real(domain)),
        ("precision", "f64".into()),
    ];
    numbers.map(|(name, value)| (name.to_owned(), value)).into()
}

fn text<const N: usize>(pairs: [(&str, &str); N]) -> Attributes {
    pairs.map(|(name, value)| (name.to_owned(), value.into())).into()
}
