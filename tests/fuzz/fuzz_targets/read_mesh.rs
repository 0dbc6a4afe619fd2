//! Every mesh reader; the first byte chooses it. A mesh that comes out must be sound.
#![no_main]

use libfuzzer_sys::fuzz_target;
use volmap_formats::mesh::{CleanSettings, MeshError, MeshFormat, clean, read_mesh_bytes};

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let format = MeshFormat::ALL[usize::from(*first) % MeshFormat::ALL.len()];
    match read_mesh_bytes(bytes, format).and_then(|raw| clean(raw, &CleanSettings::default())) {
        Ok((mesh, _)) => {
            let count = mesh.vertices.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|&v| v < count));
            assert!(mesh.vertices.iter().flatten().all(|c| c.is_finite()));
        }
        // A dependency's panic, contained.
        Err(MeshError::Panicked { message, .. }) => panic!("{message}"),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
