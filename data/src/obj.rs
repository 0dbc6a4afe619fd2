//! Wavefront OBJ text: positions with 5 decimals (10 micrometres) and triangles, nothing else.

use std::fmt::Write;

use crate::mesh::Mesh;

/// The mesh as the text of an OBJ file, with `title` in a comment at its head.
pub fn to_text(mesh: &Mesh, title: &str) -> String {
    let mut text =
        format!("# {title}\n# Made by volmap-make-data. Units: metres. Public domain (CC0 1.0).\n");
    for v in &mesh.vertices {
        let [x, y, z] = v.to_array().map(coordinate);
        writeln!(text, "v {x} {y} {z}").expect("a String takes any text");
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a String takes any text");
    }
    text
}

/// Five decimals at most, without trailing zeros and without a negative zero.
fn coordinate(value: f64) -> String {
    let text = format!("{value:.5}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}
