//! From a key to its line and column in the file.

use super::Syntax;
use super::check::PathStep;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Line and column, from 1, of a byte of a text.
pub(super) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let end = (0..=offset.min(text.len())).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
    let before = &text[..end];
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (1 + before.matches('\n').count(), 1 + before[start..].chars().count())
}

/// The byte where a value, or what of the way to it is there, stands in a text without errors.
pub(super) fn locate(text: &str, syntax: Syntax, path: &[PathStep]) -> usize {
    match syntax {
        Syntax::Toml => DeTable::parse(text).map_or(0, |table| in_table(table.get_ref(), path, 0)),
        Syntax::Json => in_json(text, path).unwrap_or(0),
    }
}

fn in_table(table: &DeTable, path: &[PathStep], here: usize) -> usize {
    let Some((PathStep::Key(name), rest)) = path.split_first() else { return here };
    let entry = table.iter().find(|(key, _)| key.get_ref() == name);
    entry.map_or(here, |(key, value)| in_value(value, rest, key.span().start))
}

fn in_value(value: &Spanned<DeValue>, path: &[PathStep], here: usize) -> usize {
    match (value.get_ref(), path.split_first()) {
        (DeValue::Table(table), _) => in_table(table, path, here),
        (DeValue::Array(list), Some((&PathStep::Item(index), rest))) => {
            list.get(index).map_or(here, |item| in_value(item, rest, item.span().start))
        }
        _ => here,
    }
}

/// Goes through the bytes of a JSON text; the last place that was found, if the way ends early.
fn in_json(text: &str, path: &[PathStep]) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut value = skip_space(bytes, 0);
    let mut here = value;
    for step in path {
        let found = match step {
            PathStep::Key(name) => member(text, value, name),
            PathStep::Item(index) => item(bytes, value, *index).map(|at| (at, at)),
        };
        let Some((key, next)) = found else { break };
        (here, value) = (key, next);
    }
    Some(here)
}

/// Where the key and the value of a member of the object at `at` begin.
fn member(text: &str, at: usize, name: &str) -> Option<(usize, usize)> {
    let bytes = text.as_bytes();
    let mut key = skip_space(bytes, enter(bytes, at, b'{')?);
    while bytes.get(key) == Some(&b'"') {
        let end = string_end(bytes, key)?;
        let colon = skip_space(bytes, end);
        let value = skip_space(bytes, colon + 1);
        let text = text.get(key..end)?;
        if serde_json::from_str::<String>(text).is_ok_and(|text| text == name) {
            return Some((key, value));
        }
        let comma = skip_space(bytes, value_end(bytes, value)?);
        key = skip_space(bytes, comma + 1);
    }
    None
}

fn item(bytes: &[u8], at: usize, index: usize) -> Option<usize> {
    let mut value = skip_space(bytes, enter(bytes, at, b'[')?);
    for _ in 0..index {
        let comma = skip_space(bytes, value_end(bytes, value)?);
        value = skip_space(bytes, comma + 1);
    }
    (value < bytes.len()).then_some(value)
}

fn enter(bytes: &[u8], at: usize, bracket: u8) -> Option<usize> {
    (bytes.get(at) == Some(&bracket)).then_some(at + 1)
}

fn skip_space(bytes: &[u8], from: usize) -> usize {
    let rest = bytes.get(from..).unwrap_or_default();
    from + rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count()
}

fn string_end(bytes: &[u8], quote: usize) -> Option<usize> {
    let mut at = quote + 1;
    loop {
        match bytes.get(at)? {
            b'\\' => at += 2,
            b'"' => return Some(at + 1),
            _ => at += 1,
        }
    }
}

fn value_end(bytes: &[u8], start: usize) -> Option<usize> {
    let (mut at, mut depth) = (start, 0_u32);
    loop {
        match bytes.get(at)? {
            b'"' => at = string_end(bytes, at)?,
            b'{' | b'[' => (at, depth) = (at + 1, depth + 1),
            b'}' | b']' if depth > 0 => (at, depth) = (at + 1, depth - 1),
            _ if depth > 0 => at += 1,
            // A number or a word.
            byte if byte.is_ascii_alphanumeric() || b"+-.".contains(byte) => {
                at += 1;
                continue;
            }
            _ => return Some(at),
        }
        if depth == 0 {
            return Some(at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: [PathStep; 4] =
        [PathStep::Key("b"), PathStep::Item(1), PathStep::Key("c"), PathStep::Key("d")];

    #[test]
    fn the_same_key_is_found_in_both_syntaxes() {
        let json = "{ \"a\": \"}\\\"b\", \"x\": [1, {\"b\": 2}],\n  \"b\": [ {\"c\": {}},\n {\"e\": -1.5e3, \"c\": \
            {\"d\": 7}} ] }";
        let at = locate(json, Syntax::Json, &PATH);
        assert!(json[at..].starts_with("\"d\": 7"), "{}", &json[at..]);
        assert_eq!(line_and_column(json, at), (3, 22));
        let toml = "a = 1\n[[b]]\n[[b]]\n  [b.c]\n    d = 7\n";
        assert_eq!(line_and_column(toml, locate(toml, Syntax::Toml, &PATH)), (5, 5));
    }

    #[test]
    fn what_is_missing_is_placed_at_its_table() {
        let json = "{\"b\": [0, {\"x\": 1}]}";
        assert!(json[locate(json, Syntax::Json, &PATH)..].starts_with("{\"x\""));
        let toml = "[[b]]\n[[b]]\nx = 1\n";
        assert_eq!(line_and_column(toml, locate(toml, Syntax::Toml, &PATH)).0, 2);
        assert_eq!(locate("", Syntax::Json, &PATH), 0);
    }
}
