//! What a page says.

use volmap_formats::text::{number, typeset};

/// A page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Name in the head and in the browser.
    pub title: String,
    /// A line below the title; may be empty.
    pub subtitle: String,
    /// The answer, before all else.
    pub verdict: Verdict,
    /// Sections.
    pub sections: Vec<Section>,
    /// Last line: program and version; may be empty.
    pub footer: String,
    /// Seconds after which a browser reads the file again, if what it shows goes on.
    pub refresh: Option<u32>,
}

/// The answer of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Good or bad.
    pub outcome: Outcome,
    /// What stands in the place of pass or fail where neither was asked for ([`Outcome::None`]).
    pub headline: String,
    /// In a sentence.
    pub text: String,
    /// A few numbers that a reader looks for first: name, number with unit.
    pub figures: Vec<(String, String)>,
}

/// Good or bad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// What was asked for holds.
    Pass,
    /// It doesn't.
    Fail,
    /// Nothing was asked for.
    #[default]
    None,
}

/// A part with a heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// Content.
    pub blocks: Vec<Block>,
}

/// A piece of content.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A paragraph.
    Paragraph(String),
    /// A paragraph that must not be missed.
    Warning(String),
    /// A list.
    List(Vec<String>),
    /// Names and values.
    Parameters(Vec<Parameter>),
    /// A table; a click on a column heading sorts it.
    Table(Table),
    /// A picture.
    Image(Image),
    /// A chart as an `svg` element (of [`crate::picture::Chart::to_svg`], which is taken as it is) and its
    /// caption.
    Chart(String, String),
    /// Blocks behind a line that opens them; open in print.
    Details(String, Vec<Block>),
}

/// A name, its value and what it means.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Value with unit.
    pub value: String,
    /// What it means; may be empty.
    pub note: String,
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Above the table; may be empty.
    pub caption: String,
    /// Heads.
    pub columns: Vec<Column>,
    /// Rows, each with a cell a column.
    pub rows: Vec<Vec<Cell>>,
}

/// Head of a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Name, with unit.
    pub name: String,
    /// Numbers are written to the right and sorted by size.
    pub numeric: bool,
    /// Sentences: their lines break.
    pub wraps: bool,
}

/// A cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// What is shown.
    pub text: String,
    /// The number that it is sorted by, if it is one.
    pub value: Option<f64>,
    /// Where a click on the text leads.
    pub link: Option<Link>,
    /// A small PNG picture before the text, which says what is seen.
    pub thumbnail: Option<Vec<u8>>,
}

/// A PNG picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The file's bytes.
    pub png: Vec<u8>,
    /// What is seen, for who can't see it.
    pub alt: String,
    /// Below the picture; may be empty.
    pub caption: String,
}

/// Way from a page's folder to a file in it or below.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link(String);

impl Link {
    /// To the file of this relative path, whose parts are parted by `/`; none if it would lead out of the folder.
    pub fn new(path: &str) -> Option<Link> {
        let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
        if path.starts_with('/') || parts.is_empty() || parts.contains(&"..") {
            return None;
        }
        // The dot before it keeps a browser from reading a scheme.
        Some(Link(parts.iter().fold(".".to_owned(), |way, part| format!("{way}/{}", in_url(part)))))
    }

    /// As it stands in a page.
    pub fn url(&self) -> &str {
        &self.0
    }
}

/// A name as part of an URL's path: RFC 3986, section 2.
fn in_url(name: &str) -> String {
    let mut out = String::new();
    for byte in name.bytes() {
        match byte {
            b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' | b'-' | b'.' | b'_' | b'~' => out.push(byte.into()),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}

impl Parameter {
    /// A parameter without a note.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Parameter {
        Parameter { name: name.into(), value: value.into(), note: String::new() }
    }
}

impl Column {
    /// A column of text.
    pub fn text(name: impl Into<String>) -> Column {
        Column { name: name.into(), ..Column::default() }
    }

    /// A column of numbers.
    pub fn number(name: impl Into<String>) -> Column {
        Column { name: name.into(), numeric: true, ..Column::default() }
    }

    /// A column of sentences.
    pub fn sentences(name: impl Into<String>) -> Column {
        Column { name: name.into(), wraps: true, ..Column::default() }
    }
}

impl Cell {
    /// Text.
    pub fn text(text: impl Into<String>) -> Cell {
        Cell { text: text.into(), ..Cell::default() }
    }

    /// A number with three digits.
    pub fn number(value: f64) -> Cell {
        Cell::written(typeset(&number(value)), value)
    }

    /// A number that is written in another way.
    pub fn written(text: impl Into<String>, value: f64) -> Cell {
        Cell { text: text.into(), value: Some(value), ..Cell::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_stay_in_the_folder() {
        let url = |path: &str| Link::new(path).map(|link| link.0);
        assert_eq!(url("reports/a b.html").as_deref(), Some("./reports/a%20b.html"));
        assert_eq!(url("./a//\u{f6}?#%.html").as_deref(), Some("./a/%C3%B6%3F%23%25.html"));
        assert_eq!(url("javascript:alert(1)").as_deref(), Some("./javascript%3Aalert%281%29"));
        assert_eq!(url("a\\..\\\"onclick='x'").as_deref(), Some("./a%5C..%5C%22onclick%3D%27x%27"));
        for path in ["", ".", "/", "/etc/passwd", "//host/a", "../a", "a/../../b", "a/.."] {
            assert_eq!(url(path), None, "{path}");
        }
    }
}
