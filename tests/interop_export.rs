//! Interop, exports: VTK, trimesh, meshio and a numpy reader of Discregrid's maps find what our queries find.

use std::path::Path;
use volmap_tests::python;

use crate::interop_asset::{bake, run, volmap};

#[test]
fn other_programs_find_the_same_map() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/check_exports.py");
    for (mesh, options) in [
        ("duck.obj", "--resolution 20 --support-radius 0.1 --precision f64"),
        ("tank.obj", "--invert --cell-size 0.13 --support-radius 0.2 --precision f64"),
        ("duck.obj", "--resolution 18,12,15 --support-radius 0.1 --thickness 0.02"),
        ("duck.obj", "--resolution 20 --support-radius 0.1 --max-rounding 0.01%"),
    ] {
        let asset = bake(folder.path(), mesh, options);
        let mut command = std::process::Command::new(python());
        print!("{}", run(command.arg(&script).arg(&asset).arg("--against").arg(volmap())));
    }
}
