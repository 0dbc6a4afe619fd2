//! The distance to closed lines in the plane, and what a file of them becomes: Bender et al. 2020, Eq. 10, in two
//! dimensions.

use super::crossings::{crossings, doubled};
use super::{AreaSettings, bake};
use crate::error::Error;
use crate::input::MeshSource;
use crate::settings::{GridChoice, Precision};
use crate::watch::Watch;
use glam::DVec2;
use std::path::Path;
use volmap_formats::asset::{Asset, Attributes, Value};
use volmap_formats::mesh::{self, Outline, parse_outline};
use volmap_formats::text::significant;

/// How a file's coordinates become metres: times the unit, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePlacement {
    /// Metres per unit of the file.
    pub unit: f64,
    /// Added, metres.
    pub translation: [f64; 2],
}

impl Default for OutlinePlacement {
    fn default() -> Self {
        OutlinePlacement { unit: 1.0, translation: [0.0; 2] }
    }
}

/// Signed distance to the segments, by looking at all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineDistance {
    segments: Vec<[DVec2; 2]>,
    /// Solid and fluid change places.
    pub invert: bool,
    /// The line moves out of the solid by this, metres.
    pub thickness: f64,
}

impl OutlineDistance {
    /// Of an outline in metres.
    pub fn new(outline: &Outline, invert: bool, thickness: f64) -> OutlineDistance {
        let point = |index: u32| DVec2::from(outline.points[index as usize]);
        let segments = outline.segments.iter().map(|ends| ends.map(point)).collect();
        OutlineDistance { segments, invert, thickness }
    }

    /// Phi, metres: negative where a ray to the right crosses an odd number of segments.
    pub fn at(&self, x: DVec2) -> f64 {
        let (mut square, mut inside) = (f64::INFINITY, self.invert);
        for &[a, b] in &self.segments {
            let (along, from) = (b - a, x - a);
            let t = (from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            square = square.min((from - t * along).length_squared());
            // Half-open, so that a ray through a corner crosses one of its two segments, or both.
            if (a.y > x.y) != (b.y > x.y) && (from.perp_dot(along) < 0.0) == (along.y > 0.0) {
                inside = !inside;
            }
        }
        let distance = square.sqrt();
        (if inside { -distance } else { distance }) - self.thickness
    }

    /// Lowest and highest corner of the lines' box, metres.
    pub fn bounds(&self) -> [DVec2; 2] {
        let points = || self.segments.iter().flatten();
        [
            points().fold(DVec2::INFINITY, |a, &b| a.min(b)),
            points().fold(DVec2::NEG_INFINITY, |a, &b| a.max(b)),
        ]
    }

    fn length(&self) -> f64 {
        self.segments.iter().map(|[a, b]| (*b - *a).length()).sum()
    }
}

/// Bakes the outline in an OBJ file.
///
/// # Errors
/// A file that can't be read or is no outline; settings that can't be used with it; cancelled.
pub fn bake_file(
    path: &Path,
    placement: OutlinePlacement,
    settings: &AreaSettings,
    watch: &Watch,
) -> Result<Asset, Error> {
    let bytes = mesh::read_bytes(path)?;
    let outline = placed(parse_outline(path, &bytes)?, placement)?;
    let phi = OutlineDistance::new(&outline, settings.invert, settings.thickness);
    let asset = bake(phi.bounds(), &|x| phi.at(x), settings, watch)?;
    let source = MeshSource {
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        format: "obj".into(),
        blake3: blake3::hash(&bytes).to_hex().to_string(),
    };
    let warnings = [outline.notes, warnings(&asset, &phi)].concat();
    Ok(Asset {
        bake: parameters(&asset, placement, settings),
        source: source_attributes(&source, &phi),
        diagnosis: attributes([("warnings", warnings.join("\n").into())]),
        ..asset
    })
}

fn placed(mut outline: Outline, placement: OutlinePlacement) -> Result<Outline, Error> {
    let OutlinePlacement { unit, translation } = placement;
    for point in &mut outline.points {
        *point = (unit * DVec2::from(*point) + DVec2::from(translation)).to_array();
    }
    match outline.points.iter().flatten().all(|x| x.abs() <= mesh::MAX_COORDINATE) {
        true => Ok(outline),
        false => Err(Error::setting("translate", "carries the outline beyond 1e100 m, together with `unit`")),
    }
}

/// What a careful person would look at before using the map.
pub fn warnings(asset: &Asset, phi: &OutlineDistance) -> Vec<String> {
    let mut out = Vec::new();
    let [x, y, _] = asset.grid.cell_size;
    if x.max(y) > 1.5 * asset.support_radius {
        let cells = x.max(y) / asset.support_radius;
        out.push(format!(
            "the cells are {} support radii large: too coarse for the area; take more cells",
            significant(cells, 2)
        ));
    }
    let reach = 2.0 * asset.support_radius + phi.thickness.abs() - 1e-6 * x.min(y);
    let (grid, [min, max]) = (volmap_runtime::Grid::from(asset.grid), phi.bounds());
    let (low, high) = (grid.origin.truncate(), grid.max_corner().truncate());
    if low.cmpgt(min - reach).any() || high.cmplt(max + reach).any() {
        out.push(
            "the domain cuts the band of 2 support radii; beyond it the map answers as far from the lines"
                .into(),
        );
    }
    if !asset.signed_distance.to_f64().iter().any(|phi| *phi < 0.0) {
        out.push(match doubled(&phi.segments) {
            Some(at) => format!(
                "no node lies inside: the map has no solid; its lines lie on each other, as at ({}), and what is \
                 enclosed twice is outside: delete one of each two",
                place(at)
            ),
            None => "no node lies inside: the map has no solid; take smaller cells".into(),
        });
    }
    if let Some((count, at)) = crossings(&phi.segments) {
        let s = if count == 1 { "" } else { "s" };
        out.push(format!(
            "lines cross or lie on each other at {count} place{s}, as at ({}): what is enclosed twice is outside, a \
             hole; join outlines that overlap",
            place(at)
        ));
    }
    out
}

fn place(point: DVec2) -> String {
    format!("{:.4}, {:.4}", point.x, point.y)
}

fn attributes<const N: usize>(pairs: [(&str, Value); N]) -> Attributes {
    pairs.map(|(name, value)| (name.to_owned(), value)).into()
}

fn parameters(asset: &Asset, placement: OutlinePlacement, settings: &AreaSettings) -> Attributes {
    let grid = match settings.grid {
        GridChoice::Resolution([x, y, _]) => format!("resolution {x},{y}"),
        GridChoice::CellSize(edge) => format!("cell size {edge}"),
        GridChoice::FromRadius | GridChoice::Tolerance(_) | GridChoice::Bytes(_) => {
            "from support radius".to_owned()
        }
    };
    let mut out = attributes([
        ("support_radius", asset.support_radius.into()),
        ("particle_radius", (asset.support_radius / 4.0).into()),
        ("band_width", (2.0 * asset.support_radius).into()),
        ("grid", grid.into()),
        ("domain_given", settings.domain.is_some().into()),
        ("padding", settings.padding.into()),
        ("invert", settings.invert.into()),
        ("thickness", settings.thickness.into()),
        ("quadrature", settings.rule.to_string().into()),
        ("precision", asset.volume.type_name().into()),
        ("unit", placement.unit.into()),
        ("translation", Value::Real(placement.translation.to_vec())),
    ]);
    if let Some(density) = settings.density {
        out.insert("density_kernel".into(), density.kernel.to_string().into());
        out.insert("density_quadrature".into(), density.rule.to_string().into());
    }
    if let Precision::Rounded(part) = settings.precision {
        out.insert("max_rounding".into(), part.into());
    }
    out
}

fn source_attributes(source: &MeshSource, phi: &OutlineDistance) -> Attributes {
    let [min, max] = phi.bounds();
    attributes([
        ("file", source.file.as_str().into()),
        ("format", source.format.as_str().into()),
        ("blake3", source.blake3.as_str().into()),
        ("segments", (phi.segments.len() as u64).into()),
        ("bounds_min", Value::Real(min.to_array().to_vec())),
        ("bounds_max", Value::Real(max.to_array().to_vec())),
        ("length", phi.length().into()),
        ("program", "volmap".into()),
        ("program_version", env!("CARGO_PKG_VERSION").into()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 with a hole of side 1 in its middle, the lines run anyhow.
    fn frame() -> Outline {
        let points = vec![
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [0.0, 2.0],
            [0.5, 0.5],
            [1.5, 0.5],
            [1.5, 1.5],
            [0.5, 1.5],
        ];
        Outline {
            points,
            segments: vec![[0, 1], [2, 1], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4]],
            ..Default::default()
        }
    }

    #[test]
    fn distance_to_a_frame_is_known() {
        let phi = OutlineDistance::new(&frame(), false, 0.0);
        let known = [
            ([1.0, 1.0], 0.5),
            ([0.25, 1.0], -0.25),
            ([0.25, 0.5], -0.25),
            ([1.0, 0.1], -0.1),
            ([-3.0, -4.0], 5.0),
            ([2.5, 2.0], 0.5),
            ([2.0, 5.0], 3.0),
        ];
        let inverted = OutlineDistance { invert: true, ..phi.clone() };
        let thick = OutlineDistance { thickness: 0.1, ..phi.clone() };
        for (place, distance) in known {
            let x = DVec2::from(place);
            assert!((phi.at(x) - distance).abs() < 1e-15, "{place:?}: {}", phi.at(x));
            assert_eq!(inverted.at(x), -phi.at(x));
            assert_eq!(thick.at(x), phi.at(x) - 0.1);
        }
        assert_eq!(phi.bounds(), [DVec2::ZERO, DVec2::splat(2.0)]);
        assert_eq!(phi.length(), 12.0);
    }

    #[test]
    fn sign_is_that_of_a_polygon_with_a_thousand_corners() {
        const CORNERS: u32 = 1000;
        let angle = |n: u32| std::f64::consts::TAU * f64::from(n) / f64::from(CORNERS);
        let outline = Outline {
            points: (0..CORNERS).map(|n| DVec2::from_angle(angle(n)).to_array()).collect(),
            segments: (0..CORNERS).map(|n| [n, (n + 1) % CORNERS]).collect(),
            ..Outline::default()
        };
        let phi = OutlineDistance::new(&outline, false, 0.0);
        // Rays through the corners' own heights too.
        for n in (0..CORNERS).step_by(7) {
            for radius in [0.0, 0.3, 0.99, 1.01, 2.0] {
                let x = DVec2::new(radius * angle(3 * n).cos(), radius * angle(n).sin());
                assert!((phi.at(x) - (x.length() - 1.0)).abs() < 1e-5, "{x}");
            }
        }
    }
}
