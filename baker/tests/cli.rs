//! The program as a user calls it.

use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};
use std::time::Duration;
use tempfile::TempDir;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data").join(name)
}

fn volmap(folder: &TempDir) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_volmap"));
    command.current_dir(folder.path()).timeout(Duration::from_secs(120));
    command
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn names(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Standard output of a command that must succeed.
fn output(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
}

/// Standard error of a command that must fail with code 1.
fn error(command: &mut Command) -> String {
    let text = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
    assert!(text.contains("error: ") && !text.contains("panicked"), "{text}");
    text
}

#[test]
fn bake_info_query() {
    let folder = folder();
    let summary = output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(["--resolution", "20"]));
    for part in
        ["19,136 triangles", "closed", "of 8,000 kept", "dense", "sparse", "time ", "duck.h5", "volmap info"]
    {
        assert!(summary.contains(part), "no `{part}` in\n{summary}");
    }
    assert_eq!(names(&folder), ["duck.h5"]);
    // What `bake` printed of mesh and grid is what `info` says; the rest stands behind --all.
    let text = output(volmap(&folder).args(["info", "duck.h5"]));
    let lines = summary.lines().filter(|line| {
        !["memory", "time", "asset", "next", "plan"].iter().any(|name| line.starts_with(name))
    });
    for line in lines.filter(|line| !line.contains("volmap query")) {
        assert!(text.contains(line), "no `{line}` in\n{text}");
    }
    assert!(text.lines().count() < 12 && !text.contains("support_radius"), "{text}");
    let text = output(volmap(&folder).args(["info", "duck.h5", "--all"]));
    assert!(text.contains("support_radius") && text.contains("duck.obj"), "{text}");
    assert!(text.contains("`volmap export` writes .vtkhdf and .vti for ParaView, VTK, pyvista"), "{text}");
    let json: serde_json::Value =
        serde_json::from_str(&output(volmap(&folder).args(["info", "duck.h5", "--json"]))).unwrap();
    assert_eq!(json["support_radius"], 0.1);
    assert_eq!(json["grid"]["resolution"], serde_json::json!([20, 20, 20]));
    assert_eq!(json["quadrature"]["points"], 320);
    assert_eq!(json["source"]["triangles"], 19136);
    assert_eq!(json["diagnosis"]["closed"], 1);

    fs::write(folder.path().join("p.csv"), "id,x,y,z\na,0.62,0,0\nb,0,0,0\nc,9,9,9\n").unwrap();
    let table = output(volmap(&folder).args(["query", "duck.h5", "--points", "p.csv"]));
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "id,x,y,z,distance,nx,ny,nz,cx,cy,cz,volume,region");
    assert!(lines[1].starts_with("a,0.62,0,0,0.1") && lines[1].ends_with("band"), "{table}");
    assert_eq!(lines[3], "c,9,9,9,,,,,,,,0,outside");
    let rows: serde_json::Value = serde_json::from_str(&output(
        volmap(&folder)
            .args(["query", "duck.h5", "--points", "-", "--json"])
            .write_stdin("x,y,z\n0.62,0,0\n"),
    ))
    .unwrap();
    let distance = lines[1].split(',').nth(4).unwrap().parse::<f64>().unwrap();
    assert_eq!(rows[0]["distance"], distance);
    let empty =
        output(volmap(&folder).args(["query", "duck.h5", "--points", "-", "--json"]).write_stdin("x,y,z\n"));
    assert_eq!(empty, "[\n]\n");
}

#[test]
fn bytes_depend_on_input_and_parameters_alone() {
    let folder = folder();
    let mut first: Option<Vec<u8>> = None;
    for threads in ["1", "2", "5", "1"] {
        let options =
            ["--resolution", "17", "--support-radius", "0.12", "-o", "a.h5", "-q", "--threads", threads];
        output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(options));
        let bytes = fs::read(folder.path().join("a.h5")).unwrap();
        assert!(first.get_or_insert_with(|| bytes.clone()) == &bytes, "{threads} threads");
    }
    // In another folder, at another time, as JSON or with the checks: the same asset.
    let other = tempfile::tempdir().unwrap();
    let options = ["--resolution", "17", "--support-radius", "0.12", "-o", "b.h5", "--json"];
    output(volmap(&other).arg("bake").arg(data("duck.obj")).args(options));
    assert!(first.unwrap() == fs::read(other.path().join("b.h5")).unwrap());
}

#[test]
fn options_reach_the_asset() {
    let folder = folder();
    let options = "--particle-radius 0.05 --cell-size 0.1 --padding 0.05 --thickness 0.01 --invert --quadrature ball6 \
                   --precision f64 --compression gzip --unit cm --scale 100 --translate 1,2,-3 --rotate 0,1,0,90 \
                   --up y --sign winding --check-sign --json -o t.h5";
    let text = output(volmap(&folder).arg("bake").arg(data("tank.obj")).args(options.split_whitespace()));
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let bake = &json["bake"];
    assert_eq!(json["support_radius"], 0.2);
    assert_eq!(json["exterior"], "solid");
    assert_eq!(json["grid"]["cell_size"], serde_json::json!([0.1, 0.1, 0.1]));
    assert_eq!(json["fields"]["volume"]["precision"], "f64");
    assert_eq!((&bake["quadrature"], &bake["thickness"]), (&"ball6".into(), &0.01.into()));
    assert_eq!((&bake["unit"], &bake["invert"]), (&0.01.into(), &1.into()));
    assert_eq!(json["diagnosis"]["sign_disagreements"], 0);
    let min: Vec<f64> = serde_json::from_value(json["source"]["bounds_min"].clone()).unwrap();
    for (got, expected) in min.iter().zip([1.0 - 1.55, 2.0, -3.0 - 1.55]) {
        assert!((got - expected).abs() < 1e-12, "{min:?}");
    }
    // The tank's floor at y = 2 is 0.01 higher; the fluid is inside.
    let table = output(
        volmap(&folder).args(["query", "t.h5", "--points", "-"]).write_stdin("x,y,z\n1.03,2.09,-3.04\n"),
    );
    let distance: f64 = table.lines().nth(1).unwrap().split(',').nth(3).unwrap().parse().unwrap();
    assert!((distance - 0.08).abs() < 1e-9, "{table}");
}

#[test]
fn rounding_is_bounded_halves_the_asset_and_is_said() {
    let folder = folder();
    let bake = |options: &[&str]| {
        output(
            volmap(&folder)
                .arg("bake")
                .arg(data("duck.obj"))
                .args(["--resolution", "16", "--json"])
                .args(options),
        )
    };
    let json = |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap();
    let single = json(bake(&["-o", "single.h5"]));
    let rounded = json(bake(&["-o", "rounded.h5", "--max-rounding", "0.02%"]));
    let fields = &rounded["fields"];
    assert_eq!(
        (&fields["volume"]["precision"], &rounded["bake"]["precision"]),
        (&"i16".into(), &"i16".into())
    );
    let radius = rounded["support_radius"].as_f64().unwrap();
    assert_eq!(fields["signed_distance"]["max_error"], 2e-4 * radius);
    assert_eq!(rounded["bake"]["max_rounding"], 2e-4);
    assert!(rounded["file_bytes"].as_u64() < single["file_bytes"].as_u64().map(|bytes| bytes * 2 / 3));
    let refused = |options: &[&str]| {
        let mut command = volmap(&folder);
        let output = command.arg("bake").arg(data("duck.obj")).args(options).output().unwrap();
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let error = refused(&["--max-rounding", "0.001%"]);
    let (_, smallest) = error.split_once("at least ").unwrap();
    let smallest: f64 = smallest.split(' ').next().unwrap().parse().unwrap();
    output(
        volmap(&folder).arg("bake").arg(data("duck.obj")).args(["--max-rounding", &format!("{smallest}%")]),
    );
    assert!(refused(&["--max-rounding", "0.1%", "--precision", "f64"]).contains("cannot be used with"));
}

#[test]
fn a_domain_that_cuts_is_said() {
    let folder = folder();
    let options = ["--support-radius", "0.1", "--cell-size", "0.1", "--domain", "-0.5,-0.5,-0.5,0.5,0.5,0.5"];
    let text = output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(options));
    assert!(text.contains("the domain cuts the band"), "{text}");
    let whole = output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(&options[..4]));
    assert!(!whole.contains("the domain"), "{whole}");
}

#[test]
fn a_bad_mesh_is_told_as_such() {
    let folder = folder();
    let text = output(volmap(&folder).arg("bake").arg(data("bad_holes.obj")).args([
        "--resolution",
        "16",
        "--check-sign",
    ]));
    for part in ["NOT closed", "rim", "1 duplicate face dropped", "more than two faces", "flipped"] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}

#[test]
fn errors_name_file_place_and_cure() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("good.h5"), b"precious").unwrap();
    fs::write(at("nan.obj"), "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(at("index.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    fs::write(at("empty.stl"), "").unwrap();
    fs::write(at("what.xyz"), "hello").unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["bake", "missing.obj"], &["missing.obj", "No such file"]),
        (&["bake", "nan.obj", "-o", "good.h5"], &["nan.obj", "2"]),
        (&["bake", "index.obj", "-o", "good.h5"], &["index.obj", "9"]),
        (&["bake", "empty.stl", "-o", "good.h5"], &["empty.stl"]),
        (&["bake", "what.xyz", "-o", "good.h5"], &["what.xyz"]),
        (&["info", "missing.h5"], &["missing.h5"]),
        (&["info", "good.h5"], &["good.h5", "HDF5"]),
        (&["query", "good.h5", "--points", "nan.obj"], &["good.h5"]),
    ];
    for (arguments, parts) in cases {
        let text = error(volmap(&folder).args(*arguments));
        parts.iter().for_each(|part| assert!(text.contains(part), "no `{part}` in {text}"));
    }
    assert_eq!(fs::read(at("good.h5")).unwrap(), b"precious");
    assert_eq!(names(&folder), ["empty.stl", "good.h5", "index.obj", "nan.obj", "what.xyz"]);
}

#[test]
fn settings_that_cannot_work_are_refused_before_work() {
    let folder = folder();
    let cases: &[(&[&str], &str)] = &[
        (&["--support-radius", "0"], "--support-radius"),
        (&["--support-radius", "-1"], "--support-radius"),
        (&["--support-radius", "nan"], "--support-radius"),
        (&["--support-radius", "1e-7"], "larger"),
        (&["--resolution", "0"], "--resolution"),
        (&["--cell-size", "1e-300"], "--cell-size"),
        (&["--resolution", "1000", "--max-memory", "100MB"], "--max-memory"),
        (&["--domain", "1,1,1,0,0,0"], "--domain"),
        (&["--domain", "50,50,50,51,51,51"], "--domain"),
        (&["--padding", "-1"], "--padding"),
        (&["--thickness", "-10", "--resolution", "9"], "--thickness"),
        (&["--thickness", "3", "--support-radius", "0.01", "--max-memory", "1GB"], "--max-memory"),
        (
            &["--domain", "0,0,0,1e-3,1e-3,1e-3", "--resolution", "10", "--support-radius", "1e6"],
            "cuts the band",
        ),
        (
            &["-o", "missing/folder/a.h5"],
            "missing/folder/a.h5: there is no folder missing/folder; make it first",
        ),
        (&["--support-radius", "1e-20", "--resolution", "4"], "--unit"),
        (&["--scale", "1e50"], "1e-9 to 1e9 m"),
        (&["--resolution", "4", "--padding", "1e200"], "--padding"),
        (&["--resolution", "4", "--thickness", "1e200"], "--thickness"),
        (&["--resolution", "4", "--translate", "1e13,0,0"], "--translate"),
        (&["-o", "."], "folder"),
    ];
    for (arguments, part) in cases {
        let text = error(volmap(&folder).arg("bake").arg(data("tank.obj")).args(*arguments));
        assert!(text.contains(part), "{arguments:?}: no `{part}` in {text}");
    }
    for usage in [
        &["--quadrature", "simpson"][..],
        &["--resolution", "1,2"],
        &["--no-such-option"],
        &["--unit", "league"],
    ] {
        volmap(&folder).arg("bake").arg(data("tank.obj")).args(usage).assert().code(2);
    }
    fs::copy(data("tank.obj"), folder.path().join("t.obj")).unwrap();
    let text = error(volmap(&folder).args(["bake", "t.obj", "-o", "t.obj"]));
    assert!(text.contains("overwrite"), "{text}");
    assert_eq!(names(&folder), ["t.obj"]);
}

/// Whatever is not a file stays as it is: renamed over a device, the asset would take its place.
#[cfg(unix)]
#[test]
fn only_files_are_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = folder();
    let socket = folder.path().join("a.h5");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let text =
        error(volmap(&folder).arg("bake").arg(data("tank.obj")).args(["--resolution", "4", "-o", "a.h5"]));
    assert!(text.contains("a.h5: is a device or a pipe"), "{text}");
    assert!(fs::symlink_metadata(&socket).unwrap().file_type().is_socket());
}

/// Lengths of small objects don't read as 0.
#[test]
fn small_objects_have_digits() {
    let folder = folder();
    let options = ["--scale", "1e-5", "--resolution", "4"];
    let text = output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(options));
    assert!(!text.contains("0.0000 m") && text.contains("box"), "{text}");
}

#[test]
fn bad_points_name_line_and_column() {
    let folder = folder();
    output(volmap(&folder).arg("bake").arg(data("tank.obj")).args(["--resolution", "4", "-q", "-o", "t.h5"]));
    let cases = [
        ("a,b\n1,2\n", "column `x`"),
        ("x,y,z\n1,2,3\n1,two,3\n", "line 3: y is `two`"),
        ("x,y,z\n1,2,inf\n", "line 2: z is `inf`"),
        ("x,y,z\n1,2\n", "line: 2"),
        ("", "column `x`"),
        ("x;y;z\n0,5;0,5;1,05\n", "`x;y;z`: it is parted by semicolons; write commas"),
        ("x\ty\tz\n1\t2\t3\n", "it is parted by tabs; write commas"),
        (
            "0.5,0.5,1.05\n1,2,3\n",
            "the numbers `0.5,0.5,1.05`; the first line must name the columns: add `x,y,z`",
        ),
        ("Points:0,Points:1,Points:2\n1,2,3\n", "the columns are `Points:0,Points:1,Points:2`: call those"),
        ("x,y,z,X\n1,2,3,4\n", "2 columns are called `x`"),
        ("\u{feff}x,y,w\n1,2,3\n", "no column `z`"),
    ];
    for (points, part) in cases {
        for format in [&[][..], &["--json"]] {
            let mut query = volmap(&folder);
            query.args(["query", "t.h5", "--points", "-"]).args(format).write_stdin(points);
            let text = error(&mut query);
            assert!(text.contains(part), "no `{part}` in {text}");
            assert!(query.output().unwrap().stdout.is_empty(), "a part of the answers");
        }
    }
}

#[test]
fn points_that_are_not_utf_8_say_so() {
    let folder = folder();
    output(volmap(&folder).arg("bake").arg(data("tank.obj")).args(["--resolution", "4", "-q", "-o", "t.h5"]));
    let utf_16: Vec<u8> =
        [0xFF, 0xFE].into_iter().chain("x,y,z\n1,2,3\n".encode_utf16().flat_map(u16::to_le_bytes)).collect();
    for (bytes, part) in [
        (utf_16.clone(), "UTF-16 text or no text at all: save the table as UTF-8"),
        (utf_16[2..].to_vec(), "UTF-16"),
        (b"name,x,y,z\na,1,2,3\nd\xe9,1,2,3\n".to_vec(), "line 3 is not UTF-8: save the table as UTF-8"),
    ] {
        let text = error(volmap(&folder).args(["query", "t.h5", "--points", "-"]).write_stdin(bytes));
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn the_answers_of_an_answer_have_names_of_their_own() {
    let folder = folder();
    output(volmap(&folder).arg("bake").arg(data("tank.obj")).args(["--resolution", "4", "-q", "-o", "t.h5"]));
    let query = ["query", "t.h5", "--points", "-"];
    let first = output(volmap(&folder).args(query).write_stdin("x,y,z,volume_2\n0.1,0.1,0.1,7\n"));
    let result =
        volmap(&folder).args(query).write_stdin(first.clone()).assert().success().get_output().clone();
    let (second, warning) =
        (String::from_utf8(result.stdout).unwrap(), String::from_utf8(result.stderr).unwrap());
    let header: Vec<&str> = second.lines().next().unwrap().split(',').collect();
    assert_eq!(header[..13].join(","), first.lines().next().unwrap());
    assert_eq!(header[13..].join(","), "distance_2,nx_2,ny_2,nz_2,cx_2,cy_2,cz_2,volume_3,region_2");
    let row: Vec<&str> = second.lines().nth(1).unwrap().split(',').collect();
    assert_eq!((row[3], &row[4..13]), ("7", &row[13..]));
    assert!(warning.contains("warning: ") && warning.contains("volume_3"), "{warning}");
}

/// Whoever reads may have had enough, as `head` does.
#[test]
fn a_closed_pipe_ends_quietly() {
    let folder = folder();
    output(volmap(&folder).arg("bake").arg(data("tank.obj")).args(["--resolution", "4", "-q", "-o", "t.h5"]));
    let rows =
        (0..20_000).fold("x,y,z\n".to_owned(), |text, k| text + &format!("{},0,0\n", f64::from(k) / 1e4));
    fs::write(folder.path().join("p.csv"), rows).unwrap();
    for arguments in [
        "query t.h5 --points p.csv",
        "query t.h5 --points p.csv --json",
        "completions bash",
        "man",
        "info t.h5",
    ] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_volmap"))
            .current_dir(folder.path())
            .args(arguments.split(' '))
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let result = child.wait_with_output().unwrap();
        let text = String::from_utf8(result.stderr).unwrap();
        assert!(result.status.success() && text.is_empty(), "{arguments}: {text}");
    }
}

/// Rows of equal values are compressed over a thousandfold; a map of them must still open.
#[test]
fn a_long_slab_opens() {
    let folder = folder();
    let slab = ["4000 0 0", "0 0 0", "0 2 0", "4000 2 0", "4000 0 20", "0 0 20", "0 2 20", "4000 2 20"];
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 4 3 7 8\nf 2 6 7 3\nf 1 4 8 5\n";
    let text: String = slab.iter().map(|point| format!("v {point}\n")).chain([faces.to_owned()]).collect();
    fs::write(folder.path().join("slab.obj"), text).unwrap();
    let options = ["--support-radius", "1", "--cell-size", "1", "--quadrature", "ball1"];
    let text = output(volmap(&folder).args(["bake", "slab.obj"]).args(options));
    assert!(text.contains("closed, oriented"), "{text}");
    output(volmap(&folder).args(["info", "slab.h5"]));
}

/// Kills the program at many moments: the folder holds nothing, or the whole asset; an older asset stays or is
/// replaced as a whole.
#[test]
fn killing_leaves_nothing_half_done() {
    let folder = folder();
    let target = folder.path().join("a.h5");
    let bake = |cells: &str| {
        let mut process = Process::new(env!("CARGO_BIN_EXE_volmap"));
        process.current_dir(folder.path()).arg("bake").arg(data("tank.obj"));
        process.args(["--cell-size", cells, "--support-radius", "0.2", "-o", "a.h5", "-q"]);
        process.stderr(Stdio::null()).stdout(Stdio::null());
        process
    };
    let time = || {
        let start = std::time::Instant::now();
        assert!(bake("0.2").status().unwrap().success());
        start.elapsed()
    };
    // Others may slow one run down.
    let whole = time().min(time()).min(time());
    let complete = fs::read(&target).unwrap();
    assert!(bake("0.4").status().unwrap().success());
    let older = fs::read(&target).unwrap();
    let mut killed = 0;
    for moment in 0..40 {
        match moment % 2 {
            0 => _ = fs::remove_file(&target),
            _ => fs::write(&target, &older).unwrap(),
        }
        let mut process = bake("0.2").spawn().unwrap();
        std::thread::sleep(whole.mul_f64(f64::from(moment) / 30.0));
        _ = process.kill();
        killed += usize::from(!process.wait().unwrap().success());
        let left = names(&folder);
        assert!(left.iter().all(|name| name == "a.h5"), "{left:?}");
        if let Ok(found) = fs::read(&target) {
            assert!(found == complete || (moment % 2 == 1 && found == older), "a part of an asset");
        } else {
            assert_eq!(moment % 2, 0, "the older asset is gone");
        }
    }
    assert!(killed > 10, "only {killed} were killed in time");
}

/// Ctrl-C while each kind of long work runs.
#[cfg(target_os = "linux")]
#[test]
fn commands_that_are_stopped_say_so_and_leave_no_file() {
    let folder = folder();
    let duck = data("duck.obj");
    let duck = duck.display();
    output(
        volmap(&folder).args(["bake", "-q", "-o", "small.h5", "--resolution", "12"]).arg(data("duck.obj")),
    );
    let commands = [
        format!("bake {duck} -o stopped.h5 --resolution 400 --max-memory 64GiB --quadrature gl100"),
        format!("bake {duck} -o stopped.h5 --tolerance 0.1% --support-radius 0.04 --max-memory 64GiB"),
        format!("report small.h5 --mesh {duck} --points 100000 --gl100-mesh-points 5000 --output stopped"),
        "slice small.h5 --plane z=0 --pixels 4096 -o stopped.png".to_owned(),
        "export small.h5 -o stopped.ply --resolution 1500".to_owned(),
        "reproduce duck".to_owned(),
    ];
    for line in commands {
        let mut process = Process::new(env!("CARGO_BIN_EXE_volmap"));
        process.args(line.split(' ')).current_dir(folder.path());
        let mut child = process.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        while child.try_wait().unwrap().is_none() && !catches_interrupts(child.id()) {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(50));
        let interrupt = Process::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(interrupt.success(), "{line}");
        let done = child.wait_with_output().unwrap();
        let told = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(130), "{line}: {told}");
        assert!(told.contains("stopped; nothing was written"), "{line}: {told}");
        assert_eq!(names(&folder), ["small.h5"], "{line}");
    }
}

/// Whether a process has a handler for Ctrl-C (signal 2).
#[cfg(target_os = "linux")]
fn catches_interrupts(process: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(caught.trim(), 16).unwrap() >> 1 & 1 == 1
}

/// A cube of 8 m with its lowest x at the given coordinate.
fn cube_at(x: f64) -> String {
    let corner = |i: u32| format!("v {} {} {}\n", x + f64::from(8 * (i & 1)), 8 * (i >> 1 & 1), 8 * (i >> 2));
    let faces = "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 \
        8\nf 2 8 6\n";
    (0..8).map(corner).collect::<String>() + faces
}

/// As in maps of a country: nodes on the surface, and coordinates that round what lies between.
#[test]
fn far_from_the_origin_the_sides_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for x in [0.0, 5e6] {
        fs::write(folder.path().join("cube.obj"), cube_at(x)).unwrap();
        output(volmap(&folder).args(["bake", "cube.obj", "--support-radius", "1"]));
        fs::write(folder.path().join("p.csv"), format!("x,y,z\n{},4,4\n{},4,4\n", x + 0.5, x + 8.5)).unwrap();
        let table = output(volmap(&folder).args(["query", "cube.h5", "--points", "p.csv"]));
        let distances: Vec<&str> =
            table.lines().skip(1).map(|line| line.split(',').nth(3).unwrap()).collect();
        assert_eq!(distances, ["-0.5", "0.5"], "{table}");
    }
}

#[test]
fn a_tolerance_holds_with_a_cut_domain_and_with_rounding() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cube.obj"), cube_at(0.0)).unwrap();
    let bake = ["bake", "cube.obj", "--support-radius", "1", "--tolerance", "5%"];
    let cut = output(volmap(&folder).args(bake).args(["--domain", "-2,-2,-2,10,10,0.15"]));
    assert!(cut.contains("tolerance  5 % of the ball: largest error"), "{cut}");
    let rounded = output(volmap(&folder).args(bake).args(["--max-rounding", "1%"]));
    assert!(rounded.contains("tolerance  5 % of") && rounded.contains("rounding"), "{rounded}");
    let refused = volmap(&folder).args(bake).args(["--max-rounding", "5%"]).output().unwrap();
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("--max-rounding"), "{message}");
}

#[test]
fn slice_draws_a_map() {
    let folder = folder();
    let bake = ["--resolution", "12", "--support-radius", "0.15", "-o", "d.h5", "-q"];
    output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(bake));
    let mesh = data("duck.obj");
    let arguments =
        ["slice", "d.h5", "--plane", "z=0.1", "--pixels", "80", "--csv", "s.csv", "-o", "s.png", "--mesh"];
    output(volmap(&folder).args(arguments).arg(&mesh));
    let first = fs::read(folder.path().join("s.png")).unwrap();
    assert!(first.starts_with(b"\x89PNG"));
    let table = fs::read_to_string(folder.path().join("s.csv")).unwrap();
    assert!(table.starts_with("x,y,z,value,region\n") && table.contains(",outside\n"), "{table}");

    // The numbers are those of `query` at the same points.
    let answers = output(volmap(&folder).args(["query", "d.h5", "--points", "s.csv"]));
    let mut bands = 0;
    for line in answers.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[4], fields[13], "region: {line}");
        if fields[4] == "band" {
            assert_eq!(fields[3], fields[12], "volume: {line}");
            bands += 1;
        }
    }
    assert!(bands > 1000, "{bands}");

    // Every field; the mesh and curves are seen.
    let mut pictures = vec![first];
    let fields = ["volume", "distance", "normal-x", "normal-y", "normal-z", "normal-angle"];
    let others = fields.map(|field| vec!["--field", field, "--mesh", mesh.to_str().unwrap()]);
    for options in others.into_iter().chain([vec![], vec!["--contours", "1e-3,5e-3"], vec!["--pixels", "90"]])
    {
        let mut command = volmap(&folder);
        let pixels: &[&str] = if options.contains(&"--pixels") { &[] } else { &["--pixels", "80"] };
        output(command.args(["slice", "d.h5", "--plane", "z=0.1", "-o", "s.png"]).args(pixels).args(options));
        pictures.push(fs::read(folder.path().join("s.png")).unwrap());
    }
    assert_eq!(pictures[0], pictures[1], "the volume is the default");
    pictures.remove(0);
    for (number, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..number].contains(picture), "{number} looks like another");
    }
}

#[test]
fn slice_refuses_what_it_cannot_draw() {
    let folder = folder();
    let bake = ["--resolution", "8", "-o", "t.h5", "-q"];
    output(volmap(&folder).arg("bake").arg(data("tank.obj")).args(bake));
    let refused = |options: &[&str]| error(volmap(&folder).args(["slice", "t.h5"]).args(options));
    let far = refused(&["--plane", "z=99", "-o", "s.png"]);
    assert!(far.contains("--plane: z = 99 is outside the domain, where z goes from"), "{far}");
    let alone = refused(&["--plane", "z=0", "--field", "normal-angle", "-o", "s.png"]);
    assert!(alone.contains("needs --mesh"), "{alone}");
    let none = refused(&["--plane", "z=0", "--field", "density", "-o", "s.png"]);
    assert!(none.contains("bake it with --density"), "{none}");
    let nowhere = refused(&["--plane", "z=0", "-o", "no/such/s.png"]);
    assert!(nowhere.contains("there is no folder"), "{nowhere}");
    let lost = refused(&["--plane", "z=0", "-o", "s.png", "--mesh", "lost.obj"]);
    assert!(lost.contains("lost.obj"), "{lost}");
    let over = refused(&["--plane", "z=0", "-o", "s.png", "--csv", "t.h5"]);
    assert!(over.contains("would overwrite t.h5"), "{over}");
    assert_eq!(names(&folder), ["t.h5"], "nothing is left");

    for (options, reason) in [
        (vec!["--plane", "w=1", "-o", "s.png"], "z=0.2"),
        (vec!["--plane", "z=0", "-o", "s.jpg"], ".png"),
        (vec!["--plane", "z=0", "-o", "s.png", "--field", "colour"], "possible values"),
        (vec!["--plane", "z=0", "-o", "s.png", "--pixels", "5"], "16..=4096"),
        (vec!["--plane", "z=0", "-o", "s.png", "--contours", "1,x"], "finite numbers"),
        (vec!["-o", "s.png"], "--plane"),
    ] {
        let run = volmap(&folder).args(["slice", "t.h5"]).args(options).assert().code(2);
        let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert!(text.contains(reason), "{text}");
    }
    // Another mesh than the baked one is drawn, with a warning.
    let mut command = volmap(&folder);
    let run =
        command.args(["slice", "t.h5", "--plane", "y=0.5", "-o", "s.png", "--mesh"]).arg(data("duck.obj"));
    let warning = String::from_utf8(run.assert().success().get_output().stderr.clone()).unwrap();
    assert!(warning.contains("duck.obj is not the mesh that was baked (tank.obj)"), "{warning}");
}

#[test]
fn adaptive_maps_have_the_same_bytes_on_any_threads_and_go_to_other_programs_and_back() {
    let folder = folder();
    let mut first: Option<Vec<u8>> = None;
    for threads in ["1", "3"] {
        let options = ["--tolerance", "5%", "-o", "a.h5", "-q", "--threads", threads];
        output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(options));
        let bytes = fs::read(folder.path().join("a.h5")).unwrap();
        assert!(*first.get_or_insert(bytes.clone()) == bytes, "other bytes on {threads} threads");
    }
    let json: serde_json::Value =
        serde_json::from_str(&output(volmap(&folder).args(["info", "a.h5", "--json"]))).unwrap();
    assert_eq!(json["format_version"], 5);
    let levels: Vec<u64> = serde_json::from_value(json["cells"]["by_level"].clone()).unwrap();
    assert!(levels.len() > 1 && json["cells"]["band"] == levels.iter().sum::<u64>(), "{levels:?}");
    let told = output(volmap(&folder).args(["export", "a.h5", "-o", "a.cdm"]));
    assert!(told.contains("cells of several sizes became equal ones"), "{told}");
    output(volmap(&folder).args(["import", "a.cdm", "-o", "b.h5", "--support-radius", "0.1"]));
    fs::write(folder.path().join("p.csv"), "x,y,z\n0,0.7,0.2\n0.6,-0.1,0\n0,0,0.8\n").unwrap();
    let distances = ["a.h5", "b.h5"].map(|map| {
        let table = output(volmap(&folder).args(["query", map, "--points", "p.csv"]));
        table
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(3).unwrap().parse().unwrap())
            .collect::<Vec<f64>>()
    });
    for (own, back) in distances[0].iter().zip(&distances[1]) {
        assert!((own - back).abs() < 1e-4, "{distances:?}");
    }
}

#[test]
fn a_file_of_a_given_size_has_the_least_error_that_fits() {
    let folder = folder();
    let duck = data("duck.obj");
    let baked = |size: &str, limit: u64| {
        let summary =
            output(volmap(&folder).arg("bake").arg(&duck).args(["--max-bytes", size, "-o", "a.h5"]));
        let bytes = fs::metadata(folder.path().join("a.h5")).unwrap().len();
        assert!(bytes <= limit && bytes * 10 >= limit * 8, "{size}: {bytes}\n{summary}");
        assert!(summary.contains(&format!("size       {size} at most; tolerances that were tried: 1 %: ")));
        let json = output(volmap(&folder).args(["info", "a.h5", "--json"]));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["bake"]["max_bytes"], limit);
        json["bake"]["tolerance"].as_f64().unwrap()
    };
    assert!(baked("30.0 kB", 30_000) > 1.2 * baked("50.0 kB", 50_000));
    let mut bake = volmap(&folder);
    let refused = bake.arg("bake").arg(&duck).args(["--max-bytes", "1kB"]).output().unwrap();
    let told = String::from_utf8_lossy(&refused.stderr);
    assert!(
        !refused.status.success() && told.contains("--max-bytes: no map of this mesh fits into 1000 B"),
        "{told}"
    );
    assert!(told.contains("take a larger support radius"), "{told}");
}

#[test]
fn a_density_is_baked_shown_and_asked_for() {
    let folder = folder();
    let options = ["--resolution", "16", "--density", "--kernel", "wendland", "--density-quadrature", "gl20"];
    let mut first: Option<Vec<u8>> = None;
    for threads in ["1", "3"] {
        let mut bake = volmap(&folder);
        bake.arg("bake").arg(data("duck.obj")).args(options).args(["--threads", threads]);
        let summary = output(&mut bake);
        assert!(
            summary.contains("kernel wendland_c2, by gl20") && summary.contains("density 0."),
            "{summary}"
        );
        let bytes = fs::read(folder.path().join("duck.h5")).unwrap();
        assert!(*first.get_or_insert(bytes.clone()) == bytes, "other bytes on {threads} threads");
    }
    let json: serde_json::Value =
        serde_json::from_str(&output(volmap(&folder).args(["info", "duck.h5", "--json"]))).unwrap();
    assert_eq!(json["format_version"], 2);
    let density = &json["fields"]["density"];
    assert_eq!((&density["kernel"], &density["units"]), (&"wendland_c2".into(), &"1".into()));
    assert_eq!(
        (&density["quadrature"], &json["bake"]["density_quadrature"]),
        (&"gl20".into(), &"gl20".into())
    );
    assert!(density["max"].as_f64().unwrap() > 1.5, "{density}");

    output(volmap(&folder).args(["slice", "duck.h5", "--plane", "z=0", "--field", "density", "-o", "d.png"]));
    let report = ["report", "duck.h5", "--points", "20", "--json", "-", "--mesh"];
    let report: serde_json::Value =
        serde_json::from_str(&output(volmap(&folder).args(report).arg(data("duck.obj")))).unwrap();
    let density = &report["density"];
    assert_eq!((&density["kernel"], &density["quadrature"]), (&"wendland_c2".into(), &"gl20".into()));
    let max = density["rest_densities"]["max"].as_f64().unwrap();
    // Cells of 1.1 r and a coarse rule: some per cent, of densities up to 4.
    assert!((1e-4..0.2).contains(&max), "{density}");

    let points = "x,y,z\n0.62,0,0\n0,0,0\n9,9,9\n";
    let query = ["query", "duck.h5", "--points", "-"];
    let table = output(volmap(&folder).args(query).write_stdin(points));
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][12..], ["density", "gx", "gy", "gz"]);
    assert!(rows[1][12].parse::<f64>().unwrap() > 0.0, "{table}");
    assert_eq!(rows[3][12..], ["0", "0", "0", "0"]);
    let json = output(volmap(&folder).args(query).arg("--json").write_stdin(points));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json[0]["density"], rows[1][12].parse::<f64>().unwrap());
    assert_eq!(json[0]["density_gradient"][0], rows[1][13].parse::<f64>().unwrap());

    let mut default = volmap(&folder);
    default.arg("bake").arg(data("duck.obj")).args(["--resolution", "8", "--density"]);
    assert!(output(&mut default).contains("kernel cubic_spline, by gl50"));
    let mut rounded = volmap(&folder);
    rounded.arg("bake").arg(data("duck.obj")).args(options).args(["--max-rounding", "0.1%"]);
    let summary = output(&mut rounded);
    assert!(summary.contains("of rest density; the worst is"), "{summary}");
    let mut fine = volmap(&folder);
    fine.arg("bake").arg(data("duck.obj")).args(options).args(["--max-rounding", "0.005%"]);
    assert!(error(&mut fine).contains("--max-rounding"));
}

#[test]
fn options_of_the_density_need_it() {
    let folder = folder();
    for option in [["--kernel", "cubic"], ["--density-quadrature", "gl50"], ["--kernel", "spiky"]] {
        let failed = volmap(&folder).arg("bake").arg(data("duck.obj")).args(option).assert().code(2);
        let text = String::from_utf8(failed.get_output().stderr.clone()).unwrap();
        assert!(text.contains("--density") || text.contains("no kernel"), "{text}");
    }
    assert!(names(&folder).is_empty());
}

#[test]
fn a_report_writes_its_files_and_its_exit_code_is_the_verdict() {
    let folder = folder();
    let mesh = data("duck.obj");
    fs::copy(&mesh, folder.path().join("duck.obj")).unwrap();
    output(volmap(&folder).args(["bake", "duck.obj", "--resolution", "12", "-q"]));
    let quick = ["--points", "200", "--mesh-points", "20", "--pixels", "32"];
    // The mesh is found beside the asset.
    let text = output(volmap(&folder).args(["report", "duck.h5"]).args(quick));
    assert!(text.contains("% of the full ball") && text.contains("exact distance to the mesh"), "{text}");
    let parts = ["html", "json", "thin.png", "worst.png", "x.png", "y.png", "z.png"];
    let mut expected = vec!["duck.h5".to_string(), "duck.obj".into()];
    expected.extend(parts.map(|part| format!("duck.report.{part}")));
    assert_eq!(names(&folder), expected);
    let html = fs::read_to_string(folder.path().join("duck.report.html")).unwrap();
    assert!(html.contains("Error report of duck.h5") && html.contains("(no limit set)"));

    // Only the JSON, and the verdict as the exit code.
    for part in &expected[2..] {
        fs::remove_file(folder.path().join(part)).unwrap();
    }
    let gate = |limit: &str| {
        let mut command = volmap(&folder);
        command.args(["report", "duck.h5", "--max-error", limit, "--json", "-"]).args(quick);
        command
    };
    let passed: serde_json::Value = serde_json::from_str(&output(&mut gate("20%"))).unwrap();
    assert_eq!(passed["verdict"]["passed"], true);
    let run = gate("0.001%").assert().code(1);
    let failed: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(failed["verdict"]["passed"], false);
    assert_eq!(failed["verdict"]["max_error"], passed["verdict"]["max_error"]);
    assert_eq!(names(&folder), ["duck.h5", "duck.obj"]);

    // Without the mesh the asset is compared with itself.
    fs::remove_file(folder.path().join("duck.obj")).unwrap();
    let alone: serde_json::Value = serde_json::from_str(&output(&mut gate("20%"))).unwrap();
    assert_eq!(
        (&alone["verdict"]["reference"], &alone["mesh"]),
        (&"fine-own".into(), &serde_json::Value::Null)
    );
    // Another mesh, with a warning; a name of one's own.
    let other = volmap(&folder)
        .args(["report", "duck.h5", "-o", "other", "--mesh"])
        .arg(data("tank.obj"))
        .args(quick)
        .assert()
        .success();
    let warning = String::from_utf8(other.get_output().stderr.clone()).unwrap();
    assert!(warning.contains("tank.obj is not the mesh that was baked"), "{warning}");
    assert!(folder.path().join("other.report.html").exists());
}

#[test]
fn a_report_refuses_what_it_cannot_do() {
    let folder = folder();
    output(volmap(&folder).arg("bake").arg(data("duck.obj")).args(["--resolution", "8", "-q"]));
    for (options, reason) in [
        (["--mesh", "lost.obj"], "lost.obj"),
        (["--json", "no/such/file.json"], "there is no folder"),
        (["--json", "duck.h5"], "would overwrite"),
        (["-o", "no/such/name"], "there is no folder"),
    ] {
        let text = error(volmap(&folder).args(["report", "duck.h5"]).args(options));
        assert!(text.contains(reason), "{text}");
        assert_eq!(names(&folder), ["duck.h5"]);
    }
    for (options, reason) in [
        (["--max-error", "much"], "a part of the ball"),
        (["--max-error", "-1%"], "a part of the ball"),
        (["--shape", "cone:1,2"], "sphere:x,y,z,radius"),
        (["--points", "0"], "from 1"),
        (["--pixels", "5"], "16 to 2048"),
    ] {
        let run = volmap(&folder).args(["report", "duck.h5"]).args(options).assert().code(2);
        let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert!(text.contains(reason), "{text}");
    }
}

#[test]
fn an_experiment_of_the_paper_is_run_by_its_name() {
    let folder = folder();
    let list = output(volmap(&folder).args(["reproduce", "--list"]));
    assert_eq!(list.lines().count(), 4);
    assert!(list.contains("density map and a volume map"), "{list}");
    let table = output(volmap(&folder).args(["reproduce", "plane"]));
    assert!(table.contains("1.600e-5 m^3") && table.contains("  ratio"), "{table}");
    let both: serde_json::Value =
        serde_json::from_str(&output(volmap(&folder).args(["reproduce", "plane", "dragon", "--json"])))
            .unwrap();
    assert_eq!(both["experiments"][0]["name"], "plane");
    // What needs a mesh that isn't there says so.
    let rows = both["experiments"][1]["outcome"]["rows"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["remark"] == "needs the mesh: `dragon`"), "{rows:?}");
    let text = error(volmap(&folder).args(["reproduce", "plane", "--dragon"]).arg(data("duck.obj")));
    assert!(text.contains("--dragon: is for the experiment dragon"), "{text}");
    let run = volmap(&folder).args(["reproduce", "goose"]).assert().code(2);
    assert!(
        String::from_utf8(run.get_output().stderr.clone()).unwrap().contains("duck, plane, dragon, density")
    );
    assert!(names(&folder).is_empty());
}

#[test]
fn an_outline_is_baked_and_asked_in_two_dimensions() {
    let folder = folder();
    let outline = folder.path().join("plate.obj");
    fs::write(&outline, "v 0 0 0\nv 100 0 0\nv 100 50 0\nv 0 50 0\nl 1 2 3 4 1\n").unwrap();
    let bake = |more: &[&str]| {
        let mut command = volmap(&folder);
        command.args(["bake-outline", "plate.obj", "--unit", "cm", "--support-radius", "0.1"]).args(more);
        command
    };
    let summary = output(&mut bake(&["--density", "--translate", "1,2"]));
    assert!(summary.contains("28 x 18 cells") && summary.contains("plate.h5"), "{summary}");
    let json: serde_json::Value =
        serde_json::from_str(&output(volmap(&folder).args(["info", "plate.h5", "--json"]))).unwrap();
    assert_eq!((&json["format_version"], &json["dimension"]), (&4.into(), &2.into()));
    assert_eq!(json["fields"]["volume"]["units"], "m^2");
    assert_eq!(json["source"]["length"], 3.0);
    fs::write(folder.path().join("points.csv"), "x,y,z\n1.5,1.95,0\n1.5,1.95,7\n1.5,2.25,0\n").unwrap();
    let answers = output(volmap(&folder).args(["query", "plate.h5", "--points", "points.csv"]));
    let rows: Vec<Vec<&str>> = answers.lines().map(|line| line.split(',').collect()).collect();
    let distance: f64 = rows[1][3].parse().unwrap();
    assert!((distance - 0.05).abs() < 1e-6 && rows[1][3] == rows[2][3], "{answers}");
    let middle: f64 = rows[3][3].parse().unwrap();
    assert!((middle + 0.25).abs() < 1e-6, "{answers}");
    // The same bytes on one thread, and with them again.
    let once = fs::read(folder.path().join("plate.h5")).unwrap();
    output(&mut bake(&["--density", "--translate", "1,2", "--threads", "1", "-q"]));
    assert!(once == fs::read(folder.path().join("plate.h5")).unwrap());
    for command in [
        &["slice", "plate.h5", "--plane", "z=0", "-o", "a.png"][..],
        &["report", "plate.h5"],
        &["export", "plate.h5", "-o", "a.vti"],
    ] {
        assert!(error(volmap(&folder).args(command)).contains("two dimensions"), "{command:?}");
    }
    fs::write(&outline, "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n").unwrap();
    assert!(error(&mut bake(&[])).contains("the outline is open"));
}
