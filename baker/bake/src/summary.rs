//! The summary of a bake: what a person wants to know of it, and how it is printed.

use crate::adaptive::Adapted;
use crate::input::MeshSource;
use crate::mesh::{Diagnosis, OrientationRepair};
use crate::plan::Plan;
use crate::primitive::PlacedPrimitive;
use crate::sdf::Overlaps;
use crate::sdf::sign::SignChoice;
use crate::sdf::sign_comparison::SignComparison;
use crate::sdf::thin::ThinPlaces;
use crate::settings::density::DensitySettings;
pub use crate::storage::Rounding;
use crate::tolerance::Found;
use glam::DVec3;
use std::fmt::{self, Display, Formatter};
use volmap_formats::mesh::{CleanReport, Placement};
use volmap_formats::text::{bytes, number, percent, significant, thousands};

/// What a person wants to know of a bake.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The mesh's file.
    pub source: MeshSource,
    /// What cleaning did.
    pub cleaning: CleanReport,
    /// The shape that the mesh stands for, if none was read.
    pub shape: Option<PlacedPrimitive>,
    /// What was done to the file's coordinates.
    pub placement: Placement,
    /// Box of the placed mesh, metres.
    pub bounds: [DVec3; 2],
    /// What is wrong with the mesh, after the repair.
    pub diagnosis: Diagnosis,
    /// What orienting did.
    pub repair: OrientationRepair,
    /// The sign in use.
    pub sign: SignChoice,
    /// The sign is right at every point.
    pub has_exact_sign: bool,
    /// Faces of cells at which inside meets outside without a surface between.
    pub leaks: u64,
    /// Where the two signs differ, if that was asked for or the sign isn't exact.
    pub sign_comparison: Option<SignComparison>,
    /// What overlaps in the mesh.
    pub overlaps: Overlaps,
    /// Walls and gaps thinner than a cell.
    pub thin: ThinPlaces,
    /// Step of the file's numbers, metres, where they look rounded.
    pub coordinate_step: Option<f64>,
    /// The grid and the estimate of the cost.
    pub plan: Plan,
    /// Cells of the grid, of the band and beyond it in the solid.
    pub cells: CellCounts,
    /// Nodes of the band.
    pub nodes: usize,
    /// How the cells were found, if a tolerance was asked for.
    pub tolerance: Option<Found>,
    /// How cells of several sizes were found.
    pub adapted: Option<Adapted>,
    /// How the tolerance was found, if the file's size was given.
    pub sized: Option<Sized>,
    /// Bytes of all fields if every cell of the grid were stored, and for the band alone.
    pub field_bytes: [u64; 2],
    /// How the density was computed, if it was.
    pub density: Option<DensitySettings>,
    /// What storing the fields changed, if they were rounded to 16 bits.
    pub rounding: Option<Rounding>,
    /// Stages and their seconds, in order.
    pub seconds: Vec<(&'static str, f64)>,
    /// What a careful person would look at.
    pub warnings: Vec<String>,
}

/// How the tolerance for a file's size was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Sized {
    /// Bytes that were asked for.
    pub limit: u64,
    /// Tolerances of the volume and bytes of their files, in the order in which they were tried.
    pub tried: Vec<(f64, u64)>,
}

/// Cells by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellCounts {
    /// Of the whole grid.
    pub grid: u64,
    /// Stored.
    pub band: u64,
    /// Deeper in the solid than the band.
    pub solid: u64,
}

impl Summary {
    /// Part of the nodes at which the sign is in doubt, because both ways to tell it differ there, or inside meets
    /// outside (a face counts as a cell of the band).
    pub fn sign_doubt(&self) -> f64 {
        if self.has_exact_sign {
            return 0.0;
        }
        let part = |count: u64, all: u64| count as f64 / all.max(1) as f64;
        let compared = self.sign_comparison.as_ref();
        let differing = compared.map_or(0.0, |signs| part(signs.disagreeing as u64, signs.points as u64));
        (differing + part(self.leaks, self.cells.band)).min(1.0)
    }
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        self.fmt_mesh(f)?;
        self.fmt_grid(f)?;
        self.fmt_fields(f)?;
        let stages: Vec<String> =
            self.seconds.iter().map(|(name, seconds)| format!("{name} {seconds:.3}")).collect();
        let total: f64 = self.seconds.iter().map(|(_, seconds)| seconds).sum();
        write!(f, "time       {} s: {}", number(total), stages.join(", "))?;
        self.warnings.iter().try_for_each(|warning| write!(f, "\nwarning    {warning}"))
    }
}

impl Summary {
    fn fmt_mesh(&self, f: &mut Formatter) -> fmt::Result {
        let [min, max] = self.bounds.map(|corner| triple(corner.to_array()));
        match &self.shape {
            Some(placed) => self.fmt_shape(f, placed)?,
            None => {
                writeln!(f, "mesh       {}: {}", self.source.file, self.faces())?;
                writeln!(f, "           {}", self.state())?;
            }
        }
        writeln!(f, "           box {min} to {max} m, area {} m^2", digits(self.diagnosis.area))?;
        if let Some(placed) = self.placed() {
            writeln!(f, "placed     {placed}")?;
        }
        self.holes(f)?;
        writeln!(f, "sign       {}", self.sign.reason)
    }

    fn fmt_shape(&self, f: &mut Formatter, placed: &PlacedPrimitive) -> fmt::Result {
        let triangles = thousands(self.diagnosis.triangles as u64);
        writeln!(f, "shape      {}; in pictures {triangles} triangles", placed.shape())?;
        match placed.shape().is_unbounded() {
            true => writeln!(f, "           a half-space, as far as the domain"),
            false => writeln!(f, "           volume {} m^3", digits(placed.shape().volume())),
        }
    }

    fn fmt_grid(&self, f: &mut Formatter) -> fmt::Result {
        let grid = self.plan.grid;
        let [x, y, z] = grid.resolution.to_array();
        let (size, radius) = (edges(grid.cell_size.to_array()), self.plan.support_radius);
        writeln!(f, "grid       {x} x {y} x {z} cells of {size} m, support radius {radius} m")?;
        let CellCounts { grid: all, band, .. } = self.cells;
        match &self.adapted {
            Some(found) => fmt_levels(found, band, f)?,
            None => {
                let kept = percent(band as f64 / all as f64);
                writeln!(f, "cells      {} of {} kept ({kept})", thousands(band), thousands(all))?;
            }
        }
        if let Some(found) = &self.tolerance {
            writeln!(f, "tolerance  {}", found_cells(found))?;
        }
        if let Some(sized) = &self.sized {
            writeln!(f, "size       {}", found_size(sized))?;
        }
        let [dense, sparse] = self.field_bytes;
        writeln!(f, "memory     {} dense, {} sparse", bytes(dense), bytes(sparse))
    }

    fn fmt_fields(&self, f: &mut Formatter) -> fmt::Result {
        if let Some(density) = &self.density {
            let (kernel, rule) = (density.kernel, density.rule);
            writeln!(f, "density    over rest density, for the kernel {kernel}, by {rule}")?;
        }
        let Some(rounding) = self.rounding else { return Ok(()) };
        let [allowed, distance, volume] = [rounding.allowed, rounding.distance, rounding.volume].map(percent);
        writeln!(
            f,
            "rounding   16 bits, at the nodes at most {allowed} of r and of the ball; the worst is {distance} and \
             {volume}"
        )?;
        if self.density.is_some() {
            let worst = percent(rounding.density);
            writeln!(f, "           and at most {allowed} of rest density; the worst is {worst}")?;
        }
        Ok(())
    }
}

/// Holes that are listed.
const MAX_HOLES: usize = 6;

impl Summary {
    /// What was done to the file's coordinates, in the order in which it was done.
    fn placed(&self) -> Option<String> {
        let (now, asis) = (&self.placement, Placement::default());
        let mut steps = Vec::new();
        if now.unit != asis.unit {
            steps.push(format!("unit {} m", now.unit));
        }
        if now.up_axis != asis.up_axis {
            steps.push(format!("{:?} up", now.up_axis).to_lowercase());
        }
        if now.scale != asis.scale {
            let [x, y, z] = now.scale;
            steps.push(if x == y && y == z { format!("scale {x}") } else { format!("scale {x}, {y}, {z}") });
        }
        if now.rotation.degrees != 0.0 {
            steps.push(format!("{} degrees around {:?}", now.rotation.degrees, now.rotation.axis));
        }
        if now.translation != asis.translation {
            steps.push(format!("moved by {:?} m", now.translation));
        }
        (!steps.is_empty()).then(|| steps.join(", then "))
    }

    fn holes(&self, f: &mut Formatter) -> fmt::Result {
        let found = &self.diagnosis;
        for rim in found.boundary_loops.iter().take(MAX_HOLES) {
            let (length, centre) = (digits(rim.length), triple(rim.centroid));
            writeln!(
                f,
                "hole       {} edges, {length} m long, around {centre} m",
                thousands(rim.edges as u64)
            )?;
        }
        match found.boundary_loop_count.saturating_sub(MAX_HOLES) {
            0 => Ok(()),
            more => writeln!(f, "           and {more} shorter"),
        }
    }

    fn faces(&self) -> String {
        let cleaning = &self.cleaning;
        let mut parts = vec![format!("{} triangles", thousands(self.diagnosis.triangles as u64))];
        let found = [
            (cleaning.quads, "quad split", "quads split"),
            (cleaning.polygons, "polygon split", "polygons split"),
            (cleaning.welded, "vertex welded", "vertices welded"),
            (cleaning.degenerate, "degenerate face dropped", "degenerate faces dropped"),
            (cleaning.duplicates, "duplicate face dropped", "duplicate faces dropped"),
            (cleaning.unreferenced, "unused vertex dropped", "unused vertices dropped"),
            (cleaning.zero_area, "without area", "without area"),
            (cleaning.fan_fallbacks, "polygon that intersects itself", "polygons that intersect themselves"),
            (cleaning.skipped.points, "point left out", "points left out"),
            (cleaning.skipped.lines, "line left out", "lines left out"),
            (cleaning.skipped.other, "other element left out", "other elements left out"),
        ];
        if cleaning.objects > 1 {
            parts.push(format!("{} objects joined", cleaning.objects));
        }
        for (n, one, many) in found.into_iter().filter(|(n, ..)| *n > 0) {
            parts.push(format!("{} {}", thousands(n as u64), if n == 1 { one } else { many }));
        }
        parts.join(", ")
    }

    fn state(&self) -> String {
        let found = &self.diagnosis;
        let yes = |is: bool, what: &str| if is { what.to_owned() } else { format!("NOT {what}") };
        let mut parts = vec![
            yes(found.closed, "closed"),
            yes(found.oriented, "oriented"),
            yes(found.manifold_edges && found.manifold_vertices, "manifold"),
            format!("{} component{}", found.components, if found.components == 1 { "" } else { "s" }),
        ];
        if found.closed && found.balanced {
            parts.push(format!("volume {} m^3", digits(found.volume)));
        }
        if found.cavities.count > 0 {
            parts.push(format!("{} hollow", found.cavities.count));
        }
        parts.join(", ")
    }
}

/// The cells of each level, and their errors.
fn fmt_levels(found: &Adapted, cells: u64, f: &mut Formatter) -> fmt::Result {
    let level = |(level, count): (usize, &u64)| {
        let edge = found.coarsest / f64::from(1u32 << level);
        format!("{} of {} m", thousands(*count), digits(edge))
    };
    let levels: Vec<String> = found.cells.iter().enumerate().map(level).collect();
    let form =
        if found.by_difference { "stored as its difference from a flat wall's" } else { "stored as it is" };
    writeln!(f, "cells      {}: {}; volume {form}", thousands(cells), levels.join(", "))?;
    let (asked, errors) = (&found.tolerances, &found.errors);
    writeln!(
        f,
        "tolerance  {} of the ball: largest error {}, rms {}, at {} of {} points of the fluid, against {} on the \
         exact distance",
        percent(asked.volume),
        percent(errors.volume.max),
        percent(errors.volume.rms),
        thousands(errors.volume.points as u64),
        thousands(found.points as u64),
        found.reference
    )?;
    writeln!(
        f,
        "           distance: largest error {} of the support radius (asked for {}), rms {}; normal: {} degrees at 99 \
         % of the points{}",
        percent(errors.distance.max),
        percent(asked.distance),
        percent(errors.distance.rms),
        significant(errors.normal.max.to_degrees(), 3),
        asked.normal.map_or(String::new(), |angle| format!(" (asked for {})", digits(angle.to_degrees())))
    )
}

/// What the search for the tolerance found.
fn found_cells(found: &Found) -> String {
    let tried: Vec<String> =
        found.tried.iter().map(|(cell, max)| format!("{} m: {}", digits(*cell), percent(*max))).collect();
    format!(
        "{} of the ball: largest error {} at {} points of the fluid, rms {}, against {} on the exact distance\n     \
              \
         tried {}",
        percent(found.tolerance),
        percent(found.error.max),
        thousands(found.error.points as u64),
        percent(found.error.rms),
        found.reference,
        tried.join(", ")
    )
}

/// What the search for the size found.
fn found_size(Sized { limit, tried }: &Sized) -> String {
    let tried: Vec<String> =
        tried.iter().map(|(tolerance, size)| format!("{}: {}", percent(*tolerance), bytes(*size))).collect();
    format!("{} at most; tolerances that were tried: {}", bytes(*limit), tried.join(", "))
}

fn edges([x, y, z]: [f64; 3]) -> String {
    match x == y && y == z {
        true => digits(x),
        false => [x, y, z].map(digits).join(" x "),
    }
}

fn triple(x: [f64; 3]) -> String {
    format!("({})", x.map(digits).join(", "))
}

/// Lengths, areas and volumes with four digits.
fn digits(x: f64) -> String {
    significant(x, 4)
}
