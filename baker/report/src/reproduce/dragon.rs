//! Section 5 of Bender et al. 2020: a dragon's map of 60 x 40 x 40 cells takes 35.7 MB with every cell, 6.4 MB with
//! those that have a point within 2 r of the surface.
//!
//! The paper's bytes are those of its program: per field 8 a node, 132 a cell. (Its other figures are binary
//! megabytes of these to 0.1 %: [`paper_bytes`].)

use super::{MIB, baked, missing, outcome, row};
use crate::error::Error;
use crate::experiments::Outcome;
use volmap_bake::density_map::cost::paper_bytes;
use volmap_bake::input::Input;
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::watch::Watch;

/// What is measured.
#[derive(Clone, Debug)]
pub struct DragonSettings {
    /// The dragon, which is not ours to ship.
    pub mesh: Option<Input>,
    /// Cells along each axis.
    pub cells: [u32; 3],
    /// Support radius, metres.
    pub radius: f64,
}

impl Default for DragonSettings {
    fn default() -> DragonSettings {
        DragonSettings { mesh: None, cells: [60, 40, 40], radius: 0.1 }
    }
}

/// Bytes of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bytes {
    /// In the paper's program, with what it leaves out.
    paper_sparse: u64,
    /// As we hold it, every cell of the grid.
    dense: u64,
    /// As we hold it.
    sparse: u64,
}

/// Runs the experiment; without a mesh only what doesn't need it.
///
/// # Errors
/// Settings or a mesh that can't be used; cancelled.
pub fn measure(settings: &DragonSettings, watch: &Watch) -> Result<Outcome, Error> {
    let [x, y, z] = settings.cells;
    let r = settings.radius;
    let mib = |bytes: u64| bytes as f64 / MIB;
    let dense = mib(paper_bytes(settings.cells));
    let mut rows =
        vec![row(format!("dense, {x} x {y} x {z} cells, the paper's layout"), "MiB", Some(35.7), dense)];
    let names = [
        "sparse, the paper's layout, box grown by 8 r",
        "sparse, the paper's layout, box grown by 2 r",
        "dense over sparse, the paper's layout, box grown by 8 r",
        "sparse, ours, box grown by 8 r",
        "sparse, ours, box grown by 2 r",
        "dense, ours",
    ];
    let Some(mesh) = &settings.mesh else {
        let remark = "needs the mesh: `dragon`";
        rows.push(missing("sparse", "MiB", Some(6.4), remark));
        rows.push(missing("dense over sparse", "", Some(5.5), remark));
        return Ok(outcome(rows, assumed(r, None)));
    };
    watch.step("baking the dragon")?;
    let [wide, narrow] = [bytes(mesh, settings, 6.0 * r, watch)?, bytes(mesh, settings, 0.0, watch)?];
    let figures = [
        (Some(6.4), mib(wide.paper_sparse), "MiB"),
        (Some(6.4), mib(narrow.paper_sparse), "MiB"),
        (Some(5.5), dense / mib(wide.paper_sparse), ""),
        (None, mib(wide.sparse), "MiB"),
        (None, mib(narrow.sparse), "MiB"),
        (None, mib(narrow.dense), "MiB"),
    ];
    rows.extend(
        names.into_iter().zip(figures).map(|(name, (paper, ours, unit))| row(name, unit, paper, ours)),
    );
    Ok(outcome(rows, assumed(r, Some(mesh))))
}

fn assumed(radius: f64, mesh: Option<&Input>) -> Vec<String> {
    let mut out = vec![
        "MB are 2^20 bytes, as in the paper's other figures".to_owned(),
        "the paper's layout: signed distance and volume, each 8 bytes a node, 128 a stored cell, 4 a cell of the grid; \
         ours: 4 a node"
            .into(),
    ];
    if let Some(mesh) = mesh {
        out.push(format!(
            "{}, support radius {radius} m: the paper gives neither the dragon's size nor r, and what is within 2 r \
             depends on both. Its domain is the box grown by \"at least\" r; its program grows it by 8 r, we by 2 r \
             (smaller cells, of which more are near)",
            mesh.source.file
        ));
    }
    out
}

fn bytes(mesh: &Input, settings: &DragonSettings, padding: f64, watch: &Watch) -> Result<Bytes, Error> {
    let map = MapSettings {
        support_radius: Some(settings.radius),
        grid: GridChoice::Resolution(settings.cells),
        padding,
        ..MapSettings::default()
    };
    let summary = baked(mesh.clone(), map, watch)?.summary;
    let [dense, sparse] = summary.field_bytes;
    let paper_sparse = 2 * (8 * summary.nodes as u64 + 128 * summary.cells.band + 4 * summary.cells.grid);
    Ok(Bytes { paper_sparse, dense, sparse })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::unit_cube_input;

    #[test]
    fn without_the_mesh_only_what_needs_none_is_told() {
        let Outcome { rows, .. } = measure(&DragonSettings::default(), &Watch::default()).unwrap();
        let [dense, sparse, factor] = &rows[..] else { panic!("{rows:?}") };
        assert!((dense.ratio().unwrap() - 1.0).abs() < 0.03, "{dense:?}");
        for row in [sparse, factor] {
            assert!(row.measured.is_nan() && row.ratio().is_none());
            assert!(row.remark.as_ref().unwrap().contains("`dragon`"));
        }
    }

    /// A cube whose band is known: cells of 0.1 m, of which all but the innermost are within 2 r = 0.2 m.
    #[test]
    fn bytes_are_those_of_the_cells_within_two_radii() {
        let settings = DragonSettings { mesh: None, cells: [14; 3], radius: 0.1 };
        let cube = unit_cube_input().unwrap();
        let found = bytes(&cube, &settings, 0.0, &Watch::default()).unwrap();
        let dense = paper_bytes([14; 3]);
        // Outer cells at the cube's edges are farther away than 2 r.
        assert!(found.paper_sparse > dense * 8 / 10 && found.paper_sparse < dense, "{found:?} of {dense}");
        assert!(found.sparse < found.dense && found.dense < dense / 4, "{found:?}");
        let all = DragonSettings { mesh: Some(cube), ..settings };
        let Outcome { rows, .. } = measure(&all, &Watch::default()).unwrap();
        assert_eq!(rows.len(), 7);
        assert!(rows[1].measured < rows[2].measured && rows[4].measured < rows[5].measured, "{rows:?}");
    }
}
