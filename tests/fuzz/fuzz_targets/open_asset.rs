//! Bytes to a map to samples. The mutator makes the HDF5 checksums right again half of the time.
#![no_main]

#[allow(dead_code)]
#[path = "../../hostile_assets/checksums.rs"]
mod checksums;

use checksums::Checksums;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use volmap_runtime::{DVec3, VolumeMap};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = VolumeMap::from_bytes(bytes.to_vec()) {
        let (low, high) = (map.grid().origin, map.grid().max_corner());
        for k in 0..64 {
            let t = DVec3::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)) / 3.0;
            std::hint::black_box(map.sample(low + (high - low) * t));
        }
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let checksums = (seed % 2 == 0).then(|| Checksums::find(&data[..size]));
    let size = fuzzer_mutate(data, size, max_size);
    if let Some(checksums) = checksums {
        checksums.renew(&mut data[..size]);
    }
    size
});
