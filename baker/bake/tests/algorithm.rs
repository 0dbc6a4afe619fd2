//! The version of the algorithm stands for its values: whoever changes these raises it, so that batches bake anew.

use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::content_key::ALGORITHM_VERSION;
use volmap_bake::density_map::DensitySettings;
use volmap_bake::input::{InputSettings, from_bytes};
use volmap_bake::plan::MapSettings;
use volmap_bake::watch::Watch;

/// Version, and BLAKE3 of the values to a hundred-thousandth of their unit.
const PINNED: (u32, &str) = (2, "d717f08187a98c5d1b22eb098713290595baca76ec5c6c580dc9454c77b8fb34");

#[test]
fn values_are_those_of_the_version() {
    let mesh = include_bytes!("data/notched.obj");
    let input = from_bytes("notched.obj".as_ref(), &mesh[..], &InputSettings::default()).unwrap();
    let map = MapSettings {
        support_radius: Some(0.25),
        density: Some(DensitySettings::default()),
        ..MapSettings::default()
    };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    let asset = bake(input, &settings, &Watch::default()).unwrap().asset;
    let density = asset.density.as_ref().unwrap();
    let fields = [
        (asset.signed_distance.to_f64(), asset.support_radius),
        (asset.volume.to_f64(), asset.quadrature.ball_volume),
        (density.values.to_f64(), 1.0),
    ];
    let mut hasher = blake3::Hasher::new();
    for (values, unit) in fields {
        values.iter().for_each(|x| _ = hasher.update(&((1e5 * x / unit).round() as i32).to_le_bytes()));
    }
    let found = hasher.finalize().to_hex().to_string();
    assert_eq!(
        (ALGORITHM_VERSION, &*found),
        PINNED,
        "bakes give other values than before: raise content_key::ALGORITHM_VERSION, and pin both here"
    );
}
