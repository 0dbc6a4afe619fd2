//! Measuring, drawing, exporting and reproducing end soon after they were asked to, and leave no file.

use std::path::Path;
use std::sync::{Arc, Mutex};
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::density_map::DensitySettings;
use volmap_bake::input::{Input, InputSettings, from_bytes};
use volmap_bake::settings::{GridChoice, MapSettings};
use volmap_bake::watch::{Cancel, Watch};
use volmap_figures::picture::{Axis, Plane};
use volmap_formats::asset::Asset;
use volmap_report::Error;
use volmap_report::export::{ExportSettings, export};
use volmap_report::report::{ReportSettings, report};
use volmap_report::reproduce::{
    EXPERIMENTS, ReproduceSettings, dragon::DragonSettings, duck::DuckSettings, kinds::KindsSettings,
    plane::PlaneSettings,
};
use volmap_report::slice::{SliceField, SliceSettings, slice};
use volmap_runtime::VolumeMap;

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

fn cube() -> Input {
    from_bytes(Path::new("cube.obj"), CUBE, &InputSettings::default()).unwrap()
}

fn asset() -> Asset {
    let map = MapSettings {
        support_radius: Some(0.2),
        grid: GridChoice::CellSize(0.2),
        density: Some(DensitySettings::default()),
        ..MapSettings::default()
    };
    bake(cube(), &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap().asset
}

/// The steps of the work, at each of which it can be cancelled.
fn cancelled_at_each_step<T>(work: impl Fn(&Watch) -> Result<T, Error>) -> Vec<&'static str> {
    let names = Arc::new(Mutex::new(Vec::new()));
    let list = names.clone();
    work(&Watch::new(move |step| list.lock().unwrap().push(step.name))).unwrap();
    let names = names.lock().unwrap().clone();
    for (number, name) in names.iter().enumerate() {
        let (cancel, heard) = (Cancel::default(), Arc::new(Mutex::new(0)));
        let (own, count) = (cancel.clone(), heard.clone());
        let watch = Watch::new(move |_| {
            let mut count = count.lock().unwrap();
            *count += 1;
            if *count == number + 1 {
                own.cancel();
            }
        });
        let is_last = number + 1 == names.len();
        match work(&watch.stopped_by(&cancel)) {
            Err(error) => assert!(error.is_cancelled(), "{name}: {error}"),
            // What is written is written whole.
            Ok(_) => assert!(is_last && *name == "writing", "{name}: not cancelled"),
        }
        assert_eq!(*heard.lock().unwrap(), number + 1, "{name}: no step begins afterwards");
    }
    names
}

#[test]
fn reports_end_at_any_step() {
    let asset = asset();
    let settings = ReportSettings { points: 60, mesh_points: 10, pixels: 16, ..ReportSettings::default() };
    let steps = cancelled_at_each_step(|watch| report(&asset, Some(cube()), &settings, watch));
    let expected = [
        "preparing",
        "integrating at random points",
        "integrating the density",
        "measuring the distance",
        "comparing the signs",
        "checking the exact distance",
        "measuring walls and gaps",
        "integrating at pixels",
        "drawing",
        "measuring walls and gaps",
        "measuring walls and gaps",
        "measuring walls and gaps",
    ];
    assert_eq!(steps, expected);
    let json = |watch| {
        let found = report(&asset, Some(cube()), &settings, watch).unwrap();
        serde_json::to_string(&found.findings).unwrap()
    };
    assert!(json(&Watch::default()) == json(&Watch::new(|_| ())), "the watch changed the findings");
}

#[test]
fn slices_end_at_any_step() {
    let map = VolumeMap::from_asset(&asset()).unwrap();
    let settings = SliceSettings {
        plane: Plane { axis: Axis::Z, at: 0.5 },
        field: SliceField::Volume,
        pixels: 40,
        contours: Vec::new(),
    };
    let steps = cancelled_at_each_step(|watch| slice(&map, &settings, None, watch));
    assert_eq!(steps, ["asking the map at pixels", "drawing"]);
    let drawn = |watch| slice(&map, &settings, None, watch).unwrap().figure.to_png();
    assert!(drawn(&Watch::default()) == drawn(&Watch::new(|_| ())), "the watch changed the picture");
}

#[test]
fn exports_end_at_any_step_and_leave_no_file() {
    let asset = asset();
    for extension in ["vtkhdf", "vti", "ply", "cdm", "cdf"] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("map.{extension}"));
        let steps = cancelled_at_each_step(|watch| {
            let _ = std::fs::remove_file(&path);
            let written = export(&asset, &path, &ExportSettings::default(), watch);
            let files = std::fs::read_dir(folder.path()).unwrap().count();
            assert_eq!(files, usize::from(written.is_ok()), "{extension}");
            written
        });
        assert!(steps.len() > 1, "{extension}: {steps:?}");
    }
}

#[test]
fn experiments_end_at_any_step() {
    let settings = ReproduceSettings {
        duck: DuckSettings {
            cells: 4,
            radius: 0.3,
            pixels: 8,
            points: 20,
            mesh_points: 4,
            target: 1.0,
            most_cells: 8,
        },
        plane: PlaneSettings { cells: 6, particle_radius: 0.05, steps: 10 },
        dragon: DragonSettings { mesh: Some(cube()), cells: [6; 3], radius: 0.2 },
        density: KindsSettings { volume_cells: 4, density_cells: 5, runs: 1 },
    };
    for experiment in EXPERIMENTS {
        let steps = cancelled_at_each_step(|watch| (experiment.run)(&settings, watch));
        assert!(steps.contains(&"integrating the volume"), "{steps:?}");
    }
}
