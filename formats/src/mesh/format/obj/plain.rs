//! The lines that nearly all of an OBJ consists of, in one pass: `v 1.5 0 -2` and `f 1/1 2/2 3/3`.
//!
//! Whatever is unusual (comments, continued lines, errors) is left to the general
//! reader, which starts the line again: `None`. What is read is the same either way.

use crate::mesh::text::number_at_start;

/// A vertex: what follows the `v`, and where the line ends.
pub fn vertex(bytes: &[u8]) -> Option<([f64; 3], usize)> {
    let mut at = 0;
    let mut position = [0.0; 3];
    for c in &mut position {
        at = blanks(bytes, at);
        let (value, length) = number_at_start(&bytes[at..])?;
        *c = value;
        at += length;
        if !ends_word(bytes, at) {
            return None;
        }
    }
    Some((position, ignored(bytes, at)?))
}

/// A face: the corners that follow the `f`, and where the line ends. `count` vertices came before.
pub fn face(bytes: &[u8], count: usize, corners: &mut Vec<u32>) -> Option<usize> {
    corners.clear();
    let mut at = 0;
    loop {
        at = blanks(bytes, at);
        if ends_line(bytes, at) {
            return Some(at);
        }
        let backwards = bytes[at] == b'-';
        let start = at + usize::from(backwards);
        let (number, end) = digits(bytes, start);
        if end > start + 18 {
            return None;
        }
        at = end;
        let number = number as i64;
        corners.push(vertex_index(if backwards { -number } else { number }, count)?);
        if bytes.get(at) == Some(&b'/') {
            at = skip_references(bytes, at)?;
        }
        if !ends_word(bytes, at) {
            return None;
        }
    }
}

/// The whole number that starts at `at`, which may wrap, and where it ends.
fn digits(bytes: &[u8], mut at: usize) -> (u64, usize) {
    let mut number = 0u64;
    while let Some(digit) = bytes.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|&digit| digit < 10) {
        number = number.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    (number, at)
}

/// v counts from 1, or backwards from -1.
pub fn vertex_index(v: i64, count: usize) -> Option<u32> {
    let index = match v {
        1.. => v - 1,
        0 => return None,
        _ => count as i64 + v,
    };
    u32::try_from(index).ok().filter(|&index| index < u32::MAX)
}

/// Past the texture coordinate and normal of a corner.
fn skip_references(bytes: &[u8], mut at: usize) -> Option<usize> {
    while !ends_word(bytes, at) {
        if matches!(bytes[at], b'#' | b'\\') {
            return None;
        }
        at += 1;
    }
    Some(at)
}

/// Where a line ends whose rest doesn't matter, unless it goes on in the next.
fn ignored(bytes: &[u8], mut at: usize) -> Option<usize> {
    let start = at;
    while !ends_line(bytes, at) {
        at += 1;
    }
    (!bytes[start..at].trim_ascii_end().ends_with(b"\\")).then_some(at)
}

fn blanks(bytes: &[u8], mut at: usize) -> usize {
    while matches!(bytes.get(at), Some(b' ' | b'\t' | b'\x0C')) {
        at += 1;
    }
    at
}

fn ends_word(bytes: &[u8], at: usize) -> bool {
    bytes.get(at).is_none_or(u8::is_ascii_whitespace)
}

fn ends_line(bytes: &[u8], at: usize) -> bool {
    matches!(bytes.get(at), None | Some(b'\n' | b'\r'))
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;

    #[test]
    fn plain_lines_are_read_and_others_left() {
        let mut corners = Vec::new();
        assert_eq!(vertex(b" 1.5\t-2e1  .25 1 0 0\r\nv"), Some(([1.5, -20.0, 0.25], 20)));
        assert_eq!(face(b" 1/2/3 2//3 -1 4\nf", 9, &mut corners), Some(16));
        assert_eq!(corners, [0, 1, 8, 3]);
        assert_eq!(face(b"", 9, &mut corners), Some(0));
        for line in [" 1 2", " 1 2 nan", " 1 2 3#", " 1 2 3 \\\n4", " 1 2 1e101", " 1,5 2 3"] {
            assert_eq!(vertex(line.as_bytes()), None, "{line}");
        }
        for line in [" 0 1 2", " 1 2 3#", " 1 2/\\\n3", " 1 2 3 \\\n4", " +1 2 3", " 1 2 1234567890123456789"]
        {
            assert_eq!(face(line.as_bytes(), 9, &mut corners), None, "{line}");
        }
    }

    /// A comment makes any line an unusual one.
    #[test]
    fn both_ways_read_the_same() {
        let lines = "v 1 2 3\nv 0.25 -1e-3 7.0\nv\t1 2\t3 4 \nv 0 0 1\nf 1 2 3\nf 4/1 3/1/1 2//7 1\nf -1 -2 -4\n\
                     f 1 2\nf 1\nf \nf 5 1 2\nv 9 9 9\n";
        let commented = lines.replace('\n', " #\n");
        let (plain, general) = (read(lines.as_bytes()).unwrap(), read(commented.as_bytes()).unwrap());
        assert_eq!(plain, general);
        assert_eq!((plain.positions.len(), plain.faces.len(), plain.skipped.total()), (5, 4, 3));
    }
}
