//! Interop, assets: a Python reader written from `SPEC.md` alone, h5dump, and both compressions.

use std::path::{Path, PathBuf};
use std::process::Command;
use volmap_formats::asset::{self, Asset, Compression};
use volmap_tests::python;

use crate::analytic_maps::{adaptive_ball, in_steps, single};

/// The program, beside the folder of the tests; `cargo build --release` makes it.
pub fn volmap() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let program = tests.parent().and_then(Path::parent).unwrap().join("volmap");
    assert!(program.exists(), "{} is missing: cargo build --release", program.display());
    program
}

pub fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{text}\n{errors}");
    text
}

pub fn bake(folder: &Path, mesh: &str, options: &str) -> PathBuf {
    let target = folder.join(format!("{}.h5", options.replace([' ', '.', '%'], "_")));
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data").join(mesh);
    let mut command = Command::new(volmap());
    run(command.arg("bake").arg(data).arg("-o").arg(&target).arg("-q").args(options.split_whitespace()));
    target
}

const BAKES: [(&str, &str); 9] = [
    ("duck.obj", "--resolution 20 --support-radius 0.1"),
    ("duck.obj", "--resolution 20,15,25 --support-radius 0.1 --precision f64"),
    ("tank.obj", "--invert --cell-size 0.2 --support-radius 0.2 --compression zstd"),
    ("grid.obj", "--cell-size 0.02 --support-radius 0.02 --compression zstd --precision f64"),
    ("duck.obj", "--resolution 20 --support-radius 0.1 --max-rounding 0.01%"),
    ("duck.obj", "--invert --resolution 14 --compression zstd --max-rounding 1e-3"),
    ("duck.obj", "--resolution 20 --support-radius 0.1 --density --kernel wendland"),
    ("tank.obj", "--invert --cell-size 0.2 --support-radius 0.2 --density --max-rounding 0.1%"),
    ("bad_holes.obj", "--resolution 12 --domain -0.5,-0.5,-0.5,0.5,0.4,0.3"),
];

#[test]
fn reader_written_from_the_specification_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/compare_reader.py");
    for (mesh, options) in BAKES {
        let asset = bake(folder.path(), mesh, options);
        print!("{}", run(Command::new(python()).arg(&script).arg(&asset).arg("--against").arg(volmap())));
    }
}

/// Of several levels, against a flat wall and without, in each precision.
#[test]
fn reader_written_from_the_specification_agrees_on_adaptive_maps() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/compare_reader.py");
    let double = adaptive_ball(4);
    let plain = Asset { plane_weight: None, ..adaptive_ball(3) };
    let all = [
        ("double", double),
        ("single", single(&adaptive_ball(3))),
        ("plain", plain),
        ("steps", in_steps(&adaptive_ball(2))),
    ];
    for (name, adaptive) in all {
        let path = folder.path().join(name).with_extension("h5");
        asset::write(&path, &adaptive, Compression::default()).unwrap();
        print!("{}", run(Command::new(python()).arg(&script).arg(&path).arg("--against").arg(volmap())));
    }
}

/// An L with a hole, in two dimensions.
const OUTLINE: &str = "v 0 0 0\nv 1 0 0\nv 1 0.4 0\nv 0.4 0.4 0\nv 0.4 1 0\nv 0 1 0\nv 0.1 0.1 0\nv 0.2 0.1 0\nv \
    0.2 0.2 0\n\
                       l 1 2 3 4 5 6 1\nl 7 8 9 7\n";

#[test]
fn reader_written_from_the_specification_agrees_in_two_dimensions() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/compare_reader.py");
    let outline = folder.path().join("outline.obj");
    std::fs::write(&outline, OUTLINE).unwrap();
    for (name, options) in [
        ("plain", "--cell-size 0.05 --support-radius 0.1 --precision f64"),
        ("density", "--resolution 30,20 --support-radius 0.1 --invert --density --compression zstd"),
        ("rounded", "--support-radius 0.05 --max-rounding 0.02% --density"),
    ] {
        let asset = folder.path().join(name).with_extension("h5");
        let mut bake = Command::new(volmap());
        bake.arg("bake-outline").arg(&outline).arg("-o").arg(&asset).arg("-q");
        run(bake.args(options.split_whitespace()));
        print!("{}", run(Command::new(python()).arg(&script).arg(&asset).arg("--against").arg(volmap())));
    }
}

#[test]
fn rounded_fields_keep_the_bound_as_python_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/compare_reader.py");
    for bound in ["0.02%", "1%"] {
        let options = "--resolution 20 --support-radius 0.1";
        let exact = bake(folder.path(), "duck.obj", &format!("{options} --precision f64"));
        let rounded = bake(folder.path(), "duck.obj", &format!("{options} --max-rounding {bound}"));
        let mut command = Command::new(python());
        command.arg(&script).arg(&rounded).arg("--exact").arg(&exact).arg("--against").arg(volmap());
        print!("{}", run(&mut command));
    }
}

/// The table of SPEC.md, section 13, by the programs that are here.
#[test]
fn the_table_of_readers_is_true() {
    let folder = tempfile::tempdir().unwrap();
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    let [gzip, zstd] = ["gzip", "zstd"]
        .map(|name| bake(folder.path(), "duck.obj", &format!("--resolution 30 --compression {name}")));
    let mut command = Command::new(python());
    command.arg(tests.join("interop/check_readers.py")).args([gzip, zstd]);
    print!("{}", run(command.arg(tests.join("../formats/SPEC.md"))));
}

#[test]
fn h5dump_reads_every_dataset() {
    let folder = tempfile::tempdir().unwrap();
    let asset = bake(folder.path(), "tank.obj", "--resolution 8");
    let text = run(Command::new("h5dump").arg(&asset));
    for part in
        ["DATASET \"signed_distance\"", "H5T_IEEE_F32LE", "DATASET \"band\"", "\"format\"", "\"volmap\""]
    {
        assert!(text.contains(part), "h5dump doesn't show {part}");
    }
}
