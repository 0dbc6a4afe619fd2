//! `volmap report`.

use crate::args::report::ReportArguments;
use crate::is_same_file;
use crate::progress::Progress;
use anyhow::{Result, bail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use volmap_bake::area_map::require_space;
use volmap_bake::input::{self, Input};
use volmap_bake::provenance;
use volmap_formats::asset::{self, Asset};
use volmap_memory::start_threads;
use volmap_report::report::findings::Findings;
use volmap_report::report::page::page;
use volmap_report::report::{Report, report};

/// Measures an asset and writes the report; the exit code says whether it passed.
pub fn run_report(arguments: &ReportArguments) -> Result<ExitCode> {
    if arguments.schema {
        writeln!(io::stdout().lock(), "{:#}", Findings::schema())?;
        return Ok(ExitCode::SUCCESS);
    }
    let Some(path) = &arguments.asset else { bail!("give an asset") };
    start_threads(arguments.threads)?;
    check_targets(arguments, path)?;
    let mut progress = Progress::new(arguments.quiet)?;
    let content = asset::read(path)?;
    require_space(&content, "volmap report")?;
    let mesh = mesh(arguments, path, &content)?;
    let warning = mesh.as_ref().and_then(|input| provenance::other_mesh(&content, &input.source));
    warning.iter().for_each(|warning| eprintln!("warning: {warning}"));
    let found = report(&content, mesh, &arguments.settings(), &progress.watch())?;
    let files = write(arguments, path, &found)?;
    progress.finish();
    let verdict = &found.findings.verdict;
    if !arguments.quiet && !is_standard_output(arguments) {
        let mut out = io::stdout().lock();
        writeln!(out, "{}", verdict.text)?;
        files.iter().try_for_each(|file| writeln!(out, "written    {}", file.display()))?;
    }
    Ok(if verdict.passed == Some(false) { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn is_standard_output(arguments: &ReportArguments) -> bool {
    arguments.json.as_ref().is_some_and(|path| path.as_os_str() == "-")
}

/// Before anything long begins: can the files be written, and is none of them read?
fn check_targets(arguments: &ReportArguments, path: &Path) -> Result<()> {
    let mut targets = Vec::new();
    if arguments.writes_page() {
        targets.push(arguments.file(path, "html"));
    }
    targets.push(match &arguments.json {
        Some(file) => file.clone(),
        None => arguments.file(path, "json"),
    });
    for target in targets.iter().filter(|target| target.as_os_str() != "-") {
        let sources = [path].into_iter().chain(arguments.mesh.as_deref());
        if let Some(source) = sources.into_iter().find(|source| is_same_file(source, target)) {
            bail!("{}: would overwrite {}; name another file", target.display(), source.display());
        }
        asset::check_target(target)?;
    }
    Ok(())
}

fn mesh(arguments: &ReportArguments, path: &Path, content: &Asset) -> Result<Option<Input>> {
    let found = match &arguments.mesh {
        Some(file) => Some(file.clone()),
        None => {
            if let Some(shape) = provenance::shape(content)? {
                return Ok(Some(shape));
            }
            let folder = path.parent().unwrap_or(Path::new(""));
            let found = provenance::find_mesh(content, &[folder, Path::new("")]);
            if let (Some(file), false) = (&found, arguments.quiet) {
                eprintln!("mesh       {} (the one that was baked)", file.display());
            }
            found
        }
    };
    let Some(file) = found else { return Ok(None) };
    Ok(Some(input::load(&file, &provenance::input_settings(content)?)?))
}

/// Writes page, pictures and JSON; pictures first, so that a page that is there is complete.
fn write(arguments: &ReportArguments, path: &Path, found: &Report) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut publish = |file: PathBuf, bytes: &[u8]| -> Result<()> {
        asset::publish(&file, bytes)?;
        files.push(file);
        Ok(())
    };
    let json = serde_json::to_string_pretty(&found.findings)? + "\n";
    if arguments.writes_page() {
        let pictures = found.pictures();
        for picture in &pictures {
            publish(arguments.file(path, &format!("{}.png", picture.name)), &picture.png)?;
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let html = page(&name, &found.findings, pictures).to_html();
        publish(arguments.file(path, "html"), html.as_bytes())?;
    }
    match &arguments.json {
        Some(file) if file.as_os_str() == "-" => io::stdout().lock().write_all(json.as_bytes())?,
        Some(file) => publish(file.clone(), json.as_bytes())?,
        None => publish(arguments.file(path, "json"), json.as_bytes())?,
    }
    Ok(files)
}
