//! A batch as a page: `summary.html`.

use super::left_out::LeftOut;
use super::log::{counted, counted_as, warned, warnings, why};
use super::summary::{AssetReport, Outcome, Summary};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path};
use volmap_figures::page::{self, Block, Cell, Column, Link, Page, Section, Table, Verdict};
use volmap_figures::picture::png;
use volmap_formats::text::{bytes, duration, number, percent};

/// Larger pictures are left out, bytes.
const LARGEST_PREVIEW: u64 = 1 << 18;

/// Above the table of assets.
const LEGEND: &str = "Error: the largest of the volume, % of the full ball. Blue: the solid. Orange: a container, seen \
                      from inside without its near walls. Click a column heading to sort.";

/// The page of a batch whose output is in `folder`, where it takes the previews from.
pub fn page(summary: &Summary, folder: &Path) -> Page {
    let first = bad(summary).into_iter().chain(left_out(summary)).chain(notes(summary));
    let mut sections: Vec<Section> = first.collect();
    let blocks = vec![Block::Paragraph(LEGEND.into()), Block::Table(assets(summary, folder))];
    sections.push(Section { title: "Assets".into(), blocks });
    sections.push(totals(summary));
    let name = summary.manifest.as_deref().map_or("meshes", file_name);
    Page {
        title: format!("Batch of {name}"),
        subtitle: subtitle(summary),
        verdict: verdict(summary),
        sections,
        footer: format!("volmap {}, volmap batch", summary.program_version),
        refresh: None,
    }
}

/// A batch that is at work.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Running {
    /// Positions of the assets that are in work.
    pub in_work: BTreeSet<usize>,
    /// Estimated time that is left, seconds; none if nothing is estimated yet.
    pub seconds_left: Option<f64>,
}

/// How often a browser reads the page of a batch that is at work again, seconds.
const REFRESH: u32 = 10;

/// The same of a batch that is at work: what is not tried yet is to do, or in work.
pub fn page_of_running(summary: &Summary, running: &Running, folder: &Path) -> Page {
    let mut shown = summary.clone();
    let is_open = |asset: &AssetReport| asset.outcome == Outcome::NotTried;
    for asset in shown.assets.iter_mut().filter(|asset| is_open(asset)) {
        asset.reason = if running.in_work.contains(&asset.position) { "in work" } else { "to do" }.into();
    }
    let (all, open) = (shown.assets.len(), shown.assets.iter().filter(|asset| is_open(asset)).count());
    let mut page = page(&shown, folder);
    let in_work = running.in_work.len();
    let left = running.seconds_left.map(|left| format!("; about {} left", duration(left)));
    page.verdict = Verdict {
        outcome: page::Outcome::None,
        headline: format!("At work: {} of {all} done", all - open),
        text: format!(
            "{in_work} in work, {} to do{}. The page is written anew whenever an asset is begun or done.",
            open.saturating_sub(in_work),
            left.unwrap_or_default()
        ),
        ..page.verdict
    };
    page.refresh = Some(REFRESH);
    page
}

fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

fn subtitle(summary: &Summary) -> String {
    let part = summary.shard.map(|shard| format!("part {} of {}, ", shard.index, shard.count));
    format!(
        "{}{}, {}, {}",
        part.unwrap_or_default(),
        counted_as(summary.jobs, "job", "jobs"),
        counted_as(summary.threads, "thread", "threads"),
        duration(summary.seconds)
    )
}

fn is_good(asset: &AssetReport) -> bool {
    asset.outcome.is_good()
}

fn verdict(summary: &Summary) -> Verdict {
    let assets = &summary.assets;
    let good = assets.iter().filter(|asset| is_good(asset)).count();
    let mut text = match assets.len() {
        0 => "There are no assets.".into(),
        all if all == good => format!("All {all} assets are good: {}.", counted(&summary.counts)),
        all => format!("{good} of {all} assets are good: {}.", counted(&summary.counts)),
    };
    if summary.interrupted {
        text += " The batch was stopped before its end.";
    }
    let passed = summary.is_good() && !summary.interrupted;
    let mut figures = vec![("good".to_owned(), format!("{good} of {}", assets.len()))];
    let size: u64 = assets.iter().filter(|asset| is_good(asset)).filter_map(|asset| asset.bytes).sum();
    figures.push(("size of good assets".into(), bytes(size)));
    if let Some(worst) = assets.iter().filter(|asset| is_good(asset)).filter_map(error).reduce(f64::max) {
        figures.push(("largest error among good assets".into(), percent(worst)));
    }
    figures.extend(warned(summary).map(|warned| ("warnings".to_owned(), warned)));
    figures.push(("wall time".into(), duration(summary.seconds)));
    let outcome = if passed { page::Outcome::Pass } else { page::Outcome::Fail };
    Verdict { outcome, text, figures, ..Verdict::default() }
}

/// Largest error of the volume, as a part of the full ball.
fn error(asset: &AssetReport) -> Option<f64> {
    asset.figures.as_ref()?.volume_error_max
}

/// What failed, what was rejected and what is doubtful, with causes.
fn bad(summary: &Summary) -> Option<Section> {
    let of = |outcome| summary.assets.iter().filter(move |asset| asset.outcome == outcome);
    let row = |asset: &AssetReport| {
        vec![Cell::text(asset.name.clone()), Cell::text(why(asset)), Cell::text(asset.outcome.name())]
    };
    let bad = of(Outcome::Failed).chain(of(Outcome::Rejected)).chain(of(Outcome::Doubtful));
    let rows: Vec<Vec<Cell>> = bad.map(row).collect();
    let columns = vec![Column::sentences("asset"), Column::sentences("cause"), Column::text("outcome")];
    let title = "Failed, rejected and doubtful".into();
    let table = Table { caption: String::new(), columns, rows };
    (!table.rows.is_empty()).then(|| Section { title, blocks: vec![Block::Table(table)] })
}

/// Files that aren't read.
fn left_out(summary: &Summary) -> Option<Section> {
    let row = |files: &LeftOut| {
        let count = files.files.len();
        vec![
            Cell::text(files.format.clone()),
            Cell::written(count.to_string(), count as f64),
            Cell::text(files.files.join(", ")),
            Cell::text(files.cure.clone()),
        ]
    };
    let columns = vec![
        Column::text("format"),
        Column::number("files"),
        Column::sentences("names"),
        Column::sentences("how to convert them"),
    ];
    let table = Table { caption: String::new(), columns, rows: summary.left_out.iter().map(row).collect() };
    let title = "Left out: files that aren't read".into();
    (!table.rows.is_empty()).then(|| Section { title, blocks: vec![Block::Table(table)] })
}

fn notes(summary: &Summary) -> Option<Section> {
    let blocks = vec![Block::List(summary.notes.clone())];
    (!summary.notes.is_empty()).then(|| Section { title: "Notes".into(), blocks })
}

/// A row an asset.
fn assets(summary: &Summary, folder: &Path) -> Table {
    Table {
        caption: String::new(),
        columns: vec![
            Column::text("asset"),
            Column::text("outcome"),
            Column::sentences("warnings"),
            Column::sentences("why"),
            Column::number("error, %"),
            Column::number("size"),
            Column::number("time, s"),
            Column::number("memory"),
            Column::text("tags"),
        ],
        rows: summary.assets.iter().map(|asset| row(asset, folder)).collect(),
    }
}

fn row(asset: &AssetReport, folder: &Path) -> Vec<Cell> {
    let size = |n: Option<u64>| n.map_or(Cell::default(), |n| Cell::written(bytes(n), n as f64));
    let number = |x: Option<f64>| x.map_or(Cell::default(), Cell::number);
    let name = Cell {
        link: asset.report.as_deref().and_then(Link::new),
        thumbnail: asset.preview.as_deref().and_then(|path| preview(folder, path)),
        ..Cell::text(asset.name.clone())
    };
    vec![
        name,
        Cell::text(asset.outcome.name()),
        Cell::text(numbered(warnings(asset))),
        Cell::text(why(asset)),
        number(error(asset).map(|error| 100.0 * error)),
        size(asset.bytes),
        number(asset.seconds),
        size(asset.peak_memory),
        Cell::text(asset.tags.join(", ")),
    ]
}

/// `2: this; that`; empty for none.
fn numbered(warnings: &[String]) -> String {
    if warnings.is_empty() { String::new() } else { format!("{}: {}", warnings.len(), warnings.join("; ")) }
}

/// A picture in the folder, if it is one.
fn preview(folder: &Path, path: &str) -> Option<Vec<u8>> {
    // A summary may come from elsewhere: it doesn't get to show other files.
    let path = Path::new(path);
    if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
        return None;
    }
    let file = File::open(folder.join(path)).ok()?;
    let mut content = Vec::new();
    file.take(LARGEST_PREVIEW + 1).read_to_end(&mut content).ok()?;
    (content.len() as u64 <= LARGEST_PREVIEW && png::size(&content).is_some()).then_some(content)
}

/// Assets, bytes and seconds of a group.
#[derive(Clone, Copy, Default)]
struct Sum {
    assets: usize,
    good: usize,
    bytes: u64,
    seconds: f64,
}

impl Sum {
    fn add(&mut self, asset: &AssetReport) {
        self.assets += 1;
        self.good += usize::from(is_good(asset));
        self.bytes += asset.bytes.unwrap_or(0);
        self.seconds += asset.seconds.unwrap_or(0.0);
    }
}

fn totals(summary: &Summary) -> Section {
    let mut blocks = vec![Block::Table(by_outcome(summary))];
    blocks.extend(by_tag(summary).map(Block::Table));
    let slow = |asset: &AssetReport| asset.seconds;
    let large = |asset: &AssetReport| asset.bytes.map(|n| n as f64);
    blocks.extend(top(summary, "Slowest", slow, |x| format!("{} s", number(x))));
    blocks.extend(top(summary, "Largest", large, |x| bytes(x as u64)));
    Section { title: "Totals".into(), blocks }
}

fn by_outcome(summary: &Summary) -> Table {
    let row = |(outcome, count): (Outcome, usize)| {
        let mut sum = Sum::default();
        summary.assets.iter().filter(|asset| asset.outcome == outcome).for_each(|asset| sum.add(asset));
        let counted = Cell::written(count.to_string(), count as f64);
        vec![
            Cell::text(outcome.name()),
            counted,
            Cell::written(bytes(sum.bytes), sum.bytes as f64),
            Cell::number(sum.seconds),
        ]
    };
    Table {
        caption: "By outcome".into(),
        columns: vec![
            Column::text("outcome"),
            Column::number("assets"),
            Column::number("size"),
            Column::number("time, s"),
        ],
        rows: summary.counts.by_outcome().into_iter().filter(|(_, count)| *count > 0).map(row).collect(),
    }
}

fn by_tag(summary: &Summary) -> Option<Table> {
    let mut sums: BTreeMap<&str, Sum> = BTreeMap::new();
    for asset in &summary.assets {
        asset.tags.iter().for_each(|tag| sums.entry(tag).or_default().add(asset));
    }
    let row = |(tag, sum): (&&str, &Sum)| {
        vec![
            Cell::text(*tag),
            Cell::written(sum.assets.to_string(), sum.assets as f64),
            Cell::written(sum.good.to_string(), sum.good as f64),
            Cell::written(bytes(sum.bytes), sum.bytes as f64),
            Cell::number(sum.seconds),
        ]
    };
    let columns = vec![
        Column::text("tag"),
        Column::number("assets"),
        Column::number("good"),
        Column::number("size"),
        Column::number("time, s"),
    ];
    let rows: Vec<Vec<Cell>> = sums.iter().map(row).collect();
    (!rows.is_empty()).then(|| Table { caption: "By tag".into(), columns, rows })
}

/// How many are named as the slowest and the largest.
const TOP: usize = 5;

/// Those with the largest numbers, for who reads it on paper.
fn top(
    summary: &Summary,
    title: &str,
    value: impl Fn(&AssetReport) -> Option<f64>,
    written: impl Fn(f64) -> String,
) -> Option<Block> {
    let mut found: Vec<(f64, &str)> =
        summary.assets.iter().filter_map(|asset| Some((value(asset)?, asset.name.as_str()))).collect();
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let list: Vec<String> =
        found.iter().take(TOP).map(|(x, name)| format!("{name} ({})", written(*x))).collect();
    (!list.is_empty()).then(|| Block::Paragraph(format!("{title}: {}.", list.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{NASTY, asset, batch, mixed};
    use super::*;
    use std::fs;
    use volmap_figures::picture::png::{Effort, encode};

    /// The table of assets of a page.
    fn table(page: &Page) -> &Table {
        let section = page.sections.iter().find(|section| section.title == "Assets").unwrap();
        let [_, Block::Table(table)] = &section.blocks[..] else { panic!("a legend and a table") };
        table
    }

    #[test]
    fn what_is_bad_comes_first() {
        let page = page(&mixed(), Path::new("none"));
        assert_eq!(page.verdict.outcome, page::Outcome::Fail);
        assert!(page.verdict.text.starts_with("3 of 6 assets are good: 1 built"), "{}", page.verdict.text);
        let titles: Vec<&str> = page.sections.iter().map(|section| section.title.as_str()).collect();
        assert_eq!(titles, ["Failed, rejected and doubtful", "Assets", "Totals"]);
        let [Block::Table(bad)] = &page.sections[0].blocks[..] else { panic!("a table") };
        let said: Vec<[&str; 2]> = bad.rows.iter().map(|row| [&*row[0].text, &*row[1].text]).collect();
        assert_eq!(said[0], ["bad", "meshes/bad.obj: line 3: a face needs three corners"]);
        assert_eq!(said[1], ["props/rock", "the largest error is 0.42 %, more than max_error 0.1 %"]);
        let rows = &table(&page).rows;
        let names: Vec<&str> = rows.iter().map(|row| row[0].text.as_str()).collect();
        assert_eq!(names, ["props/trees/oak", "duck", "tank", "props/rock", "bad", "late"]);
        assert!(rows.iter().all(|row| row.len() == table(&page).columns.len()));
    }

    #[test]
    fn warnings_stand_early_with_their_count() {
        let mut warned = mixed();
        warned.assets[1].figures.as_mut().unwrap().warnings =
            vec!["the mesh is open".into(), "no solid".into()];
        let page = page(&warned, Path::new("none"));
        assert_eq!(table(&page).columns[2].name, "warnings");
        assert_eq!(table(&page).rows[1][2].text, "2: the mesh is open; no solid");
        assert!(page.verdict.figures.contains(&("warnings".into(), "2 in 1 asset".into())));
    }

    #[test]
    fn a_doubtful_asset_is_not_good() {
        let gates = vec!["must_have_solid: no node lies inside".to_owned()];
        let doubtful = AssetReport { outcome: Outcome::Doubtful, failed_gates: gates, ..asset(0, "sheet") };
        let page = page(&batch(vec![doubtful]), Path::new("none"));
        assert_eq!(page.verdict.outcome, page::Outcome::Fail);
        assert_eq!(page.verdict.text, "0 of 1 assets are good: 1 doubtful.");
        let [Block::Table(bad)] = &page.sections[0].blocks[..] else { panic!("a table") };
        assert_eq!(
            [&*bad.rows[0][1].text, &*bad.rows[0][2].text],
            ["must_have_solid: no node lies inside", "doubtful"]
        );
    }

    #[test]
    fn a_batch_at_work_shows_what_is_to_do() {
        let running = Running { in_work: [5].into(), seconds_left: Some(90.0) };
        let mut summary = mixed();
        summary.interrupted = false;
        summary.assets.push(AssetReport { position: 6, name: "last".into(), ..summary.assets[5].clone() });
        let page = page_of_running(&summary, &running, Path::new("none"));
        assert_eq!(
            (page.verdict.outcome, &*page.verdict.headline),
            (page::Outcome::None, "At work: 5 of 7 done")
        );
        assert!(
            page.verdict.text.starts_with("1 in work, 1 to do; about 1 min 30 s left"),
            "{}",
            page.verdict.text
        );
        let why: Vec<&str> = table(&page).rows[5..].iter().map(|row| row[3].text.as_str()).collect();
        assert_eq!(why, ["in work", "to do"]);
        assert!(page.to_html().contains("<meta http-equiv=\"refresh\" content=\"10\">"));
        assert!(!super::page(&summary, Path::new("none")).to_html().contains("refresh"));
    }

    #[test]
    fn all_good_passes_and_sums_are_sums() {
        let mut assets: Vec<AssetReport> = (0..4).map(|n| asset(n, &format!("a{n}"))).collect();
        assets[2].bytes = Some(20_000_000);
        assets[3].tags = vec!["hero".into(), "props".into()];
        let page = page(&batch(assets), Path::new("none"));
        assert_eq!(page.verdict.outcome, page::Outcome::Pass);
        assert!(page.verdict.figures.contains(&("size of good assets".into(), "20.1 MB".into())));
        assert!(page.verdict.figures.contains(&("largest error among good assets".into(), "0.42 %".into())));
        let totals = &page.sections.last().unwrap().blocks;
        let [Block::Table(outcomes), Block::Table(tags), Block::Paragraph(_), Block::Paragraph(largest)] =
            &totals[..]
        else {
            panic!("two tables and two lines")
        };
        assert_eq!(outcomes.rows.len(), 1);
        assert_eq!(outcomes.rows[0][3].value, Some(5.0));
        let counts: Vec<(&str, Option<f64>)> =
            tags.rows.iter().map(|row| (row[0].text.as_str(), row[1].value)).collect();
        assert_eq!(counts, [("hero", Some(1.0)), ("props", Some(4.0))]);
        assert!(largest.starts_with("Largest: a2 (20.0 MB), a0 (45.6 kB)"), "{largest}");
    }

    #[test]
    fn an_empty_batch_has_a_page() {
        let page = page(&batch(Vec::new()), Path::new("none"));
        assert_eq!(page.verdict.text, "There are no assets.");
        assert!(page.to_html().contains("Totals"));
    }

    #[test]
    fn pictures_are_embedded_from_the_folder_alone() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("baked");
        fs::create_dir_all(folder.join("preview")).unwrap();
        let picture = encode([2, 1], &[1, 2, 3, 4, 5, 6], Effort::Fast);
        for path in ["secret.png", "baked/preview/a.png"] {
            fs::write(root.path().join(path), &picture).unwrap();
        }
        fs::write(folder.join("preview/text.png"), "no picture, but long enough for a head").unwrap();
        fs::write(folder.join("preview/large.png"), [&picture[..], &[0; LARGEST_PREVIEW as usize]].concat())
            .unwrap();
        assert_eq!(preview(&folder, "preview/a.png"), Some(picture));
        let secret = root.path().join("secret.png").display().to_string();
        for path in
            ["../secret.png", &secret, "preview/text.png", "preview/large.png", "preview/none.png", "preview"]
        {
            assert_eq!(preview(&folder, path), None, "{path}");
        }
    }

    #[test]
    fn text_of_files_is_never_markup() {
        let mut summary = mixed();
        summary.notes = vec![NASTY.into()];
        for asset in &mut summary.assets {
            asset.name = NASTY.into();
            asset.report = Some(format!("report/{NASTY}.html"));
            asset.error = Some(NASTY.into());
            asset.tags = vec![NASTY.into()];
        }
        summary.manifest = Some(NASTY.into());
        let html = page(&summary, Path::new("none")).to_html();
        assert_eq!(html.matches("<script").count(), 1);
        assert!(!html.contains("onload='") && !html.contains(['\0', '\u{202e}', '\u{1b}']));
        assert_eq!(html.matches("<a href=\"./report/%3Cscript").count(), 6);
    }
}
