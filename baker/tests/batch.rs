//! `volmap batch` and `volmap verify`, as a pipeline runs them.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

const VOLMAP: &str = env!("CARGO_BIN_EXE_volmap");

/// A folder with meshes, a manifest and what comes of them.
struct Place(tempfile::TempDir);

impl Place {
    /// With these boxes, by name and height, and the rest of the manifest.
    fn new(boxes: &[(&str, f64)], manifest: &str) -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        std::fs::create_dir(place.at("meshes")).unwrap();
        for (name, height) in boxes {
            place.write(&format!("meshes/{name}.obj"), &box_mesh(*height));
        }
        place.write("assets.toml", &format!("version = 1\n{manifest}"));
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.at(name), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(VOLMAP);
        command.current_dir(self.0.path()).args(arguments).stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// `volmap batch assets.toml --out OUT` with more; what it says, and how it ends.
    fn batch(&self, out: &str, more: &[&str]) -> (Option<i32>, String) {
        let arguments = [&["batch", "assets.toml", "--out", out][..], more].concat();
        let done = self.run(&arguments);
        let text = [done.stdout, done.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        (done.status.code(), text)
    }

    fn summary(&self, out: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.at(out).join("summary.json")).unwrap()).unwrap()
    }

    /// Outcomes by name.
    fn outcomes(&self, out: &str) -> BTreeMap<String, String> {
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let summary = self.summary(out);
        let assets = summary["assets"].as_array().unwrap().iter();
        assets.map(|asset| (text(&asset["name"]), text(&asset["outcome"]))).collect()
    }

    fn asset(&self, out: &str, name: &str) -> Value {
        let summary = self.summary(out);
        let assets = summary["assets"].as_array().unwrap();
        assets.iter().find(|asset| asset["name"] == name).unwrap().clone()
    }

    /// All assets below a folder, by their paths there.
    fn assets(&self, out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        collect(&self.at(out), &mut files);
        files.retain(|path, _| path.extension().is_some_and(|ending| ending == "h5"));
        let relative = |path: PathBuf| path.strip_prefix(self.at(out)).unwrap().to_owned();
        files.into_iter().map(|(path, bytes)| (relative(path), bytes)).collect()
    }
}

fn collect(folder: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => collect(&path, files),
            false => _ = files.insert(path.clone(), std::fs::read(&path).unwrap()),
        }
    }
}

fn box_mesh(height: f64) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let z = if corner & 4 == 0 { 0.0 } else { height };
        writeln!(text, "v {} {} {z}", corner & 1, corner >> 1 & 1).unwrap();
    }
    text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

const SOME: &str = r#"
[defaults]
bake = { support_radius = 0.25 }
error_points = 20
[[assets]]
mesh = "meshes/*.obj"
"#;

fn same(names: &[&str], outcome: &str) -> BTreeMap<String, String> {
    names.iter().map(|name| ((*name).to_owned(), outcome.to_owned())).collect()
}

#[test]
fn only_what_changed_is_made() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5), ("c", 2.0)], SOME);
    let (code, text) = place.batch("out", &[]);
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(place.outcomes("out"), same(&["a", "b", "c"], "built"));
    let first = place.assets("out");
    assert_eq!(first.len(), 3);
    for file in ["summary.html", "junit.xml", "reports/a.preview.png"] {
        assert!(place.at("out").join(file).exists(), "{file}");
    }

    // Nothing; touched; without what was noted.
    let unchanged = || {
        assert_eq!(place.batch("out", &[]).0, Some(0));
        assert_eq!(place.outcomes("out"), same(&["a", "b", "c"], "unchanged"));
        assert_eq!(place.assets("out"), first);
    };
    unchanged();
    place.write("meshes/a.obj", &box_mesh(1.0));
    unchanged();
    std::fs::remove_file(place.at("out/summary.json")).unwrap();
    unchanged();

    // Changed, corrupted, gone.
    place.write("meshes/a.obj", &box_mesh(1.25));
    let mut bytes = std::fs::read(place.at("out/b.h5")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(place.at("out/b.h5"), bytes).unwrap();
    let (_, text) = place.batch("out", &["--explain"]);
    assert!(text.contains("the mesh has changed"), "{text}");
    assert!(text.contains("file damaged"), "{text}");
    assert!(text.contains("up to date: same mesh, parameters and program"), "{text}");
    let outcomes = place.outcomes("out");
    assert_eq!([&outcomes["a"], &outcomes["b"], &outcomes["c"]], ["built", "built", "unchanged"]);
    let second = place.assets("out");
    assert_ne!(second[Path::new("a.h5")], first[Path::new("a.h5")]);
    assert_eq!(second[Path::new("b.h5")], first[Path::new("b.h5")]);

    // Another parameter; the reason names it. Its default, said aloud, is no other.
    place.write("assets.toml", &format!("version = 1\n{}", SOME.replace("0.25", "0.25, padding = 0.0")));
    place.batch("out", &[]);
    assert_eq!(place.outcomes("out"), same(&["a", "b", "c"], "unchanged"));
    place.write("assets.toml", &format!("version = 1\n{}", SOME.replace("0.25", "0.3")));
    place.batch("out", &[]);
    assert_eq!(place.asset("out", "c")["reason"], "support_radius: 0.25 -> 0.3");

    // One that was renamed isn't baked again, and is as if it were.
    std::fs::rename(place.at("meshes/c.obj"), place.at("meshes/d.obj")).unwrap();
    let (_, text) = place.batch("out", &[]);
    assert_eq!(place.asset("out", "d")["outcome"], "reused", "{text}");
    assert!(place.summary("out")["notes"].to_string().contains("c: no longer in the manifest"));
    place.batch("fresh", &[]);
    assert_eq!(place.assets("fresh")[Path::new("d.h5")], place.assets("out")[Path::new("d.h5")]);
    place.batch("out", &["--prune"]);
    assert_eq!(place.assets("out"), place.assets("fresh"));
}

#[test]
fn bad_meshes_fail_alone() {
    let manifest = SOME.replace("meshes/*.obj", "meshes/*");
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], &manifest);
    place.batch("out", &[]);
    let good = std::fs::read(place.at("out/b.h5")).unwrap();
    place.write("meshes/b.obj", "v 0 0\nf 1 2 3\n");
    place.write("meshes/empty.stl", "");
    place.write("meshes/c.obj", &box_mesh(3.0));
    let (code, text) = place.batch("out", &[]);
    assert_eq!(code, Some(1), "{text}");
    let outcomes = place.outcomes("out");
    assert_eq!(outcomes["a"], "unchanged");
    assert_eq!((&*outcomes["b"], &*outcomes["c"], &*outcomes["empty"]), ("failed", "built", "failed"));
    assert!(place.asset("out", "b")["error"].as_str().unwrap().contains("b.obj"), "{text}");
    assert_eq!(std::fs::read(place.at("out/b.h5")).unwrap(), good, "the good one before it stays");
    let junit = std::fs::read_to_string(place.at("out/junit.xml")).unwrap();
    assert!(junit.contains("<error") && junit.contains("empty"));
}

#[test]
fn batches_that_cannot_start_say_so() {
    let place = Place::new(&[("a", 1.0)], SOME);
    for (arguments, says) in [
        (&["batch", "missing.toml", "--out", "out"][..], "missing.toml"),
        (&["batch", "nothing/*.obj", "--out", "out"], "nothing"),
        (&["batch", "assets.toml", "--out", "out", "--padding", "1"], "[defaults]"),
        (&["batch", "assets.toml", "--out", "assets.toml"], "assets.toml"),
        (&["batch", "assets.toml", "--out", "out", "--tag", "x"], "no asset has this tag"),
        (&["batch", "--merge", "meshes"], "meshes"),
        (&["verify", "meshes"], "summary.json"),
    ] {
        let done = place.run(arguments);
        let text = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.starts_with("error: ") && text.contains(says), "{arguments:?}: {text}");
    }
    place.write(
        "assets.toml",
        "version = 1\n[[assets]]\nmesh = \"meshes/a.obj\"\nbake = { invertt = true }\n",
    );
    let text = String::from_utf8(place.run(&["batch", "assets.toml", "--out", "out"]).stderr).unwrap();
    assert!(text.contains("assets.toml:4:10: unknown key `invertt`; did you mean `invert`?"), "{text}");
    place.write("out.h5", "x");
    assert!(!place.at("out").exists(), "nothing is made before all is checked");
}

#[test]
fn foreign_files_are_not_replaced() {
    let place = Place::new(&[("a", 1.0)], SOME);
    let bake = ["bake", "meshes/a.obj", "-o", "out/a.h5", "--support-radius", "0.5", "-q"];
    std::fs::create_dir(place.at("out")).unwrap();
    assert!(place.run(&bake).status.success());
    let before = place.assets("out");
    let (code, text) = place.batch("out", &[]);
    assert_eq!(code, Some(1));
    assert!(text.contains("wasn't made by a batch"), "{text}");
    assert_eq!(place.assets("out"), before);
    assert_eq!(place.batch("out", &["--rebuild"]).0, Some(0));
    assert_ne!(place.assets("out"), before);
}

#[test]
fn gates_hold_assets_back() {
    let strict = format!("{SOME}gates = {{ must_be_closed = true, max_error = \"0.0001%\" }}\n");
    let place = Place::new(&[("a", 1.0)], SOME);
    place.batch("out", &[]);
    let good = place.assets("out");
    place.write("meshes/a.obj", &box_mesh(1.25).replace("f 2 4 8 6\n", ""));
    place.write("assets.toml", &format!("version = 1\n{strict}"));
    let (code, text) = place.batch("out", &[]);
    assert_eq!((code, &*place.outcomes("out")["a"]), (Some(1), "rejected"), "{text}");
    let gates = place.asset("out", "a")["failed_gates"].to_string();
    assert!(gates.contains("must_be_closed") && gates.contains("max_error"), "{gates}");
    let after = place.assets("out");
    assert_eq!(after[Path::new("a.h5")], good[Path::new("a.h5")], "the good one before it stays");
    assert!(after.contains_key(Path::new("rejected/a.h5")));
    // It isn't baked again to be refused again, nor to be taken when its gates are wider.
    place.batch("out", &[]);
    assert_eq!(place.asset("out", "a")["reason"], "up to date: same mesh, parameters and program");
    let wide = format!("{SOME}gates = {{ max_sign_disagreements = \"10%\" }}\n");
    place.write("assets.toml", &format!("version = 1\n{wide}"));
    let (code, text) = place.batch("out", &[]);
    assert_eq!((code, &*place.outcomes("out")["a"]), (Some(0), "reused"), "{text}");
    assert!(!place.at("out/rejected/a.h5").exists());
}

const SHEET: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n";

#[test]
fn maps_without_a_solid_or_with_signs_in_doubt_are_doubtful() {
    let place = Place::new(&[("good", 1.0)], SOME);
    place.write("meshes/sheet.obj", SHEET);
    place.write("meshes/open.obj", &box_mesh(1.0).replace("f 2 4 8 6\n", ""));
    let (code, text) = place.batch("out", &[]);
    assert_eq!(code, Some(1), "{text}");
    let outcomes = place.outcomes("out");
    let of = |name: &str| outcomes[name].as_str();
    assert_eq!([of("good"), of("sheet"), of("open")], ["built", "doubtful", "doubtful"]);
    assert_eq!(place.summary("out")["counts"]["doubtful"], 2);
    let gates = |name: &str| place.asset("out", name)["failed_gates"].to_string();
    assert!(gates("sheet").contains("must_have_solid") && gates("sheet").contains("max_sign_disagreements"));
    assert!(!gates("open").contains("must_have_solid") && gates("open").contains("more than 1 %"), "{text}");
    assert!(place.at("out/rejected/sheet.h5").exists() && !place.at("out/sheet.h5").exists());
    // Told in the log, with the warnings, and first on the page.
    assert!(
        text.contains("doubtful   sheet: ") && text.contains("assets     3: 1 built, 2 doubtful"),
        "{text}"
    );
    assert!(text.contains("           warning: no node lies inside: the map has no solid"), "{text}");
    assert!(text.contains("\nwarnings   ") && text.contains(" in 2 assets\n"), "{text}");
    let page = std::fs::read_to_string(place.at("out/summary.html")).unwrap();
    assert!(
        page.contains("<h2>Failed, rejected and doubtful</h2>") && page.contains("must_have_solid: no node")
    );
    assert!(page.find("Failed, rejected and doubtful") < page.find(">Assets<"));

    // Again they aren't baked, and still aren't good; nor for `verify`.
    let (code, _) = place.batch("out", &[]);
    assert_eq!((code, &*place.outcomes("out")["sheet"]), (Some(1), "doubtful"));
    let done = place.run(&["verify", "out"]);
    let text = String::from_utf8(done.stdout).unwrap();
    assert_eq!(done.status.code(), Some(1), "{text}");
    assert!(
        text.contains("sheet: doubtful: must_have_solid: ") && text.contains("1 of 3 assets are good"),
        "{text}"
    );
    let json = place.run(&["verify", "out", "--json"]).stdout;
    let found: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&found[0]["standing"], &found[2]["standing"]), (&"good".into(), &"doubtful".into()));

    // The manifest can allow both; another gate's refusal is no doubt.
    let allow = "gates = { must_have_solid = false, max_sign_disagreements = \"100%\" }\n";
    place.write("assets.toml", &format!("version = 1\n{SOME}{allow}"));
    let (code, text) = place.batch("out", &[]);
    assert_eq!((code, &*place.outcomes("out")["sheet"]), (Some(0), "reused"), "{text}");
    place.write("assets.toml", &format!("version = 1\n{SOME}gates = {{ must_be_closed = true }}\n"));
    place.batch("fresh", &[]);
    assert_eq!(place.outcomes("fresh")["sheet"], "rejected");
}

#[test]
fn a_bake_warns_of_what_is_doubtful() {
    let place = Place::new(&[], "");
    place.write("open.obj", &box_mesh(1.0).replace("f 2 4 8 6\n", ""));
    let done = place.run(&["bake", "open.obj", "--support-radius", "0.25"]);
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(done.status.success() && text.contains("warning    the sign is in doubt at about "), "{text}");
    place.write("sheet.obj", SHEET);
    let text = String::from_utf8(place.run(&["bake", "sheet.obj"]).stdout).unwrap();
    assert!(text.contains("warning    no node lies inside: the map has no solid"), "{text}");
}

#[test]
fn the_page_grows_while_the_batch_is_at_work() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let slow = "[[assets]]\nmesh = \"meshes/b.obj\"\nbake = { cell_size = 0.008, quadrature = \"gl30\" }\n";
    place.batch("out", &[]);
    // The long one is begun first.
    place.write("assets.toml", &format!("version = 1\n{SOME}{slow}"));
    let mut batch = place.command(&["batch", "assets.toml", "--out", "out", "--jobs", "1"]).spawn().unwrap();
    let page = || std::fs::read_to_string(place.at("out/summary.html")).unwrap();
    while !page().contains("At work: 1 of 2 done") && batch.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let found = page();
    batch.kill().unwrap();
    batch.wait().unwrap();
    assert!(found.contains("At work: 1 of 2 done") && found.contains("http-equiv=\"refresh\""), "{found}");
    assert!(found.contains(">unchanged<") && found.contains(">in work<") || found.contains(">to do<"));
    place.write("assets.toml", &format!("version = 1\n{SOME}"));
    place.batch("out", &[]);
    assert!(page().contains("2 of 2") && !page().contains("At work"));
}

#[test]
fn files_of_other_formats_are_counted_and_named() {
    let place = Place::new(&[("a", 1.0)], &SOME.replace("meshes/*.obj", "meshes/**/*"));
    place.write("meshes/rig.fbx", "x");
    place.write("meshes/part.STEP", "x");
    place.write("meshes/notes.txt", "x");
    let (code, text) = place.batch("out", &["--check"]);
    assert!(
        code == Some(0) && text.contains("left out       1 FBX file (meshes/rig.fbx) isn't read: "),
        "{text}"
    );
    let (code, text) = place.batch("out", &[]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("left out   1 FBX file (meshes/rig.fbx) isn't read: convert with `assimp export"),
        "{text}"
    );
    assert!(
        text.contains("left out   1 STEP file (meshes/part.STEP)") && !text.contains("notes.txt"),
        "{text}"
    );
    let left_out = &place.summary("out")["left_out"];
    assert_eq!(
        (&left_out[0]["format"], &left_out[1]["files"][0]),
        (&"FBX".into(), &"meshes/part.STEP".into())
    );
    let page = std::fs::read_to_string(place.at("out/summary.html")).unwrap();
    assert!(page.contains("meshes/rig.fbx") && page.contains("how to convert them"));
    // What is excluded isn't missed; where nothing else is there, it is why.
    place.write(
        "assets.toml",
        &format!("version = 1\n{}exclude = \"**/*.fbx\"\n", SOME.replace("*.obj", "*")),
    );
    assert!(!place.batch("out", &[]).1.contains("FBX"));
    let done = place.run(&["batch", "meshes/r*", "--out", "other"]);
    let text = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.code() == Some(2) && text.contains("1 FBX file (meshes/rig.fbx)"), "{text}");
}

#[test]
fn reports_have_an_estimate_and_a_timeout_of_their_own() {
    let place = Place::new(&[("a", 1.0)], SOME);
    let seconds = |more: &str| {
        place.write("assets.toml", &format!("version = 1\n{SOME}{more}"));
        let (code, text) = place.batch("out", &["--check", "--log", "json", "--threads", "1"]);
        assert_eq!(code, Some(0), "{text}");
        let found: Value = serde_json::from_str(&text).unwrap();
        (found["seconds"].as_f64().unwrap(), found["memory"].as_u64().unwrap())
    };
    let (without, with) = (seconds(""), seconds("report = true\n"));
    assert!(with.0 > without.0 + 1.0 && with.1 > without.1, "{without:?} {with:?}");

    // The bake has time enough, the report none.
    place.write(
        "assets.toml",
        &format!("version = 1\n{SOME}report = true\ntimeout = 300\nreport_timeout = 0.05\n"),
    );
    let (code, text) = place.batch("out", &[]);
    let error = place.asset("out", "a")["error"].to_string();
    assert_eq!(code, Some(1), "{text}");
    assert!(
        error.contains("its report took longer than its report_timeout of 0.05 s")
            && error.contains("`report_timeout`")
    );
    place.write(
        "assets.toml",
        &format!("version = 1\n{SOME}report = true\ngates = {{ max_error = \"5%\" }}\n"),
    );
    let (code, text) = place.batch("out", &["--report-timeout", "300"]);
    assert_eq!(code, Some(0), "{text}");
    // The gate is the report's limit.
    let report = std::fs::read_to_string(place.at("out/reports/a.report.html")).unwrap();
    assert!(report.contains("the limit is 5 %: passed") && !report.contains("no limit set"));
}

#[test]
fn a_unit_that_is_not_meant_is_told_with_the_parameter_that_was_given() {
    let place = Place::new(&[("metres", 1.0)], SOME);
    let (corners, faces) =
        box_mesh(1.0).split_once("f ").map(|(a, b)| (a.replace(" 1", " 1000"), b.to_owned())).unwrap();
    place.write("meshes/flange.obj", &format!("{corners}f {faces}"));
    let manifest = "[[assets]]\nmesh = \"meshes/*.obj\"\nbake = { particle_radius = 0.0025 }\n";
    place.write("assets.toml", &format!("version = 1\n{manifest}"));
    let says = "the mesh is 1,000 m long, 100,000 support radii; if its numbers are millimetres, give `unit` \
     mm (1 m then)";
    let (code, text) = place.batch("out", &["--check"]);
    assert!(
        code == Some(1) && text.contains(&format!("cannot bake    flange: {says}: particle_radius: ")),
        "{text}"
    );
    let large = manifest.replace("0.0025", "0.4");
    place.write("assets.toml", &format!("version = 1\n{large}"));
    let (code, text) = place.batch("out", &["--max-memory", "64MiB"]);
    assert!(
        code == Some(1)
            && text.contains("flange: the mesh is 1,000 m long, 625 support radii: the bake would"),
        "{text}"
    );
    // By default the radius follows from the mesh, and the warning comes before the bake and after it.
    place.write("assets.toml", "version = 1\n[[assets]]\nmesh = \"meshes/*.obj\"\n");
    let warning =
        "warning: the mesh is 1,000 m long; if its numbers are millimetres, give `unit` mm (1 m then)";
    for more in [&["--check"][..], &[]] {
        let (code, text) = place.batch("out", more);
        assert!(code == Some(0) && text.contains(warning), "{text}");
        assert_eq!(text.matches("if its numbers").count(), 1, "{text}");
    }
    // The command line's words.
    let bake = |more: &[&str]| {
        let done = place.run(&[&["bake", "meshes/flange.obj"][..], more].concat());
        [done.stdout, done.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat()
    };
    let text = bake(&["--particle-radius", "0.0025"]);
    assert!(text.starts_with("error: the mesh is 1,000 m long, 100,000 support radii; if its"), "{text}");
    assert!(text.contains("give --unit mm (1 m then): --particle-radius: "), "{text}");
    let text = bake(&[]);
    assert!(
        text.contains("warning    the mesh is 1,000 m long; if its numbers are millimetres, give --unit mm"),
        "{text}"
    );
    assert!(
        !bake(&["--unit", "mm"]).contains("millimetres") && !bake(&["--unit", "m"]).contains("millimetres")
    );
}

#[test]
fn rules_too_coarse_for_a_density_are_refused_before_the_bake() {
    let place = Place::new(&[("a", 1.0)], SOME);
    let text = |output: Output| String::from_utf8(output.stderr).unwrap();
    let bake = ["bake", "meshes/a.obj", "--density", "--density-quadrature", "gl2"];
    let error = text(place.run(&bake));
    assert!(
        error.contains("--density-quadrature: gl2 is too coarse for the kernel")
            && error.contains("take gl50"),
        "{error}"
    );
    place.write(
        "assets.toml",
        "version = 1\n[[assets]]\nmesh = \"meshes/*.obj\"\nbake = { density = true, density_quadrature = \"gl2\" }\n",
    );
    let done = place.run(&["batch", "assets.toml", "--out", "out"]);
    assert_eq!(done.status.code(), Some(2));
    let error = text(done);
    assert!(error.contains("assets.toml:4:") && error.contains("density_quadrature"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_temporary_folder_that_cannot_be_used_is_named_with_the_cure() {
    let place = Place::new(&[("a", 1.0)], SOME);
    let bake = ["bake", "meshes/a.obj", "--support-radius", "0.25"];
    let nowhere = place.at("nowhere");
    let done = place.command(&bake).env("TMPDIR", &nowhere).output().unwrap();
    let text = String::from_utf8_lossy(&done.stderr);
    let says = format!("a.h5: the asset passes through a file in the temporary folder {}", nowhere.display());
    assert!(done.status.code() == Some(1) && text.contains(&says) && text.contains("TMPDIR"), "{text}");
    assert!(!text.contains("rust-hdf5") && !place.at("a.h5").exists(), "{text}");
}

#[test]
fn the_cache_is_shown_listed_and_cleared() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    place.batch("out", &["--cache", "kept"]);
    let cache = |arguments: &[&str]| {
        let done = place
            .command(&[&["cache"][..], arguments].concat())
            .env("XDG_CACHE_HOME", place.at("xdg"))
            .output();
        let done = done.unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).unwrap()
    };
    let shown = cache(&["--folder", "kept"]);
    assert!(shown.starts_with("folder     kept\nmaps       2 ("), "{shown}");
    let listed = cache(&["list", "--folder", "kept"]);
    assert!(listed.lines().count() == 2 && listed.lines().all(|line| line.ends_with(".h5")), "{listed}");
    place.write("kept/notes.txt", "mine");
    assert_eq!(cache(&["clear", "--folder", "kept", "--older-than", "1d"]), "removed    0 (0 B)\n");
    // A map that a program has open stays readable, and a batch goes on with an empty cache.
    assert!(cache(&["clear", "--folder", "kept"]).starts_with("removed    2 ("));
    assert!(place.assets("kept").is_empty() && place.at("kept/notes.txt").exists());
    assert_eq!(place.batch("again", &["--cache", "kept"]).0, Some(0));
    assert_eq!(place.assets("kept").len(), 2);
    // That of simulations is found by itself; it need not be there.
    let shown = cache(&[]);
    assert!(shown.contains("xdg") && shown.contains("volmap\nmaps       0 (0 B)"), "{shown}");
}

#[test]
fn killed_batches_go_on_to_the_same_bytes() {
    let boxes: Vec<(String, f64)> = (0..6).map(|i| (format!("b{i}"), 1.0 + 0.1 * f64::from(i))).collect();
    let boxes: Vec<(&str, f64)> = boxes.iter().map(|(name, height)| (name.as_str(), *height)).collect();
    let place = Place::new(&boxes, SOME);
    assert_eq!(place.batch("whole", &[]).0, Some(0));
    for delay in [15, 40, 80, 130, 190] {
        let mut child = place.command(&["batch", "assets.toml", "--out", "out"]).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(delay));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let (code, text) = place.batch("out", &[]);
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(place.assets("out"), place.assets("whole"));
    let mut files = BTreeMap::new();
    collect(&place.at("out"), &mut files);
    assert!(
        files.keys().all(|path| path.extension().is_none_or(|ending| ending != "part")),
        "{:?}",
        files.keys()
    );
}

#[test]
fn two_batches_share_a_cache_and_not_a_folder() {
    let boxes = [("a", 1.0), ("b", 1.5), ("c", 2.0), ("d", 2.5)];
    let place = Place::new(&boxes, SOME);
    let start = |out: &str| -> Child {
        place.command(&["batch", "assets.toml", "--out", out, "--cache", "cache"]).spawn().unwrap()
    };
    let both = [start("one"), start("two")].map(|child| child.wait_with_output().unwrap());
    assert!(both.iter().all(|done| done.status.success()), "{both:?}");
    assert_eq!(place.assets("one"), place.assets("two"));
    assert_eq!(place.assets("cache").len(), boxes.len());
    // A third bakes nothing, and isn't fooled by a damaged file there.
    let damaged = place.at("cache").join(place.assets("cache").into_keys().next().unwrap());
    std::fs::write(&damaged, "x").unwrap();
    place.batch("three", &["--cache", "cache"]);
    let outcomes: Vec<String> = place.outcomes("three").into_values().collect();
    let count = |outcome: &str| outcomes.iter().filter(|found| *found == outcome).count();
    assert_eq!((count("reused"), count("built")), (3, 1));
    assert_eq!(place.assets("three"), place.assets("one"));
    assert!(std::fs::read(&damaged).unwrap().len() > 1, "mended");

    let lock = std::fs::File::open(place.at("one/.volmap-batch.jsonl")).unwrap();
    lock.lock().unwrap();
    let (code, text) = place.batch("one", &[]);
    assert!(code == Some(2) && text.contains("another batch is at work"), "{text}");
}

#[test]
fn shards_make_the_whole() {
    let boxes = [("a", 1.0), ("b", 1.5), ("c", 2.0), ("d", 2.5), ("e", 3.0)];
    let place = Place::new(&boxes, SOME);
    place.write("meshes/bad.obj", "f 1 2 3\n");
    assert_eq!(place.batch("whole", &[]).0, Some(1));
    for (name, value) in [("SLURM_ARRAY_TASK_ID", "0"), ("SLURM_ARRAY_TASK_ID", "2")] {
        let mut command = place.command(&["batch", "assets.toml", "--out", "out", "--shard", "auto/3"]);
        command.env(name, value).output().unwrap();
    }
    let early = place.run(&["batch", "--merge", "out"]);
    let text = String::from_utf8(early.stderr).unwrap();
    assert!(early.status.code() == Some(2) && text.contains('2'), "{text}");
    place.batch("out", &["--shard", "2/3"]);
    assert_eq!(place.run(&["batch", "--merge", "out"]).status.code(), Some(1), "one is bad");
    assert_eq!(place.assets("out"), place.assets("whole"));
    let plain = |out: &str| {
        let mut assets = place.summary(out)["assets"].clone();
        for asset in assets.as_array_mut().unwrap() {
            for of_the_run in ["seconds", "threads", "peak_memory"] {
                asset[of_the_run] = Value::Null;
            }
        }
        assets
    };
    assert_eq!(plain("out"), plain("whole"));
}

#[test]
fn limits_end_an_asset_and_not_the_batch() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let slow = "[[assets]]\nmesh = \"meshes/b.obj\"\ntimeout = 0.05\nbake = { cell_size = 0.01, quadrature = \
        \"gl30\" }\n";
    place.write("assets.toml", &format!("version = 1\n{SOME}{slow}"));
    let (code, text) = place.batch("out", &[]);
    assert_eq!((code, &*place.outcomes("out")["a"]), (Some(1), "built"), "{text}");
    let error = place.asset("out", "b")["error"].to_string();
    assert!(error.contains("timeout of 0.05 s"), "{error}");

    let large = slow.replace("timeout = 0.05\n", "").replace("0.01", "0.002");
    place.write("assets.toml", &format!("version = 1\n{SOME}{large}"));
    let (_, text) = place.batch("out", &["--max-memory", "1GiB"]);
    let error = place.asset("out", "b")["error"].to_string();
    assert!(error.contains("more than the 1024 MiB that it may take (`max_memory`)"), "{text} {error}");
    // A shard's costs are known before; its other assets are made all the same.
    let (_, text) = place.batch("shard", &["--max-memory", "1GiB", "--shard", "1/1"]);
    assert!(
        text.contains("more than the 1024 MiB that it may take (`max_memory`)") && text.contains("built"),
        "{text}"
    );
}

#[test]
fn what_is_not_the_batchs_own_stays() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let all = &["--cache", "out/cache"][..];
    place.batch("out", all);
    let sub = ["batch", "meshes/b.obj", "--out", "out/sub", "--support-radius", "0.25"];
    assert!(place.run(&sub).status.success());
    place.write("out/notes.h5", "somebody's");
    std::fs::remove_file(place.at("meshes/b.obj")).unwrap();
    let before = place.assets("out");
    let (code, text) = place.batch("out", &[all, &["--prune"]].concat());
    assert_eq!(code, Some(0), "{text}");
    let after = place.assets("out");
    let gone: Vec<&PathBuf> = before.keys().filter(|path| !after.contains_key(*path)).collect();
    assert_eq!(gone, [Path::new("b.h5")], "the cache, another batch's folder and other files are left alone");
    assert!(text.contains("b: removed"), "{text}");

    // Folders of the batch's own are no names.
    place.write(
        "assets.toml",
        "version = 1\n[[assets]]\nmesh = \"meshes/a.obj\"\nname = \"Rejected/{stem}\"\n",
    );
    let (code, text) = place.batch("out", &[]);
    assert!(code == Some(2) && text.contains("folder of the batch's own"), "{text}");
}

#[test]
fn renaming_and_pruning_at_once_bakes_nothing() {
    let place = Place::new(&[("a", 1.0)], SOME);
    place.batch("out", &[]);
    std::fs::rename(place.at("meshes/a.obj"), place.at("meshes/b.obj")).unwrap();
    place.batch("out", &["--prune"]);
    assert_eq!(place.outcomes("out"), same(&["b"], "reused"));
    assert_eq!(place.assets("out").len(), 1);
}

#[cfg(unix)]
#[test]
fn nobody_need_listen() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let command = format!("{VOLMAP} batch assets.toml --out out | true; exit ${{PIPESTATUS[0]}}");
    let done = Command::new("bash").args(["-c", &command]).current_dir(place.0.path()).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(place.assets("out").len(), 2);
}

#[cfg(unix)]
#[test]
fn signals_stop_it_and_what_is_done_stays() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let slow = "[[assets]]\nmesh = \"meshes/b.obj\"\nbake = { cell_size = 0.008, quadrature = \"gl30\" }\n";
    place.batch("out", &[]);
    let before = place.assets("out");
    place.write("assets.toml", &format!("version = 1\n{SOME}{slow}"));
    let lines = |batch: &mut Child| std::io::BufReader::new(batch.stdout.take().unwrap()).lines();
    let explain = ["batch", "assets.toml", "--out", "out", "--explain"];
    let mut batch = place.command(&explain).spawn().unwrap();
    let first = lines(&mut batch).next().unwrap().unwrap();
    assert!(first.starts_with("unchanged  a"), "{first}");
    let kill = Command::new("kill").args(["-TERM", &batch.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let done = batch.wait_with_output().unwrap();
    assert_eq!(done.status.code(), Some(130), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(place.summary("out")["interrupted"], true);
    let outcomes = place.outcomes("out");
    assert_eq!((&*outcomes["a"], &*outcomes["b"]), ("unchanged", "not_tried"));
    assert_eq!(place.assets("out"), before);
}

#[test]
fn bytes_do_not_depend_on_jobs_or_threads() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5), ("c", 2.0)], SOME);
    place.batch("one", &["--jobs", "1", "--threads", "1"]);
    place.batch("many", &["--jobs", "3", "--threads", "6"]);
    assert_eq!(place.assets("one"), place.assets("many"));
    assert_eq!(place.assets("one").len(), 3);
}

#[test]
fn verify_finds_what_is_not_as_it_should_be() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5), ("c", 2.0), ("d", 2.5)], SOME);
    place.batch("out", &[]);
    let verify = |more: &[&str]| {
        let done = place.run(&[&["verify", "out"][..], more].concat());
        (done.status.code(), String::from_utf8(done.stdout).unwrap())
    };
    assert_eq!(verify(&[]), (Some(0), "4 of 4 assets are good\n".into()));
    let before = place.assets("out");
    place.write("meshes/a.obj", &box_mesh(1.1));
    let mut bytes = before[Path::new("b.h5")].clone();
    let end = bytes.len() - 100;
    bytes.truncate(end);
    std::fs::write(place.at("out/b.h5"), bytes).unwrap();
    std::fs::remove_file(place.at("out/c.h5")).unwrap();
    let (code, text) = verify(&["--manifest", "assets.toml"]);
    assert_eq!(code, Some(1), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0] == "a: the mesh has changed", "{text}");
    assert!(lines[1].starts_with("b: file damaged"), "{text}");
    assert_eq!(lines[2], "c: file missing");
    assert_eq!(lines[3], "1 of 4 assets are good");
    assert!(!place.at("out/c.h5").exists(), "nothing is baked");
    let (_, json) = verify(&["--json"]);
    assert_eq!(serde_json::from_str::<Value>(&json).unwrap()[3]["problems"], serde_json::json!([]));
}

#[test]
fn checks_estimate_and_make_nothing() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let (code, text) = place.batch("out", &["--check"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("would bake     a (new)") && text.contains("2 to bake, 0 up to date"), "{text}");
    assert!(!place.at("out").exists());
    place.batch("out", &[]);
    let (_, text) = place.batch("out", &["--check"]);
    assert!(text.contains("0 to bake, 2 up to date"), "{text}");
    place.write("meshes/c.obj", "f 1 2 3\n");
    let (code, text) = place.batch("out", &["--check"]);
    assert!(code == Some(1) && text.contains("cannot bake    c:"), "{text}");
    let (_, text) = place.batch("out", &["--check", "--log", "json"]);
    let found: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&found["assets"][0]["reason"], found["assets"][0]["cost"]["file"].is_u64()),
        (&Value::Null, true)
    );
    assert!(found["assets"][2]["error"].as_str().unwrap().contains("c.obj"), "{text}");
}

#[test]
fn patterns_need_no_manifest() {
    let place = Place::new(&[("a", 1.0), ("b", 1.5)], SOME);
    let done =
        place.run(&["batch", "meshes/*.obj", "--out", "out", "--support-radius", "0.25", "--log", "json"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let lines = String::from_utf8(done.stdout).unwrap();
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3);
    assert!(lines.iter().take(2).all(|line| line["event"] == "asset" && line["outcome"] == "built"));
    assert_eq!(place.assets("out").len(), 2);
}

#[test]
fn manuals_and_completions_are_made_of_the_arguments() {
    let place = Place::new(&[], "");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = String::from_utf8(place.run(&["completions", shell]).stdout).unwrap();
        assert!(text.contains("max-memory") && text.contains("verify"), "{shell}");
    }
    let page = String::from_utf8(place.run(&["man"]).stdout).unwrap();
    assert!(page.contains(".TH volmap 1") && page.contains("batch"));
    assert!(place.run(&["man", "--output", "man"]).status.success());
    let page = std::fs::read_to_string(place.at("man/volmap-batch.1")).unwrap();
    assert!(page.contains("shard") && !place.at("man/volmap-batch-worker.1").exists());
}
