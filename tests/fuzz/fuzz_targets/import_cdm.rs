//! Bytes to a map of SPlisHSPlasH to an asset to samples.
#![no_main]

use libfuzzer_sys::fuzz_target;
use volmap_formats::asset::Exterior;
use volmap_formats::export::cdm;
use volmap_report::import::{ImportSettings, from_grid};
use volmap_runtime::{DVec3, VolumeMap};

fuzz_target!(|bytes: &[u8]| {
    let Ok(grid) = cdm::from_bytes(bytes) else { return };
    for exterior in [None, Some(Exterior::Solid)] {
        let settings = ImportSettings { support_radius: 0.1, exterior };
        let Ok(import) = from_grid(&grid, &settings) else { continue };
        if let Ok(map) = VolumeMap::from_asset(&import.asset) {
            let (low, high) = (map.grid().origin, map.grid().max_corner());
            for k in 0..64 {
                let t = DVec3::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)) / 3.0;
                std::hint::black_box(map.sample(low + (high - low) * t));
            }
        }
    }
});
