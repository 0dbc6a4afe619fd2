//! Text from files, as it may stand in a message.

/// At most `longest` characters of a text. What a terminal would obey is replaced by U+FFFD: control characters, and
/// those that turn the direction of writing (Unicode Standard Annex 9).
///
/// ```
/// assert_eq!(volmap_formats::printable("duck\x1b[2J.obj", 9), "duck\u{FFFD}[2J.");
/// ```
pub fn printable(text: &str, longest: usize) -> String {
    let turns = |c: char| matches!(c, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}');
    let safe = |c: char| if c.is_control() || turns(c) { '\u{FFFD}' } else { c };
    text.chars().take(longest).map(safe).collect()
}
