//! A batch as JUnit XML, which build servers show: the dialect of Jenkins' JUnit plugin (its `junit-10.xsd`), which
//! GitLab and the reporters of GitHub's actions read too.

use super::summary::{AssetReport, Outcome, Summary};
use std::fmt::Write;
use volmap_figures::page::escape;

/// Class of assets that lie in no folder.
const TOP: &str = "assets";

/// The whole file: a suite with a case for each asset, whose class is its folder.
pub fn junit(summary: &Summary) -> String {
    let counts = summary.counts;
    let numbers = format!(
        "tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" time=\"{}\"",
        summary.assets.len(),
        counts.rejected + counts.doubtful,
        counts.failed,
        counts.not_tried,
        seconds(Some(summary.seconds))
    );
    let name = text(&suite_name(summary));
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    _ = writeln!(out, "<testsuites name=\"volmap\" {numbers}>");
    _ = writeln!(out, "  <testsuite name=\"{name}\" {numbers}>");
    summary.assets.iter().for_each(|asset| case(&mut out, asset));
    out += "  </testsuite>\n</testsuites>\n";
    out
}

fn suite_name(summary: &Summary) -> String {
    let batch = summary.manifest.clone().unwrap_or_else(|| "batch".into());
    match summary.shard {
        Some(shard) => format!("{batch} (part {} of {})", shard.index, shard.count),
        None => batch,
    }
}

fn case(out: &mut String, asset: &AssetReport) {
    let (folder, name) = asset.name.rsplit_once('/').unwrap_or((TOP, &asset.name));
    // Dots part the levels that Jenkins shows.
    let class = folder.replace('.', "_").replace('/', ".");
    _ = writeln!(
        out,
        "    <testcase classname=\"{}\" name=\"{}\" time=\"{}\">",
        text(&class),
        text(name),
        seconds(time(asset))
    );
    properties(out, asset);
    let (message, kind) = (bad_news(asset), text(asset.outcome.name()));
    match asset.outcome {
        Outcome::Built | Outcome::Reused | Outcome::Unchanged => (),
        Outcome::Doubtful | Outcome::Rejected => element(out, "failure", &kind, &message),
        Outcome::Failed => element(out, "error", &kind, &message),
        Outcome::NotTried => _ = writeln!(out, "      <skipped message=\"{}\"/>", text(&message)),
    }
    *out += "    </testcase>\n";
}

/// Time that this run spent on it.
fn time(asset: &AssetReport) -> Option<f64> {
    match asset.outcome {
        Outcome::Unchanged | Outcome::NotTried => None,
        _ => asset.seconds,
    }
}

/// Why it is no good, in full.
fn bad_news(asset: &AssetReport) -> String {
    let mut lines: Vec<&str> = asset.error.as_deref().into_iter().collect();
    lines.extend(asset.failed_gates.iter().map(String::as_str));
    if lines.is_empty() {
        lines.push(&asset.reason);
    }
    lines.join("\n")
}

/// What went wrong: its first line as message, all of it as content.
fn element(out: &mut String, name: &str, kind: &str, message: &str) {
    let first = message.lines().next().unwrap_or("");
    _ = writeln!(out, "      <{name} message=\"{}\" type=\"{kind}\">{}</{name}>", text(first), text(message));
}

/// Key figures of the asset.
fn properties(out: &mut String, asset: &AssetReport) {
    let mut found = vec![("outcome", asset.outcome.name().to_owned()), ("mesh", asset.mesh.clone())];
    if !asset.tags.is_empty() {
        found.push(("tags", asset.tags.join(", ")));
    }
    found.extend(asset.bytes.map(|bytes| ("bytes", bytes.to_string())));
    found.extend(asset.peak_memory.map(|bytes| ("peak_memory_bytes", bytes.to_string())));
    if let Some(figures) = &asset.figures {
        found.push(("triangles", figures.triangles.to_string()));
        found.push(("nodes", figures.nodes.to_string()));
        found.extend(figures.volume_error_max.map(|error| ("volume_error_max", error.to_string())));
        found.extend(figures.warnings.iter().map(|warning| ("warning", warning.clone())));
    }
    *out += "      <properties>\n";
    for (name, value) in found {
        _ = writeln!(out, "        <property name=\"{name}\" value=\"{}\"/>", text(&value));
    }
    *out += "      </properties>\n";
}

fn seconds(time: Option<f64>) -> String {
    format!("{:.3}", time.filter(|time| time.is_finite()).unwrap_or(0.0))
}

/// Text in quotes or between tags, with what XML 1.0 (section 2.2) forbids replaced.
fn text(text: &str) -> String {
    escape(text).replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}").replace('\n', "&#10;").replace('\t', "&#9;")
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{NASTY, asset, batch, mixed};
    use super::*;
    use crate::summary::Shard;
    use quick_xml::XmlVersion;
    use quick_xml::events::Event;
    use std::collections::BTreeMap;

    /// An element: its place (`testsuites/testsuite`), attributes and text.
    type Element = (String, BTreeMap<String, String>, String);

    /// The elements of a document, by an XML reader.
    fn elements(document: &str) -> Vec<Element> {
        let mut reader = quick_xml::Reader::from_str(document);
        reader.config_mut().expand_empty_elements = true;
        let (mut open, mut found) = (Vec::<usize>::new(), Vec::<Element>::new());
        loop {
            match reader.read_event().unwrap() {
                Event::Start(tag) => {
                    let above = open.last().map_or(String::new(), |&at| found[at].0.clone() + "/");
                    let name = tag.name().as_ref().to_owned();
                    let attributes = tag.attributes().map(|pair| {
                        let pair = pair.unwrap();
                        let value = pair.normalized_value(XmlVersion::default()).unwrap();
                        (pair.key.as_ref().to_owned(), value.into_owned())
                    });
                    open.push(found.len());
                    found.push((above + &name, attributes.collect(), String::new()));
                }
                Event::Text(part) => {
                    if let Some(&at) = open.last() {
                        found[at].2 += &*part;
                    }
                }
                Event::GeneralRef(part) => {
                    let entity = format!("&{};", &*part);
                    found[*open.last().unwrap()].2 += &quick_xml::escape::unescape(&entity).unwrap();
                }
                Event::End(_) => _ = open.pop().unwrap(),
                Event::Eof => break,
                _ => (),
            }
        }
        assert_eq!(open, [0; 0]);
        found
    }

    /// Elements whose place ends so.
    fn those<'a>(found: &'a [Element], place: &str) -> Vec<&'a Element> {
        found.iter().filter(|element| element.0.ends_with(place)).collect()
    }

    #[test]
    fn outcomes_are_those_of_build_servers() {
        let found = elements(&junit(&mixed()));
        for place in ["testsuites", "testsuites/testsuite"] {
            let numbers = &found.iter().find(|element| element.0 == place).unwrap().1;
            let number = |name: &str| numbers[name].as_str();
            let counts = ["tests", "failures", "errors", "skipped", "time"].map(number);
            assert_eq!(counts, ["6", "1", "1", "1", "12.500"], "{place}");
        }
        let cases: Vec<[&str; 3]> = those(&found, "/testcase")
            .iter()
            .map(|(_, about, _)| ["classname", "name", "time"].map(|key| about[key].as_str()))
            .collect();
        let expected = [
            ["props.trees", "oak", "1.250"],
            ["assets", "duck", "1.250"],
            ["assets", "tank", "0.000"],
            ["props", "rock", "1.250"],
            ["assets", "bad", "0.000"],
            ["assets", "late", "0.000"],
        ];
        assert_eq!(cases, expected);
        let [failure] = those(&found, "testcase/failure")[..] else { panic!("one was rejected") };
        assert_eq!(failure.1["message"], "the largest error is 0.42 %, more than max_error 0.1 %");
        let [error] = those(&found, "testcase/error")[..] else { panic!("one failed") };
        assert_eq!(error.2, "meshes/bad.obj: line 3: a face needs three corners");
        assert_eq!(those(&found, "testcase/skipped").len(), 1);
    }

    #[test]
    fn figures_are_properties() {
        let found = elements(&junit(&batch(vec![asset(0, "duck")])));
        let list: Vec<(&str, &str)> = those(&found, "testcase/properties/property")
            .iter()
            .map(|(_, about, _)| (about["name"].as_str(), about["value"].as_str()))
            .collect();
        for pair in
            [("outcome", "built"), ("bytes", "45600"), ("volume_error_max", "0.0042"), ("tags", "props")]
        {
            assert!(list.contains(&pair), "{pair:?} in {list:?}");
        }
    }

    #[test]
    fn text_of_files_is_never_markup() {
        let fill = |text: &str| {
            let mut summary = mixed();
            summary.manifest = Some(text.into());
            summary.shard = Some(Shard { index: 1, count: 2 });
            for asset in &mut summary.assets {
                asset.name = format!("v1.2/{}", text.replace('/', "|"));
                asset.mesh = text.into();
                asset.tags = vec![text.into()];
                asset.reason = text.into();
                asset.error = Some(text.into());
                asset.failed_gates = vec![text.into()];
                asset.figures = asset.figures.take().map(|mut figures| {
                    figures.warnings = vec![text.into()];
                    figures
                });
            }
            junit(&summary)
        };
        let document = fill(NASTY);
        let allowed = |c: char| matches!(c, '\n' | ' '..='\u{7e}' | '\u{a0}'..='\u{fffd}' | '\u{10000}'..);
        assert!(document.chars().all(allowed));
        let (found, plain) = (elements(&document), elements(&fill("harmless")));
        let places = |found: &[Element]| found.iter().map(|element| element.0.clone()).collect::<Vec<_>>();
        assert_eq!(places(&found), places(&plain));
        let shown = NASTY.replace(['\u{202e}', '\0', '\u{1b}', '\u{fffe}'], "\u{fffd}");
        let case = &those(&found, "/testcase")[0].1;
        assert_eq!((case["classname"].as_str(), &case["name"]), ("v1_2", &shown.replace('/', "|")));
        let error = those(&found, "testcase/error")[0];
        assert_eq!(error.2, format!("{shown}\n{shown}"));
        assert_eq!(error.1["message"], shown.lines().next().unwrap());
    }
}
