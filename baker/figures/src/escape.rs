//! Text that stands in HTML, between tags or in quotes.

use volmap_formats::text::printable;

/// The text with all that HTML would take as markup replaced, and without what `printable` replaces.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_markup() {
        assert_eq!(escape("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
        assert_eq!(escape("&amp;"), "&amp;amp;");
        assert_eq!(escape("\0\u{1b}\u{202e}x\n"), "\u{fffd}\u{fffd}\u{fffd}x\n");
        assert_eq!(escape("Größe Φ 漢"), "Größe Φ 漢");
    }
}
