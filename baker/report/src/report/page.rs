//! A report as a page.

use super::figures::{Picture, distance_chart, histogram_chart};
use super::findings::{DensityErrors, DistanceErrors, Findings, ThinPlaces};
use super::levels::{Causes, LevelFacts};
use super::statistics::Statistics;
use serde_json::Value as Json;
use volmap_figures::page::{Block, Cell, Column, Image, Outcome, Page, Parameter, Section, Table, Verdict};
use volmap_formats::text::{self, typeset};

/// The page of the asset of this name.
pub fn page(name: &str, findings: &Findings, pictures: Vec<Picture>) -> Page {
    let mut sections = vec![volume(findings)];
    if !pictures.is_empty() {
        let image = |picture: Picture| {
            Block::Image(Image { png: picture.png, alt: picture.alt, caption: picture.caption })
        };
        sections
            .push(Section { title: "Pictures".into(), blocks: pictures.into_iter().map(image).collect() });
    }
    sections.extend(findings.levels.as_ref().map(|found| levels(findings, found)));
    sections.extend(findings.density.as_ref().map(density));
    sections.extend(findings.distance.as_ref().map(distance));
    sections.extend(findings.thin.as_ref().map(|thin| places(findings, thin)));
    sections.push(parameters(findings));
    Page {
        title: format!("Error report of {name}"),
        subtitle: subtitle(findings),
        verdict: verdict(findings),
        sections,
        footer: format!("volmap {}, volmap report", findings.program_version),
        refresh: None,
    }
}

fn subtitle(findings: &Findings) -> String {
    let asset = &findings.asset;
    let [x, y, z] = asset.resolution;
    let mesh = match &findings.mesh {
        Some(mesh) => format!("compared with {}", mesh.file),
        None => "compared with its own distance; give the mesh to measure that too".into(),
    };
    format!(
        "{x} × {y} × {z} cells, support radius {} m, {}; {mesh}",
        number(asset.support_radius),
        asset.quadrature
    )
}

fn verdict(findings: &Findings) -> Verdict {
    let found = &findings.verdict;
    let mut figures = vec![("largest error".to_string(), percent(found.max_error))];
    let fluid = findings.volume.iter().find(|errors| errors.reference == found.reference);
    if let Some(errors) = fluid {
        figures.push(("99 % of the points below".into(), percent(errors.fraction.percentiles[2])));
        figures.push(("mean".into(), percent(errors.fraction.mean)));
    }
    if let Some(distance) = &findings.distance {
        figures.push(("distance, 99 % below".into(), format!("{} r", number(distance.radii.percentiles[2]))));
    }
    let outcome = match found.passed {
        Some(true) => Outcome::Pass,
        Some(false) => Outcome::Fail,
        None => Outcome::None,
    };
    let headline = format!("Largest volume error {} (no limit set)", percent(found.max_error));
    Verdict { outcome, headline, text: found.text.clone(), figures }
}

fn volume(findings: &Findings) -> Section {
    let mut blocks = Vec::new();
    if let Some(warning) = findings.mesh.as_ref().and_then(|mesh| mesh.warning.clone()) {
        blocks.push(Block::Warning(warning));
    }
    blocks.push(Block::Paragraph(format!(
        "Errors are sizes of (map − reference), as parts of the full ball of {} m³, at points spread evenly over the \
         stored cells. The bias is the mean of the signed errors, with its 95 % confidence interval.",
        number(findings.asset.ball_volume)
    )));
    let row = |errors: &super::findings::VolumeErrors| {
        let region = format!("{:?}", errors.region).to_lowercase();
        let mut row = vec![Cell::text(errors.description.clone()), Cell::text(region)];
        row.extend(cells(&errors.fraction));
        row.push(Cell::number(errors.cubic_metres.max));
        row.push(worst_place(&errors.fraction));
        row
    };
    let mut columns = vec![Column::text("reference"), Column::text("where")];
    columns.extend(columns_of_statistics());
    columns.extend([Column::number("max, m³"), Column::text("worst point, m")]);
    let rows = findings.volume.iter().map(row).collect();
    let caption = "Error of the volume, % of the full ball".into();
    blocks.push(Block::Table(Table { caption, columns, rows }));
    blocks.extend(parts(findings));
    blocks.push(Block::Chart(
        distance_chart(findings).to_svg(),
        "Size of the error against the distance from the surface, against the verdict's reference.".into(),
    ));
    blocks.push(Block::Chart(
        histogram_chart(findings).to_svg(),
        "How many points have an error of which size.".into(),
    ));
    Section { title: "Volume".into(), blocks }
}

/// Where the error comes from.
fn parts(findings: &Findings) -> Option<Block> {
    if findings.parts.is_empty() {
        return None;
    }
    let row = |part: &super::findings::PartErrors| {
        let mut row = vec![Cell::text(part.description.clone())];
        row.extend(cells(&part.fraction));
        row
    };
    let mut columns = vec![Column::text("part")];
    columns.extend(columns_of_statistics());
    let rows = findings.parts.iter().map(row).collect();
    let caption =
        "Where the error comes from, % of the full ball: signed parts that add up to the whole at each point"
            .into();
    Some(Block::Table(Table { caption, columns, rows }))
}

fn columns_of_statistics() -> [Column; 10] {
    ["points", "max", "rms", "mean", "50 %", "90 %", "99 %", "99.9 %", "bias", "± (95 %)"].map(Column::number)
}

/// In per cent of the statistics' unit.
fn cells(found: &Statistics) -> Vec<Cell> {
    cells_in(found, 100.0)
}

fn cells_in(found: &Statistics, factor: f64) -> Vec<Cell> {
    let mut out = vec![Cell::written(found.count.to_string(), found.count as f64)];
    let sizes = [found.max, found.rms, found.mean].into_iter().chain(found.percentiles);
    let numbers = sizes.chain([found.bias, found.bias_confidence]);
    out.extend(numbers.map(|x| Cell::number(factor * x)));
    out
}

fn worst_place(found: &Statistics) -> Cell {
    Cell::text(found.worst.map_or(String::new(), |worst| place(worst.point)))
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("({})", [x, y, z].map(number).join(", "))
}

/// Where the cells went, and why.
fn levels(findings: &Findings, found: &[LevelFacts]) -> Section {
    let radius = findings.asset.support_radius;
    let row = |level: &LevelFacts| {
        vec![
            Cell::written(level.level.to_string(), level.level.into()),
            Cell::number(level.edge),
            Cell::number(level.edge / radius),
            Cell::written(level.cells.to_string(), level.cells as f64),
            Cell::number(100.0 * level.part),
            Cell::written(level.points.to_string(), level.points as f64),
            Cell::number(100.0 * level.max_error),
        ]
    };
    let names =
        ["level", "edge, m", "edge, r", "cells", "% of the band", "points", "max error, % of the ball"];
    let table = Table {
        caption: "The cells by level".into(),
        columns: names.map(Column::number).into(),
        rows: found.iter().map(row).collect(),
    };
    let cause = |level: &LevelFacts| {
        let causes = level.causes.filter(|causes| causes.looked_at > 0)?;
        let Causes { looked_at, volume, distance, normal, neighbours, edge } = causes;
        let mut row = vec![
            Cell::written(level.level.to_string(), level.level.into()),
            Cell::written(looked_at.to_string(), looked_at as f64),
        ];
        row.extend([volume, distance, normal, neighbours, edge].map(|part| Cell::number(100.0 * part)));
        Some(row)
    };
    let names = [
        "level",
        "looked at",
        "volume, %",
        "distance, %",
        "normal, %",
        "neighbours, %",
        "edge of the band, %",
    ];
    let causes = Table {
        caption: "Why they aren't twice as large".into(),
        columns: names.map(Column::number).into(),
        rows: found.iter().filter_map(cause).collect(),
    };
    let how = "Errors are those of the verdict's reference at the report's points in the fluid. Why: a cell twice as large \
               would have the cubic through its own 32 nodes, of the volume as it is or as its difference from a flat \
               wall's, whichever is better. Compared at 125 places in it, near the fluid, with the map's volume and the \
               mesh's distance (the map's, if there is no mesh), its largest miss as a part of the tolerance that the map \
               was baked for names the cause; up to 2,000 such cells are looked at for each level. Where none is above \
               its tolerance, cells are small because those beside them are smaller still (neighbours differ by one level \
               at most), or because their errors in place, on the faces of larger cells, were too large. At the edge of \
               the band larger cells would reach to where nothing is stored.";
    let mut blocks = vec![Block::Table(table), Block::Table(causes), Block::Paragraph(how.into())];
    let places =
        findings.asset.bake.get("cells_above_tolerance").and_then(Json::as_u64).filter(|count| *count > 0);
    if let Some(count) = places {
        blocks.push(Block::Warning(format!(
            "{count} cells of the finest level stayed above the tolerance when the map was baked."
        )));
    }
    Section { title: "Cells".into(), blocks }
}

fn density(found: &DensityErrors) -> Section {
    let mut row = vec![Cell::text(found.description.clone())];
    row.extend(cells_in(&found.rest_densities, 1.0));
    row.push(worst_place(&found.rest_densities));
    let mut columns = vec![Column::text("reference")];
    columns.extend(columns_of_statistics());
    columns.push(Column::text("worst point, m"));
    let caption = format!(
        "Error of the density in rest densities; kernel {}, integrated by {}",
        found.kernel, found.quadrature
    );
    Section {
        title: "Density".into(),
        blocks: vec![Block::Table(Table { caption, columns, rows: vec![row] })],
    }
}

fn distance(found: &DistanceErrors) -> Section {
    let row = |name: &str, statistics: &Statistics| {
        let mut row = vec![Cell::text(name)];
        row.extend(cells_in(statistics, 1.0));
        row.push(worst_place(statistics));
        row
    };
    let mut columns = vec![Column::text("error of")];
    columns.extend(columns_of_statistics());
    columns.push(Column::text("worst point, m"));
    let rows = vec![
        row("distance, m", &found.metres),
        row("distance, support radii", &found.radii),
        row("normal, degrees", &found.normal_degrees),
    ];
    let note = "The normal is compared with the line to the closest point of the mesh. It is far off where that point \
                jumps: halfway between two surfaces, and inside of edges.";
    Section {
        title: "Distance and normal".into(),
        blocks: vec![
            Block::Table(Table { caption: "Errors in the band, against the mesh".into(), columns, rows }),
            Block::Paragraph(note.into()),
        ],
    }
}

fn places(findings: &Findings, thin: &ThinPlaces) -> Section {
    let row = |kind: &super::findings::ThinKind| {
        vec![Cell::text(kind.description.clone()), Cell::number(100.0 * kind.part)]
    };
    let mut blocks = vec![Block::Table(Table {
        caption: format!(
            "The surface by what is thin, at {} points; a cell is {} m long, the support radius {} m",
            thin.points,
            number(thin.cell),
            number(findings.asset.support_radius)
        ),
        columns: vec![Column::text("what"), Column::number("% of the surface")],
        rows: thin.kinds.iter().map(row).collect(),
    })];
    let width = |name: &str, width: Option<f64>, point| {
        width.map(|width| vec![Cell::text(name), Cell::number(width), Cell::text(place(point))])
    };
    let walls = thin.walls.iter().filter_map(|w| width("wall", w.wall, w.point));
    let gaps = thin.gaps.iter().filter_map(|w| width("gap", w.gap, w.point));
    let rows: Vec<Vec<Cell>> = walls.chain(gaps).collect();
    if !rows.is_empty() {
        blocks.push(Block::Table(Table {
            caption: "The narrowest places".into(),
            columns: vec![Column::text("what"), Column::number("width, m"), Column::text("where, m")],
            rows,
        }));
    }
    if let Some(check) = findings.reference_check.as_ref().filter(|check| check.points > 0) {
        let text = format!(
            "The exact distance was checked by winding numbers alone at {} points; they contradict it at {}.",
            check.points, check.contradictions
        );
        blocks.push(if check.contradictions == 0 { Block::Paragraph(text) } else { Block::Warning(text) });
    }
    if let Some(signs) = &findings.signs {
        let text = format!(
            "Pseudonormals and winding numbers differ at {} of {} points close to the surface.",
            signs.disagreeing, signs.points
        );
        blocks.push(if signs.disagreeing == 0 { Block::Paragraph(text) } else { Block::Warning(text) });
        let row =
            |(point, distance): &([f64; 3], f64)| vec![Cell::text(place(*point)), Cell::number(*distance)];
        if signs.disagreeing > 0 {
            blocks.push(Block::Table(Table {
                caption: "Where the signs differ, the farthest from the surface first".into(),
                columns: vec![Column::text("where, m"), Column::number("distance, m")],
                rows: signs.worst.iter().map(row).collect(),
            }));
        }
    }
    Section { title: "Thin places and signs".into(), blocks }
}

/// Every effective parameter.
fn parameters(findings: &Findings) -> Section {
    let list = |entries: &serde_json::Map<String, Json>| {
        let parameter = |(name, value): (&String, &Json)| {
            let text = match value {
                Json::String(text) => text.clone(),
                other => other.to_string(),
            };
            Parameter::new(name.clone(), text)
        };
        Block::Parameters(entries.iter().map(parameter).collect())
    };
    let asset = &findings.asset;
    let settings = &findings.settings;
    let measured = [
        ("random points", settings.points.to_string()),
        ("points compared with the mesh", settings.mesh_points.to_string()),
        ("seed", settings.seed.to_string()),
        ("pixels of a slice's longest side", settings.pixels.to_string()),
        ("converged rule", settings.fine_rule.clone()),
    ];
    let [low, high] = asset.domain;
    let grid = [
        ("cells stored", asset.band_cells.to_string()),
        ("nodes stored", asset.nodes.to_string()),
        ("cell size, m", asset.cell_size.map(number).join(" × ")),
        ("domain, m", format!("{} to {}", place(low), place(high))),
        ("outside the domain", asset.exterior.clone()),
    ];
    let named = |pairs: &[(&str, String)]| {
        Block::Parameters(pairs.iter().map(|(name, value)| Parameter::new(*name, value.clone())).collect())
    };
    let blocks = vec![
        Block::Details("This report".into(), vec![named(&measured)]),
        Block::Details("The grid".into(), vec![named(&grid)]),
        Block::Details("The bake".into(), vec![list(&asset.bake)]),
        Block::Details("The source".into(), vec![list(&asset.source)]),
    ];
    Section { title: "Parameters".into(), blocks }
}

fn number(value: f64) -> String {
    typeset(&text::number(value))
}

fn percent(part: f64) -> String {
    typeset(&text::percent(part))
}
