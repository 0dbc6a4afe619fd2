//! Words and numbers of a text format, with line numbers.

use super::error::MeshError;
use super::raw::MAX_COORDINATE;
use crate::text::quoted;

/// A place in a text: words are separated by blanks and line ends (`\n`, `\r\n` or `\r`).
#[derive(Clone)]
pub struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    format: &'static str,
}

impl<'a> Words<'a> {
    pub fn new(bytes: &'a [u8], format: &'static str) -> Words<'a> {
        let at = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
        Words { bytes, at, line: 1, format }
    }

    pub fn bad(&self, problem: impl Into<String>) -> MeshError {
        MeshError::malformed(self.format, format!("line {}", self.line), problem)
    }

    /// The bytes that were not read yet.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The line of what comes next, counted from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// Byte offset from the start of the file.
    pub fn offset(&self) -> usize {
        self.at
    }

    /// Goes on after `count` bytes of binary data.
    pub fn skip_bytes(&mut self, count: usize) {
        self.at = (self.at + count).min(self.bytes.len());
    }

    /// Goes on in the next line, if this one ends after `length` bytes.
    pub fn finish_line(&mut self, length: usize) {
        self.at += length;
        debug_assert!(matches!(self.rest().first(), None | Some(b'\n' | b'\r')));
        self.next_line();
    }

    /// The next line without its end, or `None` at the end of the file.
    pub fn next_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let Some(end) = end else {
            self.at = self.bytes.len();
            return Some(rest);
        };
        let crlf = rest[end] == b'\r' && rest.get(end + 1) == Some(&b'\n');
        self.at += end + 1 + usize::from(crlf);
        self.line += 1;
        Some(&rest[..end])
    }

    /// The next word, on whatever line.
    pub fn next(&mut self) -> Option<&'a [u8]> {
        while let Some(&byte) = self.bytes.get(self.at) {
            if !byte.is_ascii_whitespace() {
                break;
            }
            let crlf = byte == b'\r' && self.bytes.get(self.at + 1) == Some(&b'\n');
            self.line += usize::from(byte == b'\n' || (byte == b'\r' && !crlf));
            self.at += 1;
        }
        let rest = self.rest();
        let end = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..end.unwrap_or(rest.len())];
        self.at += word.len();
        (!word.is_empty()).then_some(word)
    }

    /// The next word, which must be there.
    pub fn word(&mut self, what: &str) -> Result<&'a [u8], MeshError> {
        self.next().ok_or_else(|| self.bad(ends_early(what)))
    }

    /// The next word as a number that is finite and not beyond 1e100.
    pub fn number(&mut self, what: &str) -> Result<f64, MeshError> {
        let word = self.word(what)?;
        number(word).ok_or_else(|| self.bad(not_a_number(word, what)))
    }

    /// The next word as a whole number.
    pub fn count(&mut self, what: &str) -> Result<usize, MeshError> {
        let word = self.word(what)?;
        parse(word).ok_or_else(|| self.bad(format!("`{}` is not a whole number ({what})", show(word))))
    }

    /// Checks that `count` items of at least `size` bytes can still follow.
    pub fn room_for(&self, count: usize, size: usize, what: &str) -> Result<(), MeshError> {
        // The last word of a file needs no separator.
        let left = self.rest().len() + 1;
        match count.checked_mul(size) {
            Some(bytes) if bytes <= left => Ok(()),
            _ => Err(self.bad(format!(
                "{count} {what} are announced, but only {} bytes follow; the file was cut or its \
                 header is damaged: export it again",
                self.rest().len()
            ))),
        }
    }
}

pub fn ends_early(what: &str) -> String {
    format!("the file ends where {what} was expected; it was cut: export or download it again")
}

pub fn not_a_number(word: &[u8], what: &str) -> String {
    let hint = match any_number(word) {
        Some(_) => "is not finite or beyond 1e100; repair this value",
        None if word.contains(&b',') => {
            "is not a number; export again with a decimal point instead of a comma"
        }
        None => "is not a number; the line is damaged: export the file again",
    };
    format!("`{}` {hint} ({what})", show(word))
}

/// A word of a file, for a message: short, printable.
pub fn show(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = quoted(&String::from_utf8_lossy(&word[..word.len().min(LONGEST)]), LONGEST);
    if word.len() > LONGEST { text + "..." } else { text }
}

pub fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

pub fn any_number(word: &[u8]) -> Option<f64> {
    if let Some(value) = decimal(word) {
        return Some(value);
    }
    // C writes NaN in more ways than Rust reads.
    let lower = word.to_ascii_lowercase();
    let sign = lower.strip_prefix(b"-").unwrap_or(&lower);
    if sign.starts_with(b"nan") || sign.starts_with(b"1.#") {
        return Some(f64::NAN);
    }
    None
}

pub fn number(word: &[u8]) -> Option<f64> {
    decimal(word).filter(|value: &f64| value.abs() <= MAX_COORDINATE)
}

fn decimal(word: &[u8]) -> Option<f64> {
    fast_float2::parse(word).ok().or_else(|| fortran(word))
}

/// Fortran writes double precision as `1.0D+00`.
fn fortran(word: &[u8]) -> Option<f64> {
    let at = word.iter().position(|b| matches!(b, b'd' | b'D'))?;
    let mut word = word.to_vec();
    word[at] = b'e';
    fast_float2::parse(&word).ok()
}

/// The number that a text starts with, finite and not beyond 1e100, and its length. What follows is for the caller to
/// judge.
#[inline]
pub fn number_at_start(bytes: &[u8]) -> Option<(f64, usize)> {
    fast_float2::parse_partial(bytes).ok().filter(|(value, _): &(f64, usize)| value.abs() <= MAX_COORDINATE)
}

/// A text without its byte order mark.
pub fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Where `needle` starts.
pub fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    bytes.windows(needle.len()).position(|window| window == needle)
}

/// Words of one line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn agrees(word: &str) {
        let expected: Option<f64> = word.parse().ok().filter(|value: &f64| value.abs() <= MAX_COORDINATE);
        assert_eq!(number(word.as_bytes()).map(f64::to_bits), expected.map(f64::to_bits), "{word}");
        let (value, length) = number_at_start(format!("{word} 1").as_bytes()).unzip();
        if let Some(expected) = expected {
            assert_eq!(
                (value.map(f64::to_bits), length),
                (Some(expected.to_bits()), Some(word.len())),
                "{word}"
            );
        }
    }

    #[test]
    fn numbers_of_all_kinds_are_read_and_rounded_correctly() {
        let words = "0 -0 +1 1. .5 -.25 007 0.1 -123.456 1e5 1E-5 2.5e+07 9007199254740993 9007199254740992e22 1e23 \
                     1e-23 1.7e-21 0.000000000000000001 0.30000000000000004 18446744073709551616 1e99999 1e-99999 \
                     4.9e-324 1e100 1.0000000000000001e100 1.0000000000000002e100";
        let others = "- + . e5 1e 1e+ nan -inf infinity -.e1 1_0 0x1 1d d5 1d5d --1 +-1";
        others.split_ascii_whitespace().for_each(agrees);
        words.split_ascii_whitespace().for_each(agrees);
        assert_eq!(
            ["1.0D+00", "-2.5d-1", "1d5"].map(|word| number(word.as_bytes()).unwrap()),
            [1.0, -0.25, 1e5]
        );
        assert_eq!(number_at_start(b"1.5/2"), Some((1.5, 3)));
        assert_eq!(number_at_start(b"nan 1"), None);
        assert!(number(b"").is_none() && any_number(b"-1.#IND").is_some_and(f64::is_nan));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn decimals_agree_with_the_standard_library(word in "[-+]?[0-9]{0,25}\\.?[0-9]{0,25}([eE][-+]?[0-9]{1,3})?") {
            agrees(&word);
        }

        #[test]
        fn every_number_comes_back(value in any::<f64>(), single in any::<f32>()) {
            for text in [format!("{value:?}"), format!("{value:.17e}"), format!("{single:?}"), format!("{single:.6}")] {
                agrees(&text);
            }
        }
    }
}
