//! A batch in lines of a log: for people, and as JSON lines for programs.

use super::summary::{AssetReport, Counts, Outcome, Summary};
use serde::Serialize;
use serde_json::json;
use std::path::Path;
use volmap_formats::text::{bytes, duration, number, percent, printable_line};

/// An asset and its outcome in a line, and below it a line for each warning of its bake.
pub fn lines(asset: &AssetReport) -> String {
    let warnings =
        warnings(asset).iter().map(|warning| printable_line(&format!("{:<10} warning: {warning}", "")));
    [line(asset)].into_iter().chain(warnings).collect::<Vec<_>>().join("\n")
}

/// What the bake warned of.
pub fn warnings(asset: &AssetReport) -> &[String] {
    asset.figures.as_ref().map_or(&[], |figures| &figures.warnings)
}

/// An asset and its outcome in a line.
pub fn line(asset: &AssetReport) -> String {
    let mut facts: Vec<String> = asset.bytes.map(bytes).into_iter().collect();
    let error = asset.figures.as_ref().and_then(|figures| figures.volume_error_max);
    facts.extend(error.map(|error| format!("error {} of the ball", percent(error))));
    // Of what wasn't baked, the time is that of another day.
    let baked = !matches!(asset.outcome, Outcome::Unchanged | Outcome::NotTried);
    facts.extend(asset.seconds.filter(|_| baked).map(|seconds| format!("{} s", number(seconds))));
    let warnings = warnings(asset).len();
    facts.extend((warnings > 0).then(|| counted_as(warnings, "warning", "warnings")));
    let is_bad = asset.error.is_some() || !asset.failed_gates.is_empty();
    let why = if is_bad { why(asset) } else { format!("({})", asset.reason) };
    let said = match (facts.is_empty(), is_bad) {
        (true, _) => why,
        (false, true) => format!("{}; {why}", facts.join(", ")),
        (false, false) => format!("{} {why}", facts.join(", ")),
    };
    printable_line(&format!("{:<10} {}: {said}", asset.outcome.name(), asset.name))
}

/// The error, the gates or the reason: the first that there is.
pub fn why(asset: &AssetReport) -> String {
    match (&asset.error, &asset.failed_gates[..]) {
        (Some(error), _) => error.clone(),
        (None, []) => asset.reason.clone(),
        (None, gates) => gates.join("; "),
    }
}

#[derive(Serialize)]
struct Event<'a> {
    event: &'static str,
    #[serde(flatten)]
    asset: &'a AssetReport,
}

/// The same as a JSON object: `"event": "asset"` and the fields of the summary's asset.
pub fn json_line(asset: &AssetReport) -> String {
    let event = Event { event: "asset", asset };
    serde_json::to_string(&event).expect("names are texts, and numbers that are none are null")
}

/// The end of a log as a JSON object: `"event": "summary"`, counts and time.
pub fn json_closing(summary: &Summary) -> String {
    let Summary { counts, interrupted, seconds, notes, left_out, .. } = summary;
    json!({
        "event": "summary", "counts": counts, "interrupted": interrupted, "seconds": seconds, "notes": notes,
        "left_out": left_out
    })
    .to_string()
}

/// Bad assets that the end of a log repeats.
const REPEATED: usize = 10;

/// The end of a log: the bad assets once more, how many came out how, the time, and where things lie.
pub fn closing(summary: &Summary, folder: &Path) -> String {
    let bad = |asset: &&AssetReport| asset.outcome.is_bad();
    let bad: Vec<&AssetReport> = summary.assets.iter().filter(bad).collect();
    let mut lines: Vec<String> = bad.iter().take(REPEATED).map(|asset| line(asset)).collect();
    if bad.len() > REPEATED {
        lines.push(format!("{:<10} and {} more, see summary.html", "", bad.len() - REPEATED));
    }
    lines.extend(summary.notes.iter().map(|note| printable_line(&format!("note       {note}"))));
    let stopped = if summary.interrupted { "; stopped before its end" } else { "" };
    lines.push(match summary.assets.len() {
        0 => "assets     none".into(),
        all => format!("assets     {all}: {}{stopped}", counted(&summary.counts)),
    });
    let left_out =
        summary.left_out.iter().map(|files| printable_line(&format!("left out   {}", files.told())));
    lines.extend(left_out);
    lines.extend(warned(summary).map(|warned| format!("warnings   {warned}")));
    let jobs = counted_as(summary.jobs, "job", "jobs");
    let threads = counted_as(summary.threads, "thread", "threads");
    lines.push(format!("time       {}, {jobs} on {threads}", duration(summary.seconds)));
    lines.push(printable_line(&format!("written    {}", folder.display())));
    lines.join("\n")
}

/// `5 in 3 assets`; none if there are none.
pub fn warned(summary: &Summary) -> Option<String> {
    let counts = || summary.assets.iter().map(|asset| warnings(asset).len()).filter(|count| *count > 0);
    let (all, assets) = (counts().sum::<usize>(), counts().count());
    (all > 0).then(|| format!("{all} in {}", counted_as(assets, "asset", "assets")))
}

/// `1 job`, `2 jobs`.
pub fn counted_as(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// `9 built, 2 unchanged, 1 failed`.
pub fn counted(counts: &Counts) -> String {
    let some = counts.by_outcome().into_iter().filter(|(_, count)| *count > 0);
    some.map(|(outcome, count)| format!("{count} {}", outcome.name())).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{NASTY, asset, batch, mixed};
    use super::*;

    #[test]
    fn a_line_says_what_came_of_an_asset() {
        let lines: Vec<String> = mixed().assets.iter().map(line).collect();
        let expected = [
            "built      props/trees/oak: 45.6 kB, error 0.42 % of the ball, 1.25 s (new)",
            "reused     duck: 45.6 kB, error 0.42 % of the ball, 1.25 s (new)",
            "unchanged  tank: 45.6 kB, error 0.42 % of the ball (new)",
            "rejected   props/rock: 45.6 kB, error 0.42 % of the ball, 1.25 s; the largest error is 0.42 %, more than \
             max_error 0.1 %",
            "failed     bad: meshes/bad.obj: line 3: a face needs three corners",
            "not tried  late: (new)",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn warnings_follow_with_their_count() {
        let mut warned = mixed();
        let figures = warned.assets[0].figures.as_mut().unwrap();
        figures.warnings = vec!["the mesh is open".into(), NASTY.into()];
        let text = lines(&warned.assets[0]);
        let found: Vec<&str> = text.lines().collect();
        assert_eq!(
            found[0],
            "built      props/trees/oak: 45.6 kB, error 0.42 % of the ball, 1.25 s, 2 warnings (new)"
        );
        assert_eq!((found[1], found.len()), ("           warning: the mesh is open", 3));
        assert!(closing(&warned, Path::new("baked")).contains("\nwarnings   2 in 1 asset\n"));
        assert!(!closing(&mixed(), Path::new("baked")).contains("warnings"));
    }

    #[test]
    fn a_name_stays_in_its_line() {
        let nasty = AssetReport { name: NASTY.into(), error: Some(NASTY.into()), ..asset(0, "") };
        for line in [line(&nasty), json_line(&nasty)] {
            assert!(!line.contains(['\n', '\0', '\u{1b}']), "{line:?}");
        }
    }

    #[test]
    fn json_lines_hold_the_whole_report() {
        for asset in mixed().assets {
            let mut json: serde_json::Value = serde_json::from_str(&json_line(&asset)).unwrap();
            assert_eq!(json.as_object_mut().unwrap().remove("event").unwrap(), "asset");
            assert_eq!(serde_json::from_value::<AssetReport>(json).unwrap(), asset);
        }
    }

    #[test]
    fn the_end_counts_and_repeats_what_is_bad() {
        let text = closing(&mixed(), Path::new("baked"));
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            lines[0].starts_with("rejected   props/rock: ") && lines[1].starts_with("failed     bad: "),
            "{text}"
        );
        let counts = "6: 1 built, 1 reused, 1 unchanged, 1 rejected, 1 failed, 1 not tried";
        assert_eq!(lines[2], format!("assets     {counts}; stopped before its end"));
        assert_eq!(lines[3..], ["time       12.5 s, 2 jobs on 2 threads", "written    baked"]);
        let many = (0..25).map(|n| AssetReport { outcome: Outcome::Failed, ..asset(n, "x") }).collect();
        let text = closing(&batch(many), Path::new("."));
        assert!(
            text.contains("and 15 more, see summary.html") && text.contains("assets     25: 25 failed\n")
        );
        assert!(closing(&batch(Vec::new()), Path::new(".")).starts_with("assets     none\n"));
    }
}
