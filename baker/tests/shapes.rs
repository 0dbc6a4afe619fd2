//! Shapes instead of meshes: `volmap bake --shape`, batches, reports; and what is said when no memory is left.

use assert_cmd::Command;
use std::path::Path;

fn volmap(folder: &Path, line: &str) -> Command {
    let mut command = Command::cargo_bin("volmap").unwrap();
    command.current_dir(folder).args(line.split_whitespace());
    command
}

fn stdout(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
}

fn refusal(command: &mut Command, code: i32) -> String {
    String::from_utf8(command.assert().code(code).get_output().stderr.clone()).unwrap()
}

#[test]
fn shapes_are_baked_asked_and_measured() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let told = stdout(&mut volmap(at, "bake --shape sphere:0.5 --support-radius 0.2"));
    assert!(told.contains("shape      sphere:0.5") && told.contains("volume 0.5236 m^3"), "{told}");
    assert!(told.contains("closed form: exact") && told.contains("asset      sphere.h5"), "{told}");
    let info = stdout(&mut volmap(at, "info sphere.h5"));
    assert!(info.contains("sphere:0.5"), "{info}");
    std::fs::write(at.join("p.csv"), "x,y,z\n0.7,0,0\n0,0,-0.45\n").unwrap();
    let values = stdout(&mut volmap(at, "query sphere.h5 --points p.csv"));
    let distance = |line: &str| line.split(',').nth(3).unwrap().parse::<f64>().unwrap();
    let distances: Vec<f64> = values.lines().skip(1).map(distance).collect();
    assert!((distances[0] - 0.2).abs() < 2e-3 && (distances[1] + 0.05).abs() < 2e-3, "{values}");
    let report = stdout(&mut volmap(at, "report sphere.h5 --json - --quiet"));
    assert!(report.contains("closed form of the shape"));
}

#[test]
fn shapes_that_there_are_not_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (line, code, said) in [
        ("bake --shape sphere:-1", 2, "a sphere with a radius of -1 m"),
        ("bake --shape cone:1,2", 2, "`cone:1,2` is no shape"),
        ("bake", 2, "required arguments were not provided"),
        ("bake duck.obj --shape sphere:1", 2, "cannot be used with"),
        ("bake --shape sphere:1 --scale 1,2,1", 1, "scaled alike along all axes"),
        ("bake --shape plane:0,1,0", 1, "--domain"),
    ] {
        let error = refusal(&mut volmap(at, line), code);
        assert!(error.contains(said), "{line}: {error}");
    }
    assert_eq!(std::fs::read_dir(at).unwrap().count(), 0);
}

#[test]
fn batches_have_shapes_beside_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let manifest = "version = 1\n[defaults]\nbake = { support_radius = 0.2 }\n\
        [[assets]]\nname = \"props/ball\"\nbake = { shape = { sphere = { radius = 0.5 } } }\n\
        [[assets]]\nbake = { shape = \"box:1,1,1\" }\nmaps = [{ name = \"coarse\", bake = { cell_size = 0.2 } }, \
        { name = \"fine\" }]\n";
    std::fs::write(at.join("m.toml"), manifest).unwrap();
    volmap(at, "batch m.toml --out baked").assert().success();
    for name in ["props/ball.h5", "box.coarse.h5", "box.fine.h5"] {
        assert!(at.join("baked").join(name).is_file(), "{name}");
    }
    volmap(at, "verify baked").assert().success();
    let before = std::fs::read(at.join("baked/props/ball.h5")).unwrap();
    std::fs::write(at.join("m.toml"), manifest.replace("0.5", "0.6")).unwrap();
    volmap(at, "verify baked").assert().code(1);
    volmap(at, "batch m.toml --out baked").assert().success();
    assert!(std::fs::read(at.join("baked/props/ball.h5")).unwrap() != before);
    for (wrong, said) in [
        (manifest.replace("name = \"props", "mesh = \"a.obj\"\nname = \"props"), "goes without `mesh`"),
        (manifest.replace("{ sphere = { radius = 0.5 } }", "\"sphere:0\""), "a sphere with a radius of 0 m"),
        ("version = 1\n[[assets]]\nname = \"a\"\n".to_owned(), "a shape by `bake.shape`"),
    ] {
        std::fs::write(at.join("m.toml"), wrong).unwrap();
        let error = refusal(&mut volmap(at, "batch m.toml --out baked"), 2);
        assert!(error.contains(said), "{error}");
    }
}

/// The program under a limit of its address space, in kB.
#[cfg(target_os = "linux")]
fn limited(folder: &Path, limit: u32, line: &str) -> Command {
    let program = assert_cmd::cargo::cargo_bin("volmap");
    let mut command = Command::new("sh");
    let script = format!("ulimit -v {limit}; exec \"$0\" {line}");
    command.current_dir(folder).args(["-c", &script]).arg(program);
    command
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_runs_out_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = "bake --shape sphere:1 --support-radius 0.3 --resolution 160 --threads 1";
    let error = refusal(&mut limited(at, 200_000, line), 3);
    assert!(error.contains("no memory left") && error.contains("--cell-size"), "{error}");
    let threads = refusal(&mut limited(at, 150_000, &line.replace("--threads 1", "--threads 200")), 3);
    assert!(threads.contains("the system refuses 200 threads"), "{threads}");
    assert_eq!(std::fs::read_dir(at).unwrap().count(), 0);
}
