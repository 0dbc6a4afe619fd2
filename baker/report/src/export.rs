//! Maps for other programs: which file, and what is in it.
//!
//! ```text
//! Asset -> hexahedra  -> .vtkhdf   the map itself, for ParaView and VTK
//!       -> image      -> .vti      its values at equally spaced points
//!       -> surface    -> .ply      the surface Phi = constant
//!       -> discregrid -> .cdm/.cdf the map for SPlisHSPlasH, the distance for Discregrid
//! ```

pub mod deep;
pub mod discregrid;
pub mod hexahedra;
pub mod image;

use crate::error::Error;
use std::path::Path;
use volmap_bake::adaptive::uniform;
use volmap_bake::area_map::require_space;
use volmap_bake::iso_surface::iso_surface;
use volmap_bake::iso_surface::lattice::LatticeChoice;
use volmap_bake::random::Random;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{Array, Asset};
use volmap_formats::export::{cdm, ply, vti, vtkhdf};
use volmap_formats::text::{percent, significant, thousands};
use volmap_runtime::{DVec3, VolumeMap};

/// A field of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportField {
    /// Signed distance, metres.
    Distance,
    /// Boundary volume, m^3.
    Volume,
}

/// What is exported, where the format leaves a choice. What a format has no use for is refused.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportSettings {
    /// VTI: one field only.
    pub field: Option<ExportField>,
    /// VTI and PLY: the points at which the map is asked; by default the corners of its cells, and thirds of its cells.
    pub lattice: Option<LatticeChoice>,
    /// PLY: the distance of the surface, metres; by default 0.
    pub iso: Option<f64>,
}

/// Writes a map as what the extension of `path` says; what it says then is for people.
///
/// # Errors
/// An unknown extension, settings that the format has no use for, an asset that isn't consistent, or a file that
/// can't be written; cancelled, which leaves no file.
pub fn export(asset: &Asset, path: &Path, settings: &ExportSettings, watch: &Watch) -> Result<String, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    check_settings(&extension, settings)?;
    require_space(asset, "volmap export")?;
    match extension.as_str() {
        "vtkhdf" => {
            let equal = uniform(asset, MOST_CELLS)?;
            let cells = hexahedra::hexahedra(&equal, watch)?;
            watch.step(WRITING)?;
            vtkhdf::write(path, &cells)?;
            let note = resampled(asset, &equal);
            Ok(format!("{} cubic cells, {} points{note}", count(&cells.cells), count(&cells.points)))
        }
        "vti" => {
            let image = image::image(asset, settings, watch)?;
            watch.step(WRITING)?;
            vti::write(path, &image)?;
            let [x, y, z] = image.points;
            Ok(format!("{x} x {y} x {z} points"))
        }
        "ply" => {
            let iso = settings.iso.unwrap_or(0.0);
            let surface = iso_surface(&VolumeMap::from_asset(asset)?, iso, settings.lattice, watch)?;
            watch.step(WRITING)?;
            let comment = format!("volmap, surface of signed distance {iso} m");
            ply::write(path, &surface.vertices, &surface.triangles, &comment)?;
            Ok(surface.to_string())
        }
        _ => {
            let equal = uniform(asset, MOST_CELLS)?;
            let grid = discregrid::discregrid(&equal, extension == "cdm", watch)?;
            watch.step(WRITING)?;
            cdm::write(path, &grid)?;
            let distance = &grid.fields[0];
            let note = resampled(asset, &equal);
            Ok(format!("{} cells, {} nodes{note}", count(&distance.cells), count(&distance.nodes)))
        }
    }
}

/// Equal cells that stand for an adaptive map's in formats that know no others, at most.
const MOST_CELLS: u64 = 4_000_000;
/// Points at which both maps are compared.
const COMPARED: usize = 2_000;

/// That an adaptive map was given equal cells, and how much its values change by that.
fn resampled(asset: &Asset, equal: &Asset) -> String {
    let maps = [asset, equal].map(|asset| VolumeMap::from_asset(asset).ok());
    let [Some(map), Some(found)] = maps else { return String::new() };
    if !asset.is_adaptive() {
        return String::new();
    }
    let (grid, mut random) = (*map.grid(), Random::new(1));
    let (mut distance, mut volume) = (0.0f64, 0.0f64);
    for _ in 0..COMPARED {
        let part = DVec3::new(random.unit(), random.unit(), random.unit());
        let x = grid.origin + part * (grid.max_corner() - grid.origin);
        let (own, other) = (map.values(x), found.values(x));
        if own.distance.is_finite() && other.distance.is_finite() {
            distance = distance.max((own.distance - other.distance).abs());
            volume = volume.max((own.volume - other.volume).abs());
        }
    }
    format!(
        "; cells of several sizes became equal ones of {} m, which changes distances by up to {} of the support radius and \
         volumes by up to {} of the ball",
        significant(equal.grid.cell_size[0], 4),
        percent(distance / map.support_radius()),
        percent(volume / map.quadrature().ball_volume)
    )
}

/// The last step, which is done whole or not at all.
const WRITING: &str = "writing";

fn check_settings(extension: &str, settings: &ExportSettings) -> Result<(), Error> {
    let useless =
        |parameter| Err(Error::setting(parameter, format!("has no meaning in a .{extension} file")));
    let (field, lattice, iso) = match extension {
        "vti" => (true, true, false),
        "ply" => (false, true, true),
        "vtkhdf" | "cdm" | "cdf" => (false, false, false),
        _ => {
            return Err(Error::setting("output", "name a file ending in .vtkhdf, .vti, .ply, .cdm or .cdf"));
        }
    };
    match settings {
        ExportSettings { field: Some(_), .. } if !field => useless("field"),
        ExportSettings { lattice: Some(choice), .. } if !lattice => useless(match choice {
            LatticeChoice::Resolution(_) => "resolution",
            LatticeChoice::CellSize(_) => "cell_size",
        }),
        ExportSettings { iso: Some(_), .. } if !iso => useless("iso"),
        _ => Ok(()),
    }
}

fn count<T>(list: &[T]) -> String {
    thousands(list.len() as u64)
}

/// A field's values at the nodes.
fn values(field: &Array) -> Vec<f64> {
    match field {
        Array::F32(v) => v.iter().map(|&x| x.into()).collect(),
        Array::F64(v) => v.clone(),
        Array::Rounded(v) => v.values().collect(),
        Array::U32(v) => v.iter().map(|&x| x.into()).collect(),
    }
}
