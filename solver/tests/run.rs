//! `volmap-sim run`: the same bytes on any number of threads and after any interruption; clear refusals.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;
use volmap_bake::watch::Watch;
use volmap_scenes::session::{Progress, RunSettings, Session};

/// Water and a jet in a tank of 1 m, with a cube that floats; two blocks overlap.
const SCENE: &str = r#"
version = 1
particle_radius = 0.04

[[blocks]]
min = [-0.48, 0.0, -0.48]
max = [0.0, 0.5, 0.48]

[[blocks]]
min = [-0.1, 0.06, -0.3]
max = [0.3, 0.3, 0.3]
velocity = [0.5, 0.0, 0.0]

[[emitters]]
position = [-0.2, 0.85, 0.0]
direction = [0.0, -1.0, 0.0]
speed = 2.0
nozzle = { circle = { radius = 0.12 } }

[[bodies]]
name = "tank"
mesh = "TANK"
bake = { invert = true, scale = 0.322580645161 }

[[bodies]]
name = "float"
mesh = "cube.obj"
bake = { scale = 0.25 }
translation = [0.2, 0.6, 0.0]
motion = { free = { density = 400.0 } }

[solver.time_step]
max = 0.002

[output]
frames_per_second = 20.0
preview = ["png"]
checkpoint_interval = 0.03

[stop]
time = 0.24
"#;

const CUBE: &str = "v -.5 -.5 -.5\nv .5 -.5 -.5\nv -.5 .5 -.5\nv .5 .5 -.5\nv -.5 -.5 .5\nv .5 -.5 .5\nv -.5 .5 \
    .5\nv .5 .5 .5\n\
                    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// The same, thick, and the cube sticks.
fn thick() -> String {
    let fluid = "[fluid]\nviscosity = 0.3\nviscosity_method = \"implicit\"\n\n[solver.time_step]";
    let free = "motion = { free";
    let sticks = "material = { fluid_viscosity = 0.3, fluid_friction = 0.01 }\nmotion = { free";
    SCENE.replace("[solver.time_step]", fluid).replace(free, sticks)
}

/// A folder with a scene and room for runs.
struct Place(TempDir);

impl Place {
    fn new(scene: &str) -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.write(scene);
        place
    }

    fn write(&self, scene: &str) {
        let tank = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/tank.obj");
        let text = scene.replace("TANK", &tank.display().to_string().replace('\\', "/"));
        std::fs::write(self.0.path().join("scene.toml"), text).unwrap();
        std::fs::write(self.0.path().join("cube.obj"), CUBE).unwrap();
    }

    fn folder(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, name: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_volmap-sim"));
        command
            .arg("run")
            .arg(self.0.path().join("scene.toml"))
            .arg("-o")
            .arg(self.folder(name))
            .args(arguments);
        // Maps are named by what they are made of: all tests share them.
        command.env("XDG_CACHE_HOME", Path::new(env!("CARGO_TARGET_TMPDIR")).join("maps"));
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn run(&self, name: &str, arguments: &[&str]) -> Output {
        self.command(name, arguments).output().unwrap()
    }

    fn succeed(&self, name: &str, arguments: &[&str]) {
        let done = self.run(name, arguments);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }

    /// The error of a run that can't start.
    fn refuse(&self, name: &str, arguments: &[&str]) -> String {
        let done = self.run(name, arguments);
        let told = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(1), "{told}");
        let error = told.lines().find(|line| line.starts_with("error: "));
        error.unwrap_or_else(|| panic!("no error: {told}")).to_owned()
    }

    /// Starts a run and waits until its table has some lines, or it has ended.
    fn start_until(&self, name: &str, arguments: &[&str], lines: usize) -> Child {
        let mut child = self.command(name, arguments).spawn().unwrap();
        while self.lines(name) < lines && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        child
    }

    fn lines(&self, name: &str) -> usize {
        std::fs::read_to_string(self.folder(name).join("stats.csv")).map_or(0, |text| text.lines().count())
    }

    /// One column of stats.csv.
    fn column(&self, name: &str, column: &str) -> Vec<f64> {
        self.column_of(name, "stats.csv", column)
    }

    fn column_of(&self, name: &str, table: &str, column: &str) -> Vec<f64> {
        let mut table = csv::Reader::from_path(self.folder(name).join(table)).unwrap();
        let at = table.headers().unwrap().iter().position(|header| header == column).unwrap();
        table.records().map(|row| row.unwrap()[at].parse().unwrap()).collect()
    }

    /// All files of a run, wall-clock times apart.
    fn content(&self, name: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        collect(&self.folder(name), &mut files);
        files.retain(|path, _| !path.ends_with("stats.json"));
        let files = files.into_iter().map(|(path, bytes)| {
            let bytes = if path.ends_with("stats.csv") { without_times(&bytes) } else { bytes };
            (path.strip_prefix(self.folder(name)).unwrap().to_owned(), bytes)
        });
        files.collect()
    }

    fn assert_same(&self, a: &str, b: &str) {
        let (a, b) = (self.content(a), self.content(b));
        assert!(a.keys().eq(b.keys()), "{:?} {:?}", a.keys(), b.keys());
        for (path, bytes) in &a {
            assert!(*bytes == b[path], "{} differs", path.display());
        }
    }
}

fn collect(folder: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.insert(path.clone(), std::fs::read(&path).unwrap());
        }
    }
}

fn without_times(bytes: &[u8]) -> Vec<u8> {
    let mut table = csv::Reader::from_reader(bytes);
    let kept: Vec<bool> = table.headers().unwrap().iter().map(|header| !header.ends_with("_ms")).collect();
    let rows = table.records().flat_map(|row| {
        let row = row.unwrap();
        let cells: Vec<&str> =
            row.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(cell, _)| cell).collect();
        (cells.join(",") + "\n").into_bytes()
    });
    rows.collect()
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let place = Place::new(&thick());
    for threads in ["1", "2", "4"] {
        place.succeed(threads, &["--threads", threads, "--until", "0.1"]);
    }
    let files = place.content("1");
    assert!(
        files.contains_key(Path::new("checkpoint"))
            && files.contains_key(Path::new("particles/frame_000002.vtu"))
    );
    place.assert_same("1", "2");
    place.assert_same("1", "4");
    // The cube and the jet are there, and viscosity is solved for.
    assert!(place.column("1", "near_bodies").iter().any(|&n| n > 0.0));
    assert!(place.column("1", "viscosity_iterations").iter().all(|&n| n > 0.0));
    assert!(place.column("1", "viscosity_error").iter().all(|&error| error <= 1e-3));
    assert!(place.column("1", "emitted").iter().sum::<f64>() > 0.0);
}

#[test]
fn killed_runs_go_on_to_the_same_bytes() {
    let place = Place::new(SCENE);
    place.succeed("whole", &["--threads", "2"]);
    let lines = place.lines("whole");
    assert!(lines > 100);
    let mut killed = 0;
    for (after, extra) in [(5, 0), (30, 3), (30, 0), (60, 1), (85, 7), (100, 2)] {
        let goes_on = place.folder("killed").join("checkpoint").exists();
        let how = if goes_on { "--resume" } else { "--overwrite" };
        let mut child = place.start_until("killed", &[how, "--threads", "1"], after);
        std::thread::sleep(Duration::from_millis(extra));
        // SIGKILL on Unix.
        child.kill().unwrap();
        killed += usize::from(!child.wait().unwrap().success());
    }
    assert!(killed >= 3, "most of them were at work");
    place.succeed("killed", &["--resume"]);
    place.assert_same("whole", "killed");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_a_checkpoint() {
    let place = Place::new(&thick());
    place.succeed("whole", &[]);
    let child = place.start_until("stopped", &[], 20);
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let done = child.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.code() == Some(1) && told.contains("--resume"), "{:?} {told}", done.status);
    assert!(place.lines("stopped") < place.lines("whole"));
    assert!(place.folder("stopped").join("stats.json").exists());
    place.succeed("stopped", &["--resume", "--steps", "60"]);
    assert_eq!(place.lines("stopped"), 61);
    place.succeed("stopped", &["--resume"]);
    place.assert_same("whole", "stopped");
}

#[test]
fn runs_are_not_replaced_or_mixed_up() {
    let place = Place::new(SCENE);
    assert!(
        place
            .refuse("run", &["--resume"])
            .contains("has no checkpoint to resume from; start it with --overwrite")
    );
    place.succeed("run", &["--until", "0.05"]);
    let before = place.content("run");
    assert!(place.refuse("run", &[]).contains("--resume continues it, --overwrite replaces it"));
    place.write(&SCENE.replace("speed = 2.0", "speed = 2.1"));
    assert!(place.refuse("run", &["--resume"]).contains("another scene"));
    assert!(place.content("run") == before, "left as it is");
    // Output may change.
    place.write(&SCENE.replace("checkpoint_interval = 0.03", "checkpoint_interval = 0.01"));
    place.succeed("run", &["--resume", "--until", "0.05"]);
    let checkpoint = place.folder("run").join("checkpoint");
    let mut damaged = std::fs::read(&checkpoint).unwrap();
    damaged[5000] ^= 1;
    std::fs::write(&checkpoint, damaged).unwrap();
    assert!(place.refuse("run", &["--resume"]).contains("damaged"));
    place.succeed("run", &["--overwrite", "--steps", "2"]);
    place.succeed("fresh", &["--steps", "2"]);
    place.assert_same("run", "fresh");
    assert_eq!(place.run("run", &["--overwrite", "--until", "nan"]).status.code(), Some(2));
    assert_eq!(place.run("run", &["--overwrite", "--resume"]).status.code(), Some(2));
}

/// However the second begins; the lock dies with the first.
#[test]
fn two_runs_never_share_a_folder() {
    let place = Place::new(SCENE);
    let mut child = place.start_until("out", &["--threads", "1", "--until", "100"], 40);
    for how in [&[][..], &["--overwrite"], &["--resume"]] {
        let told = place.refuse("out", how);
        assert!(told.contains("out: another run is at work in this folder"), "{how:?}: {told}");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    place.succeed("out", &["--resume"]);
    place.succeed("whole", &[]);
    place.assert_same("whole", "out");
}

#[test]
fn what_a_table_has_lost_is_told() {
    let place = Place::new(
        "version = 1\nparticle_radius = 0.05\nblocks = [{ min = [0, 0, 0], max = [0.3, 0.3, 0.3] }]\n\
         output = { frames_per_second = 0 }\n",
    );
    place.succeed("out", &["--steps", "8"]);
    let path = place.folder("out").join("stats.csv");
    let mut lines: Vec<String> = std::fs::read_to_string(&path).unwrap().lines().map(str::to_owned).collect();
    // As two programs leave it: two rows torn into each other, and one of a step after the checkpoint.
    lines[3] = format!("{}{}", &lines[3][..20], lines[4]);
    lines.push(lines[8].replacen('8', "9", 1));
    std::fs::write(&path, lines.join("\n") + "\n").unwrap();
    let done = place.run("out", &["--resume", "--steps", "10"]);
    let told = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success(), "{told}");
    assert!(told.contains("note       stats.csv: 1 row after the checkpoint removed"), "{told}");
    assert!(told.contains("1 row removed that are damaged or there twice; no row of step 3"), "{told}");
    let steps = place.column("out", "step");
    assert_eq!(steps, [1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
}

/// A higher rate after a resume adds no frames for the time before, a lower one leaves no gap.
#[test]
fn frames_lie_at_multiples_of_their_interval() {
    let scene = |rate: f64| {
        format!(
            "version = 1\nparticle_radius = 0.05\nblocks = [{{ min = [0, 0, 0], max = [0.3, 0.3, 0.3] }}]\n\
             solver.time_step = {{ adaptive = false, initial = 0.002 }}\n\
             output = {{ frames_per_second = {rate}, formats = [], preview = [] }}\n"
        )
    };
    let place = Place::new(&scene(25.0));
    place.succeed("out", &["--until", "0.1"]);
    place.write(&scene(100.0));
    place.succeed("out", &["--resume", "--until", "0.15"]);
    place.write(&scene(10.0));
    place.succeed("out", &["--resume", "--until", "0.35"]);
    let times: Vec<u64> =
        place.column_of("out", "frames.csv", "time").iter().map(|time| (1e3 * time).round() as u64).collect();
    assert_eq!(times, [0, 40, 80, 110, 120, 130, 140, 150, 200, 300]);
}

/// Steps end there, evened out before; the fluid falls faster and faster, so that their lengths vary.
#[test]
fn frames_lie_exactly_at_their_times() {
    let place = Place::new(
        "version = 1\nparticle_radius = 0.05\nblocks = [{ min = [0, 0, 0], max = [0.3, 0.3, 0.3], velocity = [0, -7, \
         0] }]\nsolver.time_step = { max = 0.017, initial = 0.01 }\n\
         output = { frames_per_second = 30.0, formats = [], preview = [] }\n",
    );
    place.succeed("out", &["--until", "0.5"]);
    let times = place.column_of("out", "frames.csv", "time");
    let exact: Vec<f64> = (0..=15).map(|k| f64::from(k) / 30.0).collect();
    assert_eq!(times, exact, "to the last bit");
    let steps = place.column("out", "dt");
    let of_frame = |k: usize| -> Vec<f64> {
        let ends = place.column("out", "time");
        let within = |end: &f64| *end > exact[k] && *end <= exact[k + 1];
        ends.iter().zip(&steps).filter(|(end, _)| within(end)).map(|(_, dt)| *dt).collect()
    };
    for k in 1..15 {
        let steps = of_frame(k);
        let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let most = steps.iter().copied().fold(0.0, f64::max);
        assert!((2..=12).contains(&steps.len()) && least > 0.6 * most, "{k}: {steps:?}");
    }
    // The times of the frames are in the rows of the steps, too.
    let ends = place.column("out", "time");
    assert!(exact[1..].iter().all(|time| ends.contains(time)));
    // Frames closer than steps can be: at the ends of steps, and said.
    place.write(
        "version = 1\nparticle_radius = 0.05\nblocks = [{ min = [0, 0, 0], max = [0.3, 0.3, 0.3] }]\n\
         output = { frames_per_second = 1e5, formats = [], preview = [] }\n",
    );
    let told = String::from_utf8(place.run("dense", &["--steps", "5"]).stderr).unwrap();
    assert!(
        told.contains("note       output.frames_per_second: 100000 frames are more than steps"),
        "{told}"
    );
    assert_eq!(place.column_of("dense", "frames.csv", "time").len(), 6);
}

/// Properties of the vertices of a binary PLY, and their numbers.
fn read_ply(path: &Path) -> (Vec<String>, Vec<Vec<f32>>) {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let names: Vec<String> = header
        .lines()
        .filter_map(|line| Some(line.strip_prefix("property ")?.split(' ').nth(1)?.to_owned()))
        .collect();
    let words = bytes[end..].as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word));
    let words: Vec<f32> = words.collect();
    let rows = words.chunks(names.len()).map(<[f32]>::to_vec).collect();
    (names, rows)
}

/// A tank in coordinates of a country's map, and the same one near the origin.
#[test]
fn places_far_from_the_origin_are_kept() {
    let far = [500_000.0, 0.0, 4_650_000.0];
    let scene = |at: [f64; 3]| {
        let [x, y, z] = at;
        format!(
            "version = 1\nparticle_radius = 0.05\nblocks = [{{ min = [{}, {y}, {}], max = [{}, {}, {}] }}]\n\
             output = {{ frames_per_second = 10, formats = [\"vtu\", \"ply\", \"bgeo\"], preview = [\"png\"] }}\n\
             [[bodies]]\nname = \"tank\"\nmesh = \"tank.obj\"\nbake = {{ invert = true }}\n",
            x - 0.5,
            z - 0.5,
            x + 0.5,
            y + 0.4,
            z + 0.5
        )
    };
    let moved = |line: &str, at: [f64; 3]| match line.strip_prefix("v ") {
        Some(corner) => {
            let parts = corner.split_whitespace().zip(at);
            let parts = parts.map(|(x, at)| format!(" {}", x.parse::<f64>().unwrap() + at));
            format!("v{}\n", parts.collect::<String>())
        }
        None => format!("{line}\n"),
    };
    let tank = |at: [f64; 3]| CUBE.lines().map(|line| moved(line, at)).collect::<String>();
    let up = |[x, y, z]: [f64; 3]| [x, y + 0.5, z];
    let place = Place::new(&scene([0.0; 3]));
    std::fs::write(place.folder("tank.obj"), tank(up([0.0; 3]))).unwrap();
    place.succeed("near", &["--until", "0.1"]);
    place.write(&scene(far));
    std::fs::write(place.folder("tank.obj"), tank(up(far))).unwrap();
    let done = place.run("far", &["--until", "0.1"]);
    let told = String::from_utf8(done.stderr).unwrap();
    assert!(
        done.status.success() && told.contains("note       the scene lies far from the origin"),
        "{told}"
    );
    for frame in ["frame_000000", "frame_000001"] {
        let file = |run: &str, end: &str| place.folder(run).join(format!("particles/{frame}.{end}"));
        let (names, near) = read_ply(&file("near", "ply"));
        let (with_origin, rows) = read_ply(&file("far", "ply"));
        assert_eq!(with_origin[..names.len()], names);
        assert_eq!(with_origin[names.len()..], ["origin_x", "origin_y", "origin_z"]);
        let id = names.iter().position(|name| name == "id").unwrap();
        let by_id = |rows: &[Vec<f32>], origin: bool| {
            let at = |row: &Vec<f32>, axis: usize| {
                let base = if origin { f64::from(row[names.len() + axis]) - far[axis] } else { 0.0 };
                base + f64::from(row[axis])
            };
            let places = rows.iter().map(|row| (row[id].to_bits(), [0, 1, 2].map(|axis| at(row, axis))));
            places.collect::<BTreeMap<u32, [f64; 3]>>()
        };
        let (near, far) = (by_id(&near, false), by_id(&rows, true));
        assert_eq!((near.len(), far.len()), (400, 400));
        // Both runs move alike, up to the rounding of coordinates: a thousandth of a radius, and more after 0.1 s.
        let most = if frame == "frame_000000" { 5e-5 } else { 2e-3 };
        for (id, a) in &near {
            assert!((0..3).all(|axis| (a[axis] - far[id][axis]).abs() < most), "{id}: {a:?} {:?}", far[id]);
        }
        let text = |run: &str| String::from_utf8(std::fs::read(file(run, "vtu")).unwrap()).unwrap();
        assert!(text("near").contains("type=\"Float32\" Name=\"Points\""), "ordinary files stay small");
        assert!(text("far").contains("type=\"Float64\" Name=\"Points\""));
        assert!(text("far").contains("Name=\"origin [m]\""));
    }
    let picture = |run: &str| std::fs::read(place.folder(run).join("pictures/frame_000000.png")).unwrap();
    let [near, far] = ["near", "far"].map(|run| picture_of(&picture(run)));
    let differing = near.iter().zip(&far).filter(|(a, b)| a.abs_diff(**b) > 8).count();
    assert!(differing < near.len() / 200, "{differing} of {} differ", near.len());
}

fn picture_of(file: &[u8]) -> Vec<u8> {
    volmap_figures::picture::png::decode(file).unwrap().1
}

/// A stop in the last step changes nothing.
#[test]
fn a_run_is_done_at_its_end_and_not_before() {
    let place = Place::new(
        "version = 1\nparticle_radius = 0.05\nblocks = [{ min = [0, 0, 0], max = [0.3, 0.3, 0.3] }]\n",
    );
    let settings = RunSettings { steps: Some(3), ..RunSettings::default() };
    let path = place.folder("scene.toml");
    let mut session =
        Session::open(&path, &place.folder("out"), &settings, &Watch::default(), &mut |_| ()).unwrap();
    let stop_after = |step: u64| {
        let watch = Watch::default();
        let cancel = watch.cancel().clone();
        let on_step = move |progress: &Progress| {
            if progress.step.statistics.step == step {
                cancel.cancel();
            }
        };
        (watch, on_step)
    };
    let (watch, mut on_step) = stop_after(2);
    session.run(&watch, &mut on_step).unwrap();
    assert_eq!(session.simulation().steps(), 2);
    assert!(!session.is_done());
    let (watch, mut on_step) = stop_after(3);
    session.run(&watch, &mut on_step).unwrap();
    assert!(session.is_done());
}

/// A map as a body, a mesh as a fill: other content under the same name is another scene.
#[test]
fn changed_maps_and_meshes_are_refused() {
    let scene = |solid: &str| {
        format!(
            "version = 1\nparticle_radius = 0.1\ncache = \"maps\"\nfills = [{{ mesh = \"cube.obj\" }}]\n\
             output = {{ frames_per_second = 0 }}\nbodies = [{{ translation = [0, -2, 0], {solid} }}]\n"
        )
    };
    let place = Place::new(&scene("mesh = \"float.obj\""));
    let [file, other] = ["float.obj", "cube.obj"].map(|name| place.folder(name));
    std::fs::copy(&other, &file).unwrap();
    place.succeed("first", &["--steps", "1"]);
    let mut maps: Vec<PathBuf> =
        std::fs::read_dir(place.folder("maps")).unwrap().map(|entry| entry.unwrap().path()).collect();
    maps.sort();
    let [cube, float] = maps.try_into().unwrap();
    let map = place.folder("float.h5");
    std::fs::copy(&float, &map).unwrap();
    place.write(&scene("map = \"float.h5\""));
    place.succeed("run", &["--steps", "1"]);
    let before = place.content("run");
    // The same shape in another asset: its source is written in it.
    std::fs::copy(&cube, &map).unwrap();
    let told = place.refuse("run", &["--resume", "--steps", "2"]);
    assert!(told.contains("float.h5 has changed since the checkpoint"), "{told}");
    std::fs::copy(&float, &map).unwrap();
    std::fs::write(&other, CUBE.replace("v .5 .5 .5", "v .5 .501 .5")).unwrap();
    let told = place.refuse("run", &["--resume", "--steps", "2"]);
    assert!(told.contains("cube.obj has changed since the checkpoint"), "{told}");
    assert!(place.content("run") == before, "left as it is");
    std::fs::write(&other, CUBE).unwrap();
    place.succeed("run", &["--resume", "--steps", "2"]);
}

#[test]
fn explosions_end_with_their_cause() {
    let given = "adaptive = false\ninitial = 0.5\n[fluid]\nviscosity = 0.01";
    let place = Place::new(&SCENE.replace("max = 0.002", given));
    let viscous = place.refuse("out", &[]);
    assert!(viscous.contains("viscosity") && viscous.contains("time_step.initial"), "{viscous}");
    let text = SCENE.replace("max = 0.002", "adaptive = false\ninitial = 0.5\n[fluid]\nviscosity = 0.0");
    place.write(&text);
    let error = place.refuse("out", &[]);
    assert!(error.contains("the largest speed is") && error.contains("solver.time_step"), "{error}");
    place.write(&SCENE.replace("velocity = [0.5, 0.0, 0.0]", "velocity = [nan, 0.0, 0.0]"));
    assert!(place.refuse("out", &["--overwrite"]).contains("NaN"));
}

/// Two jets leave a domain without bodies: emitted and removed particles add up.
#[test]
fn particles_are_counted() {
    let place = Place::new(
        r#"
        version = 1
        particle_radius = 0.05
        domain = { min = [-1, -1, -1], max = [1, 1, 1] }
        blocks = [{ min = [-0.2, 0.6, -0.2], max = [0.2, 0.8, 0.2] }]
        [[emitters]]
        position = [0.0, 0.3, 0.0]
        direction = [1.0, 0.0, 0.0]
        speed = 4.0
        nozzle = { box = { width = 0.2, height = 0.2 } }
        [[emitters]]
        position = [0.0, 0.0, 0.0]
        direction = [0.0, 0.0, -1.0]
        speed = 3.0
        start = 0.1
        nozzle = { circle = { radius = 0.1 } }
        max_particles = 60
        [output]
        frames_per_second = 0
        [stop]
        time = 0.8
        "#,
    );
    place.succeed("out", &[]);
    let [particles, emitted, removed] =
        ["particles", "emitted", "removed"].map(|column| place.column("out", column));
    let mut count = 4.0 * 4.0 * 2.0;
    for ((particles, emitted), removed) in particles.iter().zip(&emitted).zip(&removed) {
        count += emitted - removed;
        assert_eq!(*particles, count);
    }
    assert!(emitted.iter().sum::<f64>() > 100.0 && removed.iter().sum::<f64>() > 50.0);
    assert!(place.column("out", "time").last().unwrap() >= &0.8);
}

/// A sealed tank that is nine tenths full, and a nozzle in a solid: what there is no room for doesn't come, and is
/// told.
#[test]
fn emitters_stop_where_nothing_fits() {
    let place = Place::new(
        r#"
        version = 1
        particle_radius = 0.05
        blocks = [{ min = [-0.5, 0.0, -0.5], max = [0.5, 0.9, 0.5] }]
        [[emitters]]
        position = [0.0, 0.95, 0.0]
        direction = [0.0, -1.0, 0.0]
        speed = 1.0
        nozzle = { box = { width = 0.6, height = 0.6 } }
        [[emitters]]
        position = [0.0, 0.3, 0.0]
        direction = [0.0, -1.0, 0.0]
        speed = 1.0
        nozzle = { circle = { radius = 0.08 } }
        stop = 0.5
        [[bodies]]
        mesh = "cube.obj"
        bake = { invert = true }
        translation = [0.0, 0.5, 0.0]
        [[bodies]]
        mesh = "cube.obj"
        bake = { scale = 0.3 }
        translation = [0.0, 0.3, 0.0]
        [output]
        frames_per_second = 0
        [stop]
        time = 0.8
        "#,
    );
    let done = place.run("out", &[]);
    let [out, told] = [done.stdout, done.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(out.contains("note       emitters held back"), "{out}{told}");
    assert!(told.contains("100 % of the nozzle lies in a body"), "{told}");
    let [emitted, held, mean] =
        ["emitted", "held", "density_error"].map(|column| place.column("out", column));
    // 100 fill the tank, and some 40 what the small cube leaves of the lattice.
    let [emitted, held] = [emitted, held].map(|counts| counts.iter().sum::<f64>());
    assert!((50.0..200.0).contains(&emitted) && held > 80.0, "{emitted} {held}");
    let most = mean.iter().copied().fold(0.0, f64::max);
    assert!(most < 0.08, "{most}");
}
