//! Interop, pages: headless Chromium opens one in every form, sorts its table, prints it.

use std::path::Path;
use std::process::Command;
use volmap_bake::plan;
use volmap_bake::watch::Watch;
use volmap_figures::page::{
    Block, Cell, Column, Image, Link, Outcome, Page, Parameter, Section, Table, Verdict,
};
use volmap_figures::picture;
use volmap_figures::picture::colours::DISTINCT;
use volmap_figures::picture::{Chart, Data, Quantity, Series};
use volmap_report::slice::{SliceSettings, slice};
use volmap_tests::{SPHERE, map_of, python};

const NASTY: &str = "<img src=x onerror=alert(1)>&amp;\"'.obj";

/// A picture of a ball's map.
fn image() -> Image {
    let map =
        map_of(&SPHERE, 12, &plan::MapSettings { support_radius: Some(0.1), ..plan::MapSettings::default() });
    let settings = SliceSettings {
        plane: "z=0.1".parse().unwrap(),
        field: volmap_report::slice::SliceField::Volume,
        pixels: 200,
        contours: vec![0.001, 0.002],
    };
    let png = slice(&map, &settings, None, &Watch::default()).unwrap().figure.to_png();
    Image {
        png,
        alt: format!("slice of {NASTY}"),
        caption: format!("The volume of {NASTY} on the plane z = 0.1 m."),
    }
}

fn chart() -> Block {
    let curve = (0..40).map(|n| [f64::from(n), (f64::from(n) * 0.3).sin() * 1e-6]).collect();
    let chart = Chart {
        title: format!("error of {NASTY}"),
        x: picture::ChartAxis { quantity: Quantity::new("distance", "r"), ..Default::default() },
        y: picture::ChartAxis { quantity: Quantity::new("error", "m³"), ..Default::default() },
        series: vec![Series { name: "median".into(), colour: DISTINCT[0], data: Data::Curve(curve) }],
        marks: vec![],
    };
    Block::Chart(chart.to_svg(), "Error against distance.".into())
}

/// Rows whose numbers sort otherwise than their texts.
fn table() -> Table {
    let numbers = [3.2e-5, -1.0, 0.04, 12345.6, f64::NAN, 7.0];
    let thumbnail = picture::png::encode([4, 3], &[200; 36], picture::png::Effort::Fast);
    let row = |(n, x): (usize, &f64)| {
        let name = Cell {
            link: Link::new(&format!("reports of {NASTY}/{n}.html")),
            thumbnail: Some(thumbnail.clone()),
            ..Cell::text(format!("quantity {n}"))
        };
        let mut row = vec![name, Cell::number(*x)];
        row.extend((0..6).map(|k| Cell::number(x * f64::from(k))));
        row.push(Cell::text(format!("a sentence about {NASTY} ").repeat(4)));
        row
    };
    let mut columns = vec![Column::text("name"), Column::number("largest, m³")];
    columns.extend((0..6).map(|k| Column::number(format!("percentile {k}"))));
    columns.push(Column::sentences("remarks"));
    Table {
        caption: format!("Errors of {NASTY}"),
        columns,
        rows: numbers.iter().enumerate().map(row).collect(),
    }
}

fn page() -> Page {
    let hash = "4f".repeat(32);
    let parameters = vec![
        Parameter { note: "metres; ".repeat(20), ..Parameter::new("support_radius", "0.1 m") },
        Parameter::new("blake3", hash),
    ];
    let text = "How far the map is from the integral, at every pixel of three planes. ".repeat(6);
    Page {
        title: format!("Report of {NASTY}"),
        subtitle: "a page of the tests".into(),
        verdict: Verdict {
            headline: String::new(),
            outcome: Outcome::Fail,
            text: "The largest error is above the limit.".into(),
            figures: vec![
                ("largest error".into(), "1.2·10⁻⁵ m³".into()),
                ("of the ball".into(), "0.29 %".into()),
                ("limit".into(), "0.1 %".into()),
            ],
        },
        sections: vec![
            Section {
                title: "Pictures".into(),
                blocks: vec![Block::Paragraph(text.clone()), Block::Image(image()), chart()],
            },
            Section {
                title: "Numbers".into(),
                blocks: vec![Block::Warning("three edges have one face".into()), Block::Table(table())],
            },
            Section {
                title: "Parameters".into(),
                blocks: vec![
                    Block::Parameters(parameters),
                    Block::Details("All of them".into(), vec![Block::List(vec![text.clone(), text])]),
                ],
            },
        ],
        footer: "volmap 0.1.0".into(),
        refresh: None,
    }
}

#[test]
fn browser_shows_sorts_and_prints_a_page() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("page.html"), page().to_html()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/open_page.py");
    let output = Command::new(python()).arg(script).arg(folder.join("page.html")).arg("2").output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    print!("{text}");
}
