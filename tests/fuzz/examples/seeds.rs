//! Writes the seeds of the fuzz targets into `corpus/`: small assets and every mesh sample.

#[allow(dead_code)]
#[path = "../../../formats/tests/mesh/samples.rs"]
mod samples;

use std::path::Path;
use volmap_formats::asset::{
    self, Array, Asset, CellRun, Compression, Dimension, Exterior, GridSpec, LevelCells, QuadratureSpec,
};
use volmap_formats::export::cdm;
use volmap_formats::mesh::MeshFormat;
use volmap_report::export::discregrid::discregrid;

/// One cell of the band beside one of the solid, its 32 nodes made up.
fn asset() -> Asset {
    let field = |scale: f32| Array::F32((0..32).map(|n| scale * (n as f32 - 16.0)).collect());
    let options = (0..12).map(|k| (format!("option_{k}"), f64::from(k).into()));
    Asset {
        dimension: Dimension::Three,
        grid: GridSpec { origin: [0.0; 3], cell_size: [0.5; 3], resolution: [2, 1, 1] },
        support_radius: 0.1,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec { name: "gl4".into(), degree: 4, points: 19, ball_volume: 0.004 },
        band_cells: vec![CellRun { i: 0, j: 0, k: 0, len: 1 }],
        solid_cells: vec![CellRun { i: 1, j: 0, k: 0, len: 1 }],
        finer: Vec::new(),
        signed_distance: field(0.01),
        volume: field(0.0001),
        density: None,
        plane_weight: None,
        bake: options.collect(),
        source: [("mesh".to_owned(), "box.obj".into())].into(),
        diagnosis: [("closed".to_owned(), true.into())].into(),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for target in ["import_cdm", "open_asset", "open_content", "read_mesh"] {
        std::fs::create_dir_all(corpus.join(target))?;
    }
    asset::write(&corpus.join("open_asset/zstd"), &asset(), Compression::Zstd(1))?;
    asset::write(&corpus.join("open_asset/gzip"), &asset(), Compression::Gzip(1))?;
    let mut short = asset();
    short.bake.clear();
    asset::write(&corpus.join("open_asset/short"), &short, Compression::Zstd(1))?;
    // Beside the cell an eighth of one that doesn't touch it: all 64 nodes are free.
    let corner = LevelCells { band: vec![CellRun { i: 3, j: 0, k: 0, len: 1 }], solid: Vec::new() };
    let field = |scale: f32| Array::F32((0..64).map(|n| scale * (n as f32 - 16.0)).collect());
    let adaptive = Asset {
        solid_cells: Vec::new(),
        finer: vec![corner],
        signed_distance: field(0.01),
        volume: field(0.0001),
        plane_weight: Some(vec![1; 16]),
        ..asset()
    };
    asset::write(&corpus.join("open_asset/adaptive"), &adaptive, Compression::Zstd(1))?;
    // Grid, radius, exterior, volume of the ball; one run in the band, none in the solid; no finer
    // level; two fields; points.
    let content = [&[1; 12][..], &[1, 0, 0, 0, 1, 0, 0, 3, 9, 3, 5], &[8; 40]].concat();
    std::fs::write(corpus.join("open_content/one_cell"), content)?;
    std::fs::write(corpus.join("import_cdm/one_cell"), cdm::to_bytes(&discregrid(&asset(), true)?))?;
    for (number, sample) in samples::boxes().into_iter().enumerate() {
        let format = MeshFormat::ALL.iter().position(|&f| f == sample.format).unwrap_or(0) as u8;
        std::fs::write(corpus.join(format!("read_mesh/{number}")), [&[format][..], &sample.bytes].concat())?;
    }
    Ok(())
}
