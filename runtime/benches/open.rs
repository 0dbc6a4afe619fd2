//! Time to open and to write assets: `cargo bench -p volmap-runtime --bench open -- ASSET...`; without names, an
//! asset of 5 MB made here. Medians and the fastest of many runs, as other programs run on the machine too.

use std::path::{Path, PathBuf};
use std::time::Instant;
use volmap_formats::asset::{
    self, Array, Asset, Attributes, CellRun, Compression, Dimension, Exterior, GridSpec, QuadratureSpec,
};
use volmap_runtime::layout::Nodes;
use volmap_runtime::{DVec3, Grid, VolumeMap};

const RUNS: usize = 40;

fn main() {
    let given: Vec<PathBuf> =
        std::env::args().skip(1).filter(|a| !a.starts_with('-')).map(Into::into).collect();
    let folder = std::env::temp_dir().join("volmap-bench-open");
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let made = folder.join("sphere.h5");
    let assets = if given.is_empty() {
        asset::write(&made, &sphere(80), Compression::default()).expect("an asset");
        vec![made]
    } else {
        given
    };
    for path in assets {
        measure(&path, &folder.join("copy.h5"));
    }
    std::fs::remove_dir_all(&folder).expect("the temporary folder");
}

fn measure(path: &Path, copy: &Path) {
    let asset = asset::read(path).expect("an asset");
    let bytes = std::fs::read(path).expect("a file");
    let loaded = VolumeMap::from_asset(&asset).expect("a map").memory_bytes();
    println!("{}: {} bytes, {loaded} loaded, {} nodes", path.display(), bytes.len(), asset.volume.len());
    time("asset::from_bytes", || asset::from_bytes(bytes.clone()).expect("an asset"));
    time("VolumeMap::from_asset", || VolumeMap::from_asset(&asset).expect("a map"));
    time("VolumeMap::open", || VolumeMap::open(path).expect("a map"));
    time("asset::write", || asset::write(copy, &asset, Compression::default()).expect("written"));
}

fn time<T>(name: &str, work: impl Fn() -> T) {
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            let result = work();
            let elapsed = start.elapsed().as_secs_f64();
            drop(result);
            elapsed
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    println!("  {name:24} {:8.3} ms median, {:8.3} ms fastest", seconds[RUNS / 2] * 1e3, seconds[0] * 1e3);
}

/// A sphere of radius 0.5 m in a box of edge 1.4 m, r = 0.1 m: |Phi| <= 2 r, at N^3 cells.
fn sphere(n: u32) -> Asset {
    let spec = GridSpec { origin: [-0.7; 3], cell_size: [1.4 / f64::from(n); 3], resolution: [n; 3] };
    let grid = Grid::from(spec);
    let mut band: Vec<CellRun> = Vec::new();
    for (k, j, i) in (0..n * n * n).map(|c| (c / (n * n), c / n % n, c % n)) {
        let center = grid.origin + grid.cell_size * (DVec3::new(i.into(), j.into(), k.into()) + 0.5);
        if (center.length() - 0.5).abs() > 0.2 {
            continue;
        }
        match band.last_mut().filter(|run| (run.k, run.j, run.i + run.len) == (k, j, i)) {
            Some(run) => run.len += 1,
            None => band.push(CellRun { i, j, k, len: 1 }),
        }
    }
    let nodes = Nodes::new(grid.resolution, &band).expect("few nodes");
    let distance: Vec<f64> = nodes.positions(&grid).map(|x| x.length() - 0.5).collect();
    let volume = distance.iter().map(|phi: &f64| (0.2 - phi).max(0.0).powi(3) as f32).collect();
    Asset {
        dimension: Dimension::Three,
        grid: spec,
        support_radius: 0.1,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec { name: "none".into(), degree: 1, points: 1, ball_volume: 0.1 },
        band_cells: band,
        solid_cells: Vec::new(),
        finer: Vec::new(),
        signed_distance: Array::F32(distance.iter().map(|&phi| phi as f32).collect()),
        volume: Array::F32(volume),
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    }
}
