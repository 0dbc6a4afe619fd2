//! Interop, reports: headless Chromium opens the page of a real one; jsonschema holds its JSON against the schema.

use std::path::{Path, PathBuf};
use std::process::Command;
use volmap_tests::python;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
fn a_report_opens_in_a_browser_and_keeps_its_schema() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    std::fs::create_dir_all(&folder).unwrap();
    let volmap = || {
        let mut command = Command::new(file("../target/release/volmap"));
        command.current_dir(&folder);
        command
    };
    run(volmap().arg("bake").arg(file("../data/duck.obj")).args(["--resolution", "20"]));
    run(volmap()
        .args(["report", "duck.h5", "--max-error", "5%", "--mesh"])
        .arg(file("../data/duck.obj"))
        .args(["--points", "1000", "--mesh-points", "100"]));
    let validate = "import json, sys, jsonschema\n\
        schema, report = (json.load(open(path)) for path in sys.argv[1:])\n\
        jsonschema.Draft202012Validator.check_schema(schema)\n\
        jsonschema.validate(report, schema, cls=jsonschema.Draft202012Validator)\n\
        del report['verdict']\n\
        assert not jsonschema.Draft202012Validator(schema).is_valid(report)\n";
    run(Command::new(python())
        .args(["-c", validate])
        .arg(file("../baker/report.schema.json"))
        .arg(folder.join("duck.report.json")));
    // Light, dark, phone, print; no request, no overflow, contrast; screenshots stay beside the page.
    let page = folder.join("duck.report.html");
    print!("{}", run(Command::new(python()).arg(file("interop/open_page.py")).arg(page).arg("4")));
}
