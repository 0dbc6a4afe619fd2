//! Defaults that would contradict what a scene gives: they give way, with a note.

use super::Scene;
use serde::Deserialize;
use serde::de::IgnoredAny;
use volmap_fluid::forces::viscosity::viscous_limit;
use volmap_fluid::settings::ViscosityMethod;
use volmap_formats::text::number;

/// Whether a scene's file gives a key.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Given {
    fluid: GivenFluid,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct GivenFluid {
    viscosity: Option<IgnoredAny>,
    viscosity_method: Option<IgnoredAny>,
}

/// The default viscosity is explicit, and needs the shorter steps the smaller the particles are. Where the smallest
/// step is longer it is taken implicitly.
pub(super) fn adapt(scene: &mut Scene, given: &Given) {
    let GivenFluid { viscosity, viscosity_method } = &given.fluid;
    if viscosity.is_some() || viscosity_method.is_some() {
        return;
    }
    let step = &scene.solver.time_step;
    let least = if step.adaptive { step.min } else { step.initial };
    let limit = viscous_limit(&scene.fluid, &scene.world());
    if least > limit {
        scene.fluid.viscosity_method = ViscosityMethod::Implicit;
        scene.notes.push(format!(
            "fluid.viscosity isn't given: its default, {} m^2/s, is solved for implicitly here, as explicitly it needs \
             time steps of at most {} s; water has 1e-6",
            scene.fluid.viscosity,
            number(limit)
        ));
    }
}
