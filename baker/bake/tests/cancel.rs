//! Long work ends soon after it was asked to, whatever step it is at; a watch changes no result.

use glam::{DVec2, DVec3};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use volmap_bake::Error;
use volmap_bake::area_map::{self, AreaDensity, AreaSettings};
use volmap_bake::bake::{BakeSettings, bake, bake_distance};
use volmap_bake::density_map::DensitySettings;
use volmap_bake::input::{Input, InputSettings, from_bytes};
use volmap_bake::iso_surface::iso_surface;
use volmap_bake::plan::Extent;
use volmap_bake::settings::{GridChoice, MapSettings, Tolerances};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::{Cancel, Watch};
use volmap_runtime::VolumeMap;

/// Runs the work once unwatched, and once for each of its steps, at whose beginning it is cancelled.
fn cancelled_at_each_step<T: PartialEq + std::fmt::Debug>(
    steps: &[&str],
    work: impl Fn(&Watch) -> Result<T, Error>,
) {
    let (heard, names) = (Arc::new(Mutex::new(Vec::new())), Arc::new(Mutex::new(Vec::new())));
    let (at, list) = (heard.clone(), names.clone());
    let watch = Watch::new(move |step| list.lock().unwrap().push(step.name));
    assert!(work(&watch).unwrap() == work(&Watch::default()).unwrap(), "the watch changed the result");
    let names = names.lock().unwrap().clone();
    assert_eq!(names, steps);
    for (number, name) in names.iter().enumerate() {
        at.lock().unwrap().clear();
        let (heard, cancel) = (heard.clone(), Cancel::default());
        let own = cancel.clone();
        let watch = Watch::new(move |step| {
            let mut heard = heard.lock().unwrap();
            heard.push(step.name);
            if heard.len() == number + 1 {
                own.cancel();
            }
        });
        match work(&watch.stopped_by(&cancel)) {
            Err(error) => assert!(error.is_cancelled(), "{name}: {error}"),
            Ok(_) => panic!("{name}: not cancelled"),
        }
        assert_eq!(*at.lock().unwrap(), names[..=number], "no step begins afterwards");
    }
}

fn notched() -> Input {
    let mesh = include_bytes!("data/notched.obj");
    from_bytes(Path::new("notched.obj"), &mesh[..], &InputSettings::default()).unwrap()
}

#[test]
fn bakes_end_at_any_step() {
    let map = MapSettings {
        support_radius: Some(0.4),
        grid: GridChoice::CellSize(0.4),
        density: Some(DensitySettings::default()),
        ..MapSettings::default()
    };
    let settings = BakeSettings { map, check_sign: true, ..BakeSettings::default() };
    let steps = [
        "examining the mesh",
        "building the tree",
        "finding the band",
        "sampling the distance",
        "integrating the volume",
        "computing the density",
        "computing the density",
        "computing the density",
        "comparing the signs",
    ];
    cancelled_at_each_step(&steps, |watch| Ok(bake(notched(), &settings, watch)?.asset));
}

#[test]
fn searches_end_at_any_step() {
    let grid = GridChoice::Tolerance(Tolerances::of_volume(0.2));
    let density = DensitySettings { rule: Rule::Chord(4), ..DensitySettings::default() };
    // With a density the cells have one size.
    let map =
        MapSettings { support_radius: Some(0.4), grid, density: Some(density), ..MapSettings::default() };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    let one_try = ["finding the band", "sampling the distance", "integrating the volume"];
    let before = ["examining the mesh", "building the tree", "measuring the exact volume"];
    let found = bake(notched(), &settings, &Watch::default()).unwrap().summary.tolerance.unwrap();
    let steps = [&before[..], &one_try.repeat(found.tried.len()), &["computing the density"; 3]].concat();
    cancelled_at_each_step(&steps, |watch| Ok(bake(notched(), &settings, watch)?.asset));
}

#[test]
fn adaptive_bakes_end_at_any_step() {
    let grid = GridChoice::Tolerance(Tolerances::of_volume(0.2));
    let map = MapSettings { support_radius: Some(0.4), grid, ..MapSettings::default() };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    let before = ["examining the mesh", "building the tree", "measuring the exact volume"];
    let round = ["sampling the distance", "integrating the volume", "measuring the exact volume"];
    cancelled_at_each_step(&[&before[..], &round].concat(), |watch| {
        Ok(bake(notched(), &settings, watch)?.asset)
    });
}

#[test]
fn bakes_in_the_plane_end_at_any_step() {
    let settings = AreaSettings {
        support_radius: Some(0.1),
        density: Some(AreaDensity::default()),
        ..AreaSettings::default()
    };
    let phi = |x: DVec2| x.length() - 0.3;
    let steps = [
        "finding the band",
        "sampling the distance",
        "finding the band",
        "sampling the distance",
        "integrating the volume",
        "computing the density",
    ];
    cancelled_at_each_step(&steps, |watch| {
        area_map::bake([DVec2::splat(-0.3), DVec2::splat(0.3)], &phi, &settings, watch)
    });
}

fn sphere() -> (Extent, MapSettings) {
    let settings =
        MapSettings { support_radius: Some(0.1), grid: GridChoice::CellSize(0.05), ..MapSettings::default() };
    (Extent { min: DVec3::splat(-0.5), max: DVec3::splat(0.5), area: 3.2 }, settings)
}

#[test]
fn surfaces_end_at_any_step() {
    let (extent, settings) = sphere();
    let phi = |x: DVec3| x.length() - 0.5;
    let map = VolumeMap::from_asset(&bake_distance(&phi, &extent, &settings, &Watch::default()).unwrap());
    let map = map.unwrap();
    cancelled_at_each_step(&["marching through the cells"], |watch| iso_surface(&map, 0.0, None, watch));
}

/// In the middle of a step: of the many distances that the whole bake asks for, few are asked for afterwards.
#[test]
fn a_step_ends_in_its_middle() {
    let (extent, settings) = sphere();
    let asked = AtomicU64::new(0);
    let watch = Watch::default();
    let whole = |x: DVec3| {
        asked.fetch_add(1, Ordering::Relaxed);
        x.length() - 0.5
    };
    bake_distance(&whole, &extent, &settings, &watch).unwrap();
    let all = asked.swap(0, Ordering::Relaxed);
    for part in [4, 2] {
        let watch = Watch::default();
        let phi = |x: DVec3| {
            if asked.fetch_add(1, Ordering::Relaxed) == all / part {
                watch.cancel().cancel();
            }
            x.length() - 0.5
        };
        let error = bake_distance(&phi, &extent, &settings, &watch).unwrap_err();
        assert!(error.is_cancelled(), "{error}");
        let afterwards = asked.swap(0, Ordering::Relaxed) - all / part;
        // A row of nodes on each thread.
        assert!(afterwards < all / 5, "{afterwards} of {all}");
    }
}
