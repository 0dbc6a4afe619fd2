//! A batch as a page: `summary.html`.

use super::log::{counted, counted_as, why};
use super::summary::{AssetReport, Outcome, Summary};
use std::collections::BTreeMap;
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
    let mut sections: Vec<Section> = bad(summary).into_iter().chain(notes(summary)).collect();
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
    }
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
    matches!(asset.outcome, Outcome::Built | Outcome::Reused | Outcome::Unchanged)
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
    figures.push(("wall time".into(), duration(summary.seconds)));
    let outcome = if passed { page::Outcome::Pass } else { page::Outcome::Fail };
    Verdict { outcome, text, figures, ..Verdict::default() }
}

/// Largest error of the volume, as a part of the full ball.
fn error(asset: &AssetReport) -> Option<f64> {
    asset.figures.as_ref()?.volume_error_max
}

/// What failed and what was rejected, with causes.
fn bad(summary: &Summary) -> Option<Section> {
    let of = |outcome| summary.assets.iter().filter(move |asset| asset.outcome == outcome);
    let row = |asset: &AssetReport| {
        vec![Cell::text(asset.name.clone()), Cell::text(why(asset)), Cell::text(asset.outcome.name())]
    };
    let rows: Vec<Vec<Cell>> = of(Outcome::Failed).chain(of(Outcome::Rejected)).map(row).collect();
    let columns = vec![Column::sentences("asset"), Column::sentences("cause"), Column::text("outcome")];
    let title = "Failed and rejected".into();
    let table = Table { caption: String::new(), columns, rows };
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
            Column::number("size"),
            Column::number("error, %"),
            Column::number("time, s"),
            Column::number("memory"),
            Column::text("tags"),
            Column::sentences("why"),
            Column::sentences("warnings"),
        ],
        rows: summary.assets.iter().map(|asset| row(asset, folder)).collect(),
    }
}

fn row(asset: &AssetReport, folder: &Path) -> Vec<Cell> {
    let size = |n: Option<u64>| n.map_or(Cell::default(), |n| Cell::written(bytes(n), n as f64));
    let number = |x: Option<f64>| x.map_or(Cell::default(), Cell::number);
    let warnings = asset.figures.as_ref().map_or(String::new(), |figures| figures.warnings.join("; "));
    let name = Cell {
        link: asset.report.as_deref().and_then(Link::new),
        thumbnail: asset.preview.as_deref().and_then(|path| preview(folder, path)),
        ..Cell::text(asset.name.clone())
    };
    vec![
        name,
        Cell::text(asset.outcome.name()),
        size(asset.bytes),
        number(error(asset).map(|error| 100.0 * error)),
        number(asset.seconds),
        size(asset.peak_memory),
        Cell::text(asset.tags.join(", ")),
        Cell::text(why(asset)),
        Cell::text(warnings),
    ]
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
        assert_eq!(titles, ["Failed and rejected", "Assets", "Totals"]);
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
