//! What was found, as it stands in the JSON file.

use super::levels::{self, LevelFacts};
use super::reference::{FINE_RULE, PAPER_RULE, Reference};
use super::reference_check::ReferenceCheck;
use super::slices::ErrorSlice;
use super::statistics::{DistanceBin, HistogramBar, Measurement, Statistics, by_distance, histogram};
use super::thin::{self, Thin, Width};
use super::volume_error::{ErrorPart, VolumeSample};
use super::{Measured, ReportSettings, SurfaceFindings};
use crate::error::Error;
use crate::info;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value as Json};
use volmap_formats::text::{number, percent, thousands};

/// Ranges of distance, from 2 r deep to 2 r outside.
const BINS: usize = 32;
/// Narrowest places that are listed.
const NARROWEST: usize = 5;

/// The figures of a report.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Findings {
    /// `volmap-report`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// The program's version.
    pub program_version: String,
    /// The answer.
    pub verdict: Verdict,
    /// What was measured.
    pub asset: AssetFacts,
    /// What it was compared with.
    pub mesh: Option<MeshFacts>,
    /// How.
    pub settings: SettingFacts,
    /// Errors of the volume, by reference and region.
    pub volume: Vec<VolumeErrors>,
    /// The parts of the error of the volume, as parts of the full ball.
    pub parts: Vec<PartErrors>,
    /// Sizes of the error against the verdict's reference, as parts of the full ball.
    pub histogram: Vec<HistogramBar>,
    /// The same by distance from the surface.
    pub by_distance: Vec<DistanceBin>,
    /// Errors of the density, if the asset has one.
    pub density: Option<DensityErrors>,
    /// Errors of distance and normal.
    pub distance: Option<DistanceErrors>,
    /// The cells of each level, of an adaptive map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<Vec<LevelFacts>>,
    /// Errors on slices, against order 100 on the asset's own distance.
    pub slices: Vec<SliceErrors>,
    /// Thin walls and narrow gaps.
    pub thin: Option<ThinPlaces>,
    /// Where pseudonormals and winding numbers differ.
    pub signs: Option<SignFacts>,
    /// Whether the exact distance holds against winding numbers.
    pub reference_check: Option<ReferenceCheck>,
}

/// The answer.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Verdict {
    /// Whether the largest error is allowed; null if no limit was given.
    pub passed: Option<bool>,
    /// Largest error of the volume in the fluid, as a part of the full ball.
    pub max_error: f64,
    /// The limit.
    pub allowed: Option<f64>,
    /// Against which reference.
    pub reference: Reference,
    /// In a sentence.
    pub text: String,
}

/// The asset.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct AssetFacts {
    /// Support radius, metres.
    pub support_radius: f64,
    /// Volume of the full ball, m^3: the unit of the errors.
    pub ball_volume: f64,
    /// Cells along x, y, z.
    pub resolution: [u32; 3],
    /// Edges of a cell, metres.
    pub cell_size: [f64; 3],
    /// Corners of the domain, metres.
    pub domain: [[f64; 3]; 2],
    /// Cells that are stored.
    pub band_cells: u64,
    /// Nodes that are stored.
    pub nodes: u64,
    /// The rule of the volume.
    pub quadrature: String,
    /// What lies outside the domain: `fluid` or `solid`.
    pub exterior: String,
    /// Every parameter of the bake.
    pub bake: Map<String, Json>,
    /// Where the asset comes from.
    pub source: Map<String, Json>,
}

/// The mesh.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct MeshFacts {
    /// Name of the file.
    pub file: String,
    /// Triangles after cleaning.
    pub triangles: usize,
    /// Whether it is closed.
    pub closed: bool,
    /// If it is not the one that was baked.
    pub warning: Option<String>,
}

/// How it was measured.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SettingFacts {
    /// Random points of the band.
    pub points: usize,
    /// How many of them were compared with the mesh.
    pub mesh_points: usize,
    /// Seed of the points.
    pub seed: u64,
    /// Pixels of the longest side of a slice.
    pub pixels: usize,
    /// The converged rule.
    pub fine_rule: String,
}

/// Where points lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Region {
    /// Where particles are: Phi >= 0.
    Fluid,
    /// Phi < 0.
    Solid,
    /// Both.
    Band,
}

impl Region {
    /// All.
    pub const ALL: [Region; 3] = [Region::Fluid, Region::Solid, Region::Band];

    fn holds(self, distance: f64) -> bool {
        match self {
            Region::Fluid => distance >= 0.0,
            Region::Solid => distance < 0.0,
            Region::Band => true,
        }
    }
}

/// Errors of the volume.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct VolumeErrors {
    /// Against this.
    pub reference: Reference,
    /// The same in words.
    pub description: String,
    /// Where.
    pub region: Region,
    /// As parts of the full ball.
    pub fraction: Statistics,
    /// In m^3.
    pub cubic_metres: Statistics,
}

/// One part of the error of the volume.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PartErrors {
    /// Which.
    pub part: ErrorPart,
    /// In words.
    pub description: String,
    /// As parts of the full ball, in the whole band.
    pub fraction: Statistics,
}

/// Errors of the density map, in the whole band.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct DensityErrors {
    /// The SPH kernel.
    pub kernel: String,
    /// The rule that integrated it.
    pub quadrature: String,
    /// What it is compared with.
    pub description: String,
    /// In rest densities.
    pub rest_densities: Statistics,
}

/// Errors of distance and normal, in the whole band.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct DistanceErrors {
    /// Of the distance, metres.
    pub metres: Statistics,
    /// Of the distance, in support radii.
    pub radii: Statistics,
    /// Angle between the normal and the line to the closest point, degrees. It is large where that point jumps, between
    /// surfaces and inside of edges.
    pub normal_degrees: Statistics,
}

/// Errors on a slice.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SliceErrors {
    /// As `z=0.2`.
    pub plane: String,
    /// Whether it goes through the worst of the random points.
    pub through_worst: bool,
    /// Largest error of a pixel, as a part of the full ball.
    pub max: f64,
    /// Where, metres.
    pub worst: [f64; 3],
}

/// Thin walls and narrow gaps, at points spread evenly over the surface.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ThinPlaces {
    /// Number of points.
    pub points: usize,
    /// Longest edge of the cells, metres.
    pub cell: f64,
    /// Part of the surface by kind.
    pub kinds: Vec<ThinKind>,
    /// Thinnest walls.
    pub walls: Vec<Width>,
    /// Narrowest gaps.
    pub gaps: Vec<Width>,
}

/// Part of the surface of one kind.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ThinKind {
    /// Which.
    pub kind: Thin,
    /// In words.
    pub description: String,
    /// Part of the surface, 0 to 1.
    pub part: f64,
}

/// Where the two signs differ, at points close to the surface.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SignFacts {
    /// Points that were compared.
    pub points: usize,
    /// Points with different signs.
    pub disagreeing: usize,
    /// Some of those and their distances from the surface, metres, the farthest first.
    pub worst: Vec<([f64; 3], f64)>,
}

impl Findings {
    /// The JSON Schema of the file.
    pub fn schema() -> Json {
        schemars::schema_for!(Findings).to_value()
    }
}

/// The worst of the points in the fluid, against the best reference there is.
pub fn worst_point(samples: &[VolumeSample]) -> Option<DVec3> {
    let all = against(samples, best_reference(samples));
    let fluid = all.iter().filter(|m| m.distance >= 0.0);
    fluid.max_by(|a, b| a.error().abs().total_cmp(&b.error().abs())).map(|m| m.point)
}

/// A closed form, else the mesh itself, else the asset's own distance.
fn best_reference(samples: &[VolumeSample]) -> Reference {
    let known = |reference: &Reference| samples.iter().any(|s| s.references[*reference as usize].is_some());
    let order = [Reference::Shape, Reference::FineMesh];
    order.into_iter().find(known).unwrap_or(Reference::FineOwn)
}

fn against(samples: &[VolumeSample], reference: Reference) -> Vec<Measurement> {
    samples.iter().filter_map(|sample| sample.against(reference)).collect()
}

/// Sums up what was measured.
///
/// # Errors
/// An asset that says of its bake what no bake writes.
pub fn findings(
    measured: &Measured,
    settings: &ReportSettings,
    slices: &[ErrorSlice],
) -> Result<Findings, Error> {
    let (ball, radius) = (measured.model.ball, measured.model.radius);
    let reference = best_reference(&measured.volumes);
    let best = against(&measured.volumes, reference);
    let surface = measured.surface.as_ref();
    let of_levels = |map| levels::facts(map, measured.asset, measured.model, measured.solid, &best);
    Ok(Findings {
        format: "volmap-report".into(),
        format_version: 1,
        program_version: env!("CARGO_PKG_VERSION").into(),
        verdict: verdict(&best, reference, settings.max_error, ball)
            .unless_contradicted(surface.map(|surface| &surface.reference)),
        asset: asset_facts(measured),
        mesh: measured.solid.map(|solid| MeshFacts {
            file: solid.name.clone(),
            triangles: solid.mesh.triangles.len(),
            closed: solid.diagnosis.closed,
            warning: solid.warning.clone(),
        }),
        settings: SettingFacts {
            points: settings.points,
            mesh_points: measured.solid.map_or(0, |_| settings.mesh_points.min(settings.points)),
            seed: settings.seed,
            pixels: settings.pixels,
            fine_rule: FINE_RULE.to_string(),
        },
        volume: volume_errors(&measured.volumes, ball),
        parts: part_errors(&measured.volumes, ball),
        histogram: histogram(&best, ball),
        by_distance: by_distance(&best, ball, radius, BINS),
        density: surface.and_then(|surface| density_errors(measured, surface)),
        distance: surface.map(|surface| distance_errors(surface, radius)),
        levels: measured.levels.map(of_levels).transpose()?,
        slices: slices.iter().filter_map(slice_errors).collect(),
        thin: surface.map(|surface| thin_places(measured, &surface.widths)),
        reference_check: surface.map(|surface| surface.reference.clone()),
        signs: surface.map(|surface| SignFacts {
            points: surface.signs.points,
            disagreeing: surface.signs.disagreeing,
            worst: surface.signs.worst.clone(),
        }),
    })
}

impl Verdict {
    /// A reference that is wrong lets nothing pass.
    fn unless_contradicted(mut self, check: Option<&ReferenceCheck>) -> Verdict {
        if let Some(check) = check.filter(|check| check.contradictions > 0) {
            self.passed = self.passed.map(|_| false);
            self.text += &format!(
                " But winding numbers contradict the exact distance at {} of {} points: the figures \
                 can't be relied on.",
                check.contradictions, check.points
            );
        }
        self
    }
}

fn verdict(best: &[Measurement], reference: Reference, allowed: Option<f64>, ball: f64) -> Verdict {
    let fluid = Statistics::of(best.iter().filter(|m| Region::Fluid.holds(m.distance)), ball);
    let passed = allowed.map(|allowed| fluid.count > 0 && fluid.max <= allowed);
    let place = match fluid.worst {
        Some(worst) => {
            format!(", at ({}) m", worst.point.map(number).join(", "))
        }
        None => ": no point of the band lies in the fluid".into(),
    };
    let limit = match (passed, allowed) {
        (Some(true), Some(allowed)) => format!("; the limit is {}: passed", percent(allowed)),
        (Some(false), Some(allowed)) => format!("; the limit is {}: FAILED", percent(allowed)),
        _ => String::new(),
    };
    let text = format!(
        "The largest error of the volume in the fluid is {} of the full ball ({} m³){place}{limit}. Against {}, at {} \
         points; with 95 % confidence at most {} of the fluid near the surface has a larger one.",
        percent(fluid.max),
        number(fluid.max * ball),
        reference.describe(),
        thousands(fluid.count as u64),
        percent(fluid.beyond_max),
    );
    Verdict { passed, max_error: fluid.max, allowed, reference, text }
}

fn asset_facts(measured: &Measured) -> AssetFacts {
    let (asset, model) = (measured.asset, measured.model);
    let grid = model.map.grid();
    AssetFacts {
        support_radius: model.radius,
        ball_volume: model.ball,
        resolution: grid.resolution.to_array(),
        cell_size: grid.cell_size.to_array(),
        domain: [grid.origin, grid.max_corner()].map(|corner| corner.to_array()),
        band_cells: asset.band_count(),
        nodes: asset.signed_distance.len() as u64,
        quadrature: asset.quadrature.name.clone(),
        exterior: info::exterior(asset).into(),
        bake: info::object(&asset.bake),
        source: info::object(&asset.source),
    }
}

fn volume_errors(samples: &[VolumeSample], ball: f64) -> Vec<VolumeErrors> {
    let mut out = Vec::new();
    for reference in Reference::ALL {
        let all = against(samples, reference);
        for region in Region::ALL {
            let own = || all.iter().filter(|m| region.holds(m.distance));
            if own().next().is_some() {
                out.push(VolumeErrors {
                    reference,
                    description: reference.describe(),
                    region,
                    fraction: Statistics::of(own(), ball),
                    cubic_metres: Statistics::of(own(), 1.0),
                });
            }
        }
    }
    out
}

fn part_errors(samples: &[VolumeSample], ball: f64) -> Vec<PartErrors> {
    let errors = |part: ErrorPart| {
        let measurement = |sample: &VolumeSample| {
            let error = part.of(sample.parts.as_ref()?)?;
            let VolumeSample { point, distance, .. } = *sample;
            Some(Measurement { point, distance, value: error, reference: 0.0 })
        };
        let all: Vec<Measurement> = samples.iter().filter_map(measurement).collect();
        let fraction = Statistics::of(all.iter(), ball);
        (fraction.count > 0).then(|| PartErrors { part, description: part.describe().into(), fraction })
    };
    ErrorPart::ALL.into_iter().filter_map(errors).collect()
}

fn density_errors(measured: &Measured, surface: &SurfaceFindings) -> Option<DensityErrors> {
    let (field, errors) = (measured.asset.density.as_ref()?, surface.density.as_ref()?);
    Some(DensityErrors {
        kernel: field.kernel.clone(),
        quadrature: field.quadrature.clone(),
        description: format!("{PAPER_RULE} on the exact distance to the mesh"),
        rest_densities: Statistics::of(errors.iter(), 1.0),
    })
}

fn distance_errors(surface: &SurfaceFindings, radius: f64) -> DistanceErrors {
    let errors = &surface.errors;
    DistanceErrors {
        metres: Statistics::of(errors.distance.iter(), 1.0),
        radii: Statistics::of(errors.distance.iter(), radius),
        normal_degrees: Statistics::of(errors.normal.iter(), 1.0),
    }
}

fn slice_errors(slice: &ErrorSlice) -> Option<SliceErrors> {
    let (point, error) = slice.worst?;
    Some(SliceErrors {
        plane: slice.volume.lattice.plane.to_string(),
        through_worst: slice.through_worst,
        max: error.abs(),
        worst: point.to_array(),
    })
}

fn thin_places(measured: &Measured, widths: &[Width]) -> ThinPlaces {
    let cell = thin::cell(measured.model);
    let kind = |kind: Thin| {
        let count = widths.iter().filter(|width| width.kind(cell, measured.model.radius) == kind).count();
        let part = count as f64 / widths.len().max(1) as f64;
        ThinKind { kind, description: kind.describe().into(), part }
    };
    let narrowest = |size: fn(&Width) -> Option<f64>| {
        let mut found: Vec<Width> = widths.iter().filter(|width| size(width).is_some()).copied().collect();
        found.sort_by(|a, b| size(a).unwrap_or(0.0).total_cmp(&size(b).unwrap_or(0.0)));
        found.truncate(NARROWEST);
        found
    };
    ThinPlaces {
        points: widths.len(),
        cell,
        kinds: Thin::ALL.into_iter().map(kind).collect(),
        walls: narrowest(|width| width.wall),
        gaps: narrowest(|width| width.gap),
    }
}
