//! A figure: panels in rows, with a legend of what they have in common.

use super::canvas::Canvas;
use super::content::Panel;
use super::drawing::{Anchor, Drawing};
use super::legend::{Legend, LegendEntry};
use super::panel::{Layout, Style, entries};

/// One or several panels, as one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Above all panels; may be empty.
    pub title: String,
    /// Panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels a row, at least 1.
    pub columns: usize,
}

impl Figure {
    /// A figure of one panel, without a title of its own.
    pub fn of(panel: Panel) -> Figure {
        Figure { title: String::new(), panels: vec![panel], columns: 1 }
    }

    /// The picture as a PNG file: about 1,600 pixels wide, 300 an inch, white behind.
    pub fn to_png(&self) -> Vec<u8> {
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let style = Style::new(columns, &self.panels);
        let (shared, own) = self.legends(&style);
        let layouts: Vec<Layout> =
            self.panels.iter().zip(own).map(|(panel, own)| Layout::new(panel, style, own)).collect();
        let rows: Vec<&[Layout]> = layouts.chunks(columns).collect();
        let column = |c: usize| rows.iter().filter_map(move |row| row.get(c));
        let widths: Vec<f64> = (0..columns).map(|c| largest(column(c), Layout::width)).collect();
        let heights: Vec<f64> = rows.iter().map(|row| largest(row.iter(), Layout::height)).collect();
        let head = style.gap + if self.title.is_empty() { 0.0 } else { 1.8 * style.text };
        let all = |lengths: &[f64]| lengths.iter().map(|length| length + style.gap).sum::<f64>();
        let width = style.gap + all(&widths);
        let legend = Legend::new(shared, width - 4.0 * style.gap, style.text);
        let foot = if legend.height() > 0.0 { legend.height() + style.gap } else { 0.0 };
        let mut canvas = Canvas::new([width, head + all(&heights) + foot]);
        let mut y = head;
        for (row, height) in rows.iter().zip(&heights) {
            let mut x = style.gap;
            for (layout, width) in row.iter().zip(&widths) {
                layout.draw(&mut canvas, [x, y]);
                x += width + style.gap;
            }
            y += height + style.gap;
        }
        let mut around = Drawing::default();
        around.label([0.5 * width, style.gap + style.text], 1.2 * style.text, Anchor::Middle, &self.title);
        legend.draw(&mut around, [2.0 * style.gap, y]);
        canvas.draw(&around);
        canvas.to_png()
    }

    /// What several panels have in common is explained once, below them; the rest by each panel.
    fn legends(&self, style: &Style) -> (Vec<LegendEntry>, Vec<Vec<LegendEntry>>) {
        let all: Vec<Vec<LegendEntry>> = self.panels.iter().map(|panel| entries(panel, style.text)).collect();
        let common = |entry: &LegendEntry| all.iter().filter(|own| own.contains(entry)).count() > 1;
        let mut shared: Vec<LegendEntry> = Vec::new();
        for entry in all.iter().flatten().filter(|entry| common(entry)) {
            if !shared.contains(entry) {
                shared.push(entry.clone());
            }
        }
        let own =
            all.iter().map(|own| own.iter().filter(|entry| !common(entry)).cloned().collect()).collect();
        (shared, own)
    }
}

fn largest<'a>(layouts: impl Iterator<Item = &'a Layout<'a>>, length: impl Fn(&Layout<'a>) -> f64) -> f64 {
    layouts.map(length).fold(0.0, f64::max)
}
