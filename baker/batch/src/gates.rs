//! Quality gates: what an asset must be to be taken.

use super::manifest::Gates;
use super::summary::Figures;
use volmap_formats::text::{bytes, percent};

/// The gates that an asset doesn't pass, in words.
pub fn failed(gates: &Gates, figures: &Figures, file_bytes: u64) -> Vec<String> {
    let mut out = Vec::new();
    if gates.must_be_closed == Some(true) && !figures.closed {
        out.push("must_be_closed: the mesh is open".to_owned());
    }
    if let Some(most) = gates.max_bytes.filter(|most| file_bytes > most.0) {
        out.push(format!("max_bytes: the file has {}, more than {}", bytes(file_bytes), bytes(most.0)));
    }
    if let Some(most) = gates.max_error {
        match figures.volume_error_max {
            Some(error) if error <= most.0 => {}
            Some(error) => out.push(format!(
                "max_error: the volume is wrong by up to {} of the ball, more than {}",
                percent(error),
                percent(most.0)
            )),
            None => out.push("max_error: the error wasn't measured".to_owned()),
        }
    }
    out
}
