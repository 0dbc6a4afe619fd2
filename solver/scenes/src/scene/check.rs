//! Checks of values that belong together.

use super::Scene;
use volmap_bake::density_map::KERNELS;
use volmap_documents::{At, Checked};
use volmap_fluid::forces::ForceSettings;
use volmap_fluid::forces::viscosity::viscous_limit;
use volmap_fluid::rest::calm_radii;
use volmap_fluid::settings::{
    BoundaryMethod, FluidSettings, MOST_RELAXATION, SolveSettings, SolverSettings, World,
};
use volmap_formats::text::number;
use volmap_runtime::KernelKind;

/// Whether water at rest stays calm with the kernel and its support radius.
pub(super) fn kernel(at: &At, scene: &Scene) -> Checked {
    let (kernel, radius) = (scene.kernel, scene.support_radius());
    let Some([least, most]) = calm_radii(kernel) else {
        let reason = format!(
            "water doesn't stay at rest with {kernel}; take {}, {} or {}",
            KernelKind::CubicSpline,
            KernelKind::WendlandC2,
            KernelKind::Spiky
        );
        return Err(at.problem("kernel", reason));
    };
    let ratio = radius / scene.particle_radius;
    at.require("support_radius", ratio >= least * (1.0 - 1e-9), || {
        format!(
            "{radius} m is {ratio:.2} particle radii; kernel {kernel} needs {least} to {most}, as a rule 4: with fewer \
             neighbours water at rest hasn't the pressure of its depth"
        )
    })?;
    at.require("support_radius", ratio <= most * (1.0 + 1e-9), || {
        let cure = match kernel {
            KernelKind::CubicSpline => ": with more, water doesn't stay at rest; kernel = \"wendland_c2\" takes more",
            _ => "",
        };
        format!(
            "{radius} m is {ratio:.2} particle radii; kernel {kernel} takes {least} to {most}, as a rule 4{cure}"
        )
    })
}

/// Whether the boundary's method goes with the other settings, and has what it needs.
pub(super) fn boundary(at: &At, scene: &Scene) -> Checked {
    let method = scene.boundary;
    at.require("closure", method == BoundaryMethod::VolumeMap || scene.closure.is_none(), || {
        "belongs to volume maps; leave it out, or take boundary = \"volume_map\"".into()
    })?;
    at.require(
        "boundary_sampling",
        method == BoundaryMethod::Particles || scene.boundary_sampling.is_none(),
        || "belongs to boundary particles; leave it out, or take boundary = \"particles\"".into(),
    )?;
    let is_baked = KERNELS.contains(&scene.world().kernel);
    at.require("kernel", method != BoundaryMethod::DensityMap || is_baked, || {
        let known = KERNELS.map(KernelKind::name).join(" and ");
        format!("density maps are baked for {known} only; take one of them, or another boundary")
    })?;
    if method == BoundaryMethod::Particles {
        for (i, body) in scene.bodies.iter().enumerate() {
            let at = at.key("bodies").item(i);
            at.require("map", body.map.is_none(), || {
                "boundary = \"particles\" samples the body's mesh, which a map hasn't; give `mesh` instead"
                    .into()
            })?;
            let at = at.key("bake");
            at.require("thickness", body.bake.thickness.is_none_or(|length| length == 0.0), || {
                "moves a map's surface, but boundary = \"particles\" samples the mesh; take 0".into()
            })?;
        }
    }
    Ok(())
}

pub(super) fn fluid(at: &At, fluid: &FluidSettings) -> Checked {
    at.positive("rest_density", fluid.rest_density)?;
    at.not_negative("viscosity", fluid.viscosity)?;
    at.within("xsph", fluid.xsph, [0.0, 1.0])?;
    at.within("volume_factor", fluid.volume_factor, [0.1, 2.0])
}

pub(super) fn solver(at: &At, solver: &SolverSettings) -> Checked {
    solve(&at.key("density"), &solver.density)?;
    solve(&at.key("divergence"), &solver.divergence)?;
    let viscosity = at.key("viscosity");
    viscosity.positive("max_error", solver.viscosity.max_error)?;
    viscosity.require("max_iterations", solver.viscosity.max_iterations > 0, || {
        "0 iterations solve nothing; viscosity = 0 of the fluid does".into()
    })?;
    viscosity.require("max_passes", solver.viscosity.max_passes > 0, || {
        "0 passes solve nothing; 1 solves for viscosity and density once each".into()
    })?;
    at.positive("relaxation", solver.relaxation)?;
    at.require("relaxation", solver.relaxation <= MOST_RELAXATION, || {
        let given = number(solver.relaxation);
        format!("{given} is more than {MOST_RELAXATION}: the fluid would gain energy and burst")
    })?;
    at.within("warm_start", solver.warm_start, [0.0, 1.0])?;
    let (at, step) = (at.key("time_step"), &solver.time_step);
    at.positive("min", step.min)?;
    at.positive("max", step.max)?;
    at.positive("initial", step.initial)?;
    at.positive("cfl_factor", step.cfl_factor)?;
    at.require("min", step.min <= step.max, || format!("{} s is more than max, {} s", step.min, step.max))?;
    let inside = !step.adaptive || (step.min..=step.max).contains(&step.initial);
    at.require("initial", inside, || {
        format!("{} s is not within min, {} s, to max, {} s", step.initial, step.min, step.max)
    })
}

pub(super) fn forces(at: &At, forces: &ForceSettings) -> Checked {
    forces.check().map_err(|(force, defect)| at.key(force).problem(defect.key, defect.reason))
}

/// Whether explicit viscosity is stable in the smallest step that may be taken.
pub(super) fn viscosity(at: &At, fluid: &FluidSettings, solver: &SolverSettings, world: &World) -> Checked {
    let limit = viscous_limit(fluid, world);
    let step = &solver.time_step;
    let (key, least) = if step.adaptive { ("min", step.min) } else { ("initial", step.initial) };
    let default = if fluid.viscosity == FluidSettings::default().viscosity { ", the default," } else { "" };
    at.require("viscosity", least <= limit, || {
        format!(
            "{} m^2/s{default} needs time steps of at most {limit:.2e} s; solver.time_step.{key} is {least:e} s; \
             viscosity_method = \"implicit\" takes longer ones",
            fluid.viscosity
        )
    })
}

fn solve(at: &At, solve: &SolveSettings) -> Checked {
    at.positive("max_error", solve.max_error)?;
    at.require("max_iterations", solve.max_iterations > 0, || {
        "0 iterations solve nothing; enabled = false does".into()
    })?;
    at.require("min_iterations", solve.min_iterations <= solve.max_iterations, || {
        format!("{} is more than max_iterations, {}", solve.min_iterations, solve.max_iterations)
    })
}
