//! A batch of every outcome, for tests.

use super::summary::{AssetReport, Counts, Figures, Outcome, SUMMARY_VERSION, Summary};

/// What text from files may hold.
pub const NASTY: &str =
    "<script>alert(1)</script>\" onload='x' &amp; ]]> Größe\u{202e}\0\u{1b}[31m\n\u{fffe}";

/// An asset that came out well.
pub fn asset(position: usize, name: &str) -> AssetReport {
    AssetReport {
        position,
        name: name.into(),
        mesh: format!("meshes/{name}.obj"),
        output: format!("{name}.h5"),
        tags: vec!["props".into()],
        outcome: Outcome::Built,
        reason: "new".into(),
        error: None,
        failed_gates: Vec::new(),
        identity: None,
        estimated_seconds: Some(1.0),
        seconds: Some(1.25),
        threads: Some(1),
        peak_memory: Some(300_000_000),
        bytes: Some(45_600),
        file_blake3: None,
        figures: Some(Figures {
            triangles: 1200,
            closed: true,
            support_radius: 0.1,
            cell_size: 0.1,
            band_cells: 800,
            nodes: 7000,
            volume_error_max: Some(0.0042),
            volume_error_rms: Some(0.0007),
            volume_error_points: 1000,
            has_solid: true,
            sign_doubt: 0.0,
            warnings: Vec::new(),
        }),
        preview: None,
        report: None,
    }
}

/// A batch with these assets.
pub fn batch(assets: Vec<AssetReport>) -> Summary {
    Summary {
        version: SUMMARY_VERSION,
        program_version: "0.1.0".into(),
        manifest: Some("assets.toml".into()),
        shard: None,
        tags: Vec::new(),
        interrupted: false,
        counts: Counts::of(&assets),
        seconds: 12.5,
        jobs: 2,
        threads: 2,
        notes: Vec::new(),
        left_out: Vec::new(),
        unreadable: Vec::new(),
        leftovers: Vec::new(),
        plan: String::new(),
        assets,
    }
}

/// Six assets, one of each outcome.
pub fn mixed() -> Summary {
    let outcome = |position, name: &str, outcome| AssetReport { outcome, ..asset(position, name) };
    let unbaked = |position, name: &str, kind| AssetReport {
        seconds: None,
        bytes: None,
        figures: None,
        peak_memory: None,
        ..outcome(position, name, kind)
    };
    let mut summary = batch(vec![
        asset(0, "props/trees/oak"),
        outcome(1, "duck", Outcome::Reused),
        outcome(2, "tank", Outcome::Unchanged),
        AssetReport {
            failed_gates: vec!["the largest error is 0.42 %, more than max_error 0.1 %".into()],
            ..outcome(3, "props/rock", Outcome::Rejected)
        },
        AssetReport {
            error: Some("meshes/bad.obj: line 3: a face needs three corners".into()),
            tags: vec!["props".into(), "wip".into()],
            ..unbaked(4, "bad", Outcome::Failed)
        },
        unbaked(5, "late", Outcome::NotTried),
    ]);
    summary.interrupted = true;
    summary
}
