//! Makes the sample meshes: `volmap-make-data [folder]`, by default into the folder of its own source.

use std::path::PathBuf;
use std::process::ExitCode;

use volmap_data::{obj, samples, topology::Topology};

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    if arguments.next().is_some() || folder.as_os_str().to_string_lossy().starts_with('-') {
        eprintln!("usage: volmap-make-data [folder]");
        return ExitCode::from(2);
    }
    match write_all(&folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn write_all(folder: &std::path::Path) -> Result<(), String> {
    for sample in samples() {
        let path = folder.join(sample.file);
        let text = obj::to_text(&sample.mesh, sample.title);
        std::fs::write(&path, &text).map_err(|e| format!("cannot write {}: {e}", path.display()))?;

        let (low, high) = sample.mesh.bounds();
        println!("{}: {} bytes", path.display(), text.len());
        println!("  {} vertices, {} triangles", sample.mesh.vertices.len(), sample.mesh.triangles.len());
        println!("  box {low} to {high} m, volume {:.4} m^3", sample.mesh.volume());
        println!("  {:?}", Topology::of(&sample.mesh));
    }
    Ok(())
}
