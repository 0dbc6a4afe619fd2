//! A page as the text of an HTML file.

use super::document::{Block, Cell, Column, Image, Outcome, Page, Parameter, Section, Table, Verdict};
use crate::escape::escape;
use crate::picture::png;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("sort.js");
/// SHA-256 of the script, in base64: no other may run. The interop test shows that a browser agrees.
const SCRIPT_HASH: &str = "IrrE0Cr0fiOyalGVVgNWbTrhL9JPlTze+PvEnQkSDAw=";
/// Around what may be wider than a phone; keys scroll it too.
const SCROLLS: &str = "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Scrolls sideways\">";

impl Page {
    /// The whole file.
    pub fn to_html(&self) -> String {
        let title = escape(&self.title);
        let again = |seconds| format!("<meta http-equiv=\"refresh\" content=\"{seconds}\">\n");
        let refresh = self.refresh.map(again).unwrap_or_default();
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
             style-src 'unsafe-inline'; script-src 'sha256-{SCRIPT_HASH}'; base-uri 'none'; form-action 'none'\">\n\
             {refresh}<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
             <link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n"
        );
        optional(&mut out, "p class=\"subtitle\"", &self.subtitle);
        out += "</header>\n<main>\n";
        verdict(&mut out, &self.verdict);
        self.contents(&mut out);
        self.sections.iter().enumerate().for_each(|(number, part)| section(&mut out, number, part));
        out += "</main>\n";
        optional(&mut out, "footer", &self.footer);
        _ = write!(out, "<script>{SCRIPT}</script>\n</body>\n</html>\n");
        out
    }

    /// Links to the sections, if there are many.
    fn contents(&self, out: &mut String) {
        if self.sections.len() < 3 {
            return;
        }
        *out += "<nav aria-label=\"Contents\"><ul>\n";
        for (number, part) in self.sections.iter().enumerate() {
            _ = writeln!(out, "<li><a href=\"#s{number}\">{}</a></li>", escape(&part.title));
        }
        *out += "</ul></nav>\n";
    }
}

/// An element with text in it, if there is any.
fn optional(out: &mut String, element: &str, text: &str) {
    if !text.is_empty() {
        let name = element.split(' ').next().unwrap_or(element);
        _ = writeln!(out, "<{element}>{}</{name}>", escape(text));
    }
}

fn verdict(out: &mut String, verdict: &Verdict) {
    let (class, word) = match verdict.outcome {
        Outcome::Pass => ("pass", "✓ Pass".to_owned()),
        Outcome::Fail => ("fail", "✗ Fail".to_owned()),
        Outcome::None => ("none", escape(&verdict.headline)),
    };
    _ = writeln!(
        out,
        "<section class=\"verdict {class}\" aria-label=\"Verdict\">\n<p class=\"word\">{word}</p>"
    );
    optional(out, "p", &verdict.text);
    if !verdict.figures.is_empty() {
        *out += "<dl>\n";
        for (name, number) in &verdict.figures {
            _ = writeln!(out, "<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(number));
        }
        *out += "</dl>\n";
    }
    *out += "</section>\n";
}

fn section(out: &mut String, number: usize, part: &Section) {
    _ = writeln!(out, "<section id=\"s{number}\">\n<h2>{}</h2>", escape(&part.title));
    part.blocks.iter().for_each(|part| block(out, part));
    *out += "</section>\n";
}

fn block(out: &mut String, part: &Block) {
    match part {
        Block::Paragraph(text) => optional(out, "p", text),
        Block::Warning(text) => optional(out, "p class=\"warning\" role=\"note\"", text),
        Block::List(items) => {
            *out += "<ul>\n";
            items.iter().for_each(|item| optional(out, "li", item));
            *out += "</ul>\n";
        }
        Block::Parameters(list) => parameters(out, list),
        Block::Table(data) => table(out, data),
        Block::Image(picture) => image(out, picture),
        Block::Chart(svg, caption) => figure(out, svg, caption, "chart"),
        Block::Details(head, blocks) => {
            _ = writeln!(out, "<details>\n<summary>{}</summary>", escape(head));
            blocks.iter().for_each(|part| block(out, part));
            *out += "</details>\n";
        }
    }
}

fn parameters(out: &mut String, list: &[Parameter]) {
    *out += SCROLLS;
    *out += "<table class=\"parameters\">\n<tbody>\n";
    for Parameter { name, value, note } in list {
        _ = write!(out, "<tr><th scope=\"row\">{}</th><td>{}</td>", escape(name), escape(value));
        _ = writeln!(out, "<td class=\"note\">{}</td></tr>", escape(note));
    }
    *out += "</tbody>\n</table></div>\n";
}

fn table(out: &mut String, data: &Table) {
    *out += SCROLLS;
    *out += "<table class=\"sortable\">\n";
    optional(out, "caption", &data.caption);
    *out += "<thead><tr>";
    for column in &data.columns {
        _ = write!(out, "<th scope=\"col\"{}>{}</th>", class(Some(column)), escape(&column.name));
    }
    *out += "</tr></thead>\n<tbody>\n";
    for row in &data.rows {
        *out += "<tr>";
        row.iter().enumerate().for_each(|(number, part)| cell(out, data.columns.get(number), part));
        *out += "</tr>\n";
    }
    *out += "</tbody>\n</table></div>\n";
}

fn class(column: Option<&Column>) -> &'static str {
    match column {
        Some(column) if column.numeric => " class=\"number\"",
        Some(column) if column.wraps => " class=\"sentences\"",
        _ => "",
    }
}

fn cell(out: &mut String, column: Option<&Column>, Cell { text, value, link, thumbnail }: &Cell) {
    let value = value.filter(|x| x.is_finite()).map_or(String::new(), |x| format!(" data-v=\"{x:e}\""));
    _ = write!(out, "<td{}{value}>", class(column));
    if let Some(png) = thumbnail {
        let data = BASE64.encode(png);
        _ = write!(out, "<img class=\"thumbnail\" src=\"data:image/png;base64,{data}\" alt=\"\">");
    }
    match link {
        Some(link) => _ = write!(out, "<a href=\"{}\">{}</a>", escape(link.url()), escape(text)),
        None => *out += &escape(text),
    }
    *out += "</td>";
}

fn image(out: &mut String, Image { png, alt, caption }: &Image) {
    let size = png::size(png)
        .map_or(String::new(), |[w, h]| format!(" width=\"{w}\" height=\"{h}\" style=\"--pixels: {w}\""));
    let data = BASE64.encode(png);
    let tag =
        format!("{SCROLLS}<img src=\"data:image/png;base64,{data}\" alt=\"{}\"{size}></div>", escape(alt));
    figure(out, &tag, caption, "picture");
}

fn figure(out: &mut String, content: &str, caption: &str, class: &str) {
    _ = writeln!(out, "<figure class=\"{class}\">\n{content}");
    optional(out, "figcaption", caption);
    *out += "</figure>\n";
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::{Link, Parameter};

    const NASTY: &str = "<script>alert(1)</script>\" onload='x' &amp; Größe\u{202e}\0";

    /// A page with the text in every place that takes one.
    fn page(text: &str) -> Page {
        let text = || text.to_owned();
        let cell =
            Cell { thumbnail: Some(vec![4, 5, 6]), link: Link::new(&text()), ..Cell::written(text(), 1.5) };
        let unlinked = Cell::text(text());
        let table = Table {
            caption: text(),
            columns: vec![Column::text(text()), Column::sentences(text())],
            rows: vec![vec![cell, unlinked]],
        };
        let image = Image { png: vec![1, 2, 3], alt: text(), caption: text() };
        let parameter = Parameter { name: text(), value: text(), note: text() };
        let blocks = vec![
            Block::Paragraph(text()),
            Block::Warning(text()),
            Block::List(vec![text()]),
            Block::Parameters(vec![parameter]),
            Block::Table(table),
            Block::Image(image),
            Block::Chart("<svg></svg>".into(), text()),
            Block::Details(text(), vec![Block::Paragraph(text())]),
        ];
        let section = Section { title: text(), blocks };
        Page {
            title: text(),
            subtitle: text(),
            verdict: Verdict {
                outcome: Outcome::Fail,
                headline: text(),
                text: text(),
                figures: vec![(text(), text())],
            },
            sections: vec![section.clone(), section.clone(), section],
            footer: text(),
            refresh: None,
        }
    }

    /// The tags of a page, without their attributes' values.
    fn tags(html: &str) -> Vec<String> {
        let body = html.split("</style>").nth(1).unwrap().split("<script>").next().unwrap();
        let mut out = Vec::new();
        for part in body.split('<').skip(1) {
            let tag = part.split('>').next().unwrap();
            out.push(tag.split('"').step_by(2).collect());
        }
        out
    }

    #[test]
    fn texts_are_never_markup() {
        let html = page(NASTY).to_html();
        assert_eq!(tags(&html), tags(&page("harmless").to_html()));
        assert_eq!(html.matches("<script").count(), 1);
        assert_eq!(html.matches("&lt;script&gt;alert(1)").count(), 3 * 18 + 7);
        assert!(!html.contains('\0') && !html.contains('\u{202e}'));
    }

    #[test]
    fn every_tag_is_closed() {
        let html = page("x").to_html();
        let mut open: Vec<String> = Vec::new();
        for tag in tags(&html) {
            let name = tag.split(' ').next().unwrap().to_owned();
            match name.strip_prefix('/') {
                Some("head" | "body" | "html") => (),
                Some(name) => assert_eq!(open.pop().as_deref(), Some(name), "{open:?}"),
                None if ["img", "body"].contains(&name.as_str()) => (),
                None => open.push(name),
            }
        }
        assert_eq!(open, [""; 0]);
    }

    #[test]
    fn the_verdict_comes_first_and_numbers_sort() {
        let html = page("x").to_html();
        let place = |text: &str| html.find(text).unwrap_or_else(|| panic!("no {text}"));
        assert!(place("✗ Fail") < place("<h2>") && place("✗ Fail") < place("<nav"));
        assert!(html.contains(" data-v=\"1.5e0\"") && html.contains("data:image/png;base64,AQID"));
        assert!(!html.contains("http://") && !html.contains("https://") && !html.contains("url("));
        let cell = |value: f64| Table { rows: vec![vec![Cell::number(value)]], ..Table::default() };
        let mut out = String::new();
        table(&mut out, &cell(f64::NAN));
        assert!(!out.contains("data-v"), "a number that is none sorts last");
    }

    #[test]
    fn hash_is_that_of_the_script() {
        // Whoever changes the script must set SCRIPT_HASH (openssl dgst -sha256 -binary sort.js | base64) and this.
        let known = "2fc81f661bda7873c9d84df1f80cd76016611317c82a23ce8026ff77cb5caad7";
        assert_eq!(blake3::hash(SCRIPT.as_bytes()).to_hex().as_str(), known);
    }
}
