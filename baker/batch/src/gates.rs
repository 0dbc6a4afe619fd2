//! Quality gates: what an asset must be to be taken.

use super::manifest::Gates;
use super::summary::{Figures, Outcome};
use serde::{Deserialize, Serialize};
use volmap_bake::doubt::MAX_SIGN_DISAGREEMENTS;
use volmap_formats::text::{bytes, percent};

/// A gate that an asset doesn't pass.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FailedGate {
    /// It asks whether the map means what the mesh shows, and holds unless the manifest says otherwise.
    pub is_doubt: bool,
    /// Which gate, and why, in words.
    pub text: String,
}

/// The gates that an asset doesn't pass.
pub fn failed(gates: &Gates, figures: &Figures, file_bytes: u64) -> Vec<FailedGate> {
    let doubts = doubts(gates, figures).into_iter().map(|text| FailedGate { is_doubt: true, text });
    let others = refusals(gates, figures, file_bytes).into_iter();
    doubts.chain(others.map(|text| FailedGate { is_doubt: false, text })).collect()
}

/// What comes of an asset that fails these gates; none if there are none.
pub fn outcome(failed: &[FailedGate]) -> Option<Outcome> {
    let doubtful = failed.iter().all(|gate| gate.is_doubt);
    let outcome = if doubtful { Outcome::Doubtful } else { Outcome::Rejected };
    (!failed.is_empty()).then_some(outcome)
}

/// The gates in words.
pub fn texts(failed: &[FailedGate]) -> Vec<String> {
    failed.iter().map(|gate| gate.text.clone()).collect()
}

fn doubts(gates: &Gates, figures: &Figures) -> Vec<String> {
    let mut out = Vec::new();
    if gates.must_have_solid.unwrap_or(true) && !figures.has_solid {
        out.push(
            "must_have_solid: no node lies inside: the map has no solid; give sheets a `thickness`, thin parts smaller \
             cells, or allow it with must_have_solid = false"
                .to_owned(),
        );
    }
    let most = gates.max_sign_disagreements.map_or(MAX_SIGN_DISAGREEMENTS, |most| most.0);
    if figures.sign_doubt > most {
        out.push(format!(
            "max_sign_disagreements: the sign is in doubt at {} of the nodes, more than {}: close the holes, turn the \
             faces one way round, or allow more",
            percent(figures.sign_doubt),
            percent(most)
        ));
    }
    out
}

fn refusals(gates: &Gates, figures: &Figures, file_bytes: u64) -> Vec<String> {
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
