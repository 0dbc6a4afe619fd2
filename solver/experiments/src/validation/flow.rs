//! Water for the experiments, and measurements of bodies in it.

use volmap_fluid::Error;
use volmap_fluid::bodies::{Bodies, BodyDescription};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{FluidSettings, SolverSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::simulation::Simulation;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, Pose};

/// Gravity's acceleration, m/s^2.
pub const GRAVITY: f64 = 9.81;

/// The lattice of particles at rest in a box.
pub fn lattice(min: DVec3, max: DVec3, particle_radius: f64) -> Vec<DVec3> {
    fill_box([min, max], 2.0 * particle_radius).collect()
}

/// Water at rest at these positions (metres) with a viscosity (m^2/s), the default kernel and a support radius of 4 rp.
///
/// # Errors
/// As [`liquid_of`].
pub fn water(
    particle_radius: f64,
    places: &[DVec3],
    viscosity: f64,
    bodies: Vec<BodyDescription>,
) -> Result<Simulation, Error> {
    let world = World { particle_radius, support_radius: 4.0 * particle_radius, ..World::default() };
    let fluid = FluidSettings { viscosity, ..FluidSettings::default() };
    liquid_of(world, fluid, places, bodies)
}

/// The same of any kernel and fluid, under the default gravity.
///
/// # Errors
/// As [`Bodies::new`].
pub fn liquid_of(
    world: World,
    fluid: FluidSettings,
    places: &[DVec3],
    bodies: Vec<BodyDescription>,
) -> Result<Simulation, Error> {
    let mut particles = Particles::default();
    particles.add(places, &vec![[0.0; 3]; places.len()]);
    let bodies = Bodies::new(bodies, world.gravity)?;
    Simulation::new(Setup {
        fluid,
        solver: solver(world.particle_radius),
        ..Setup::new(world, particles, bodies)
    })
}

/// The default solver, with time steps scaled as the time of a fall by a particle radius.
pub fn solver(particle_radius: f64) -> SolverSettings {
    let mut solver = SolverSettings::default();
    let scale = (particle_radius / 0.025).sqrt();
    let time_step = &mut solver.time_step;
    time_step.initial *= scale;
    time_step.max *= scale;
    time_step.min = 1e-6;
    solver
}

/// Volume of the part of a closed mesh that lies below a level, m^3: the flux of (0, y - level, 0) through its surface
/// there, as the field vanishes on the cut.
pub fn volume_below(mesh: &TriangleMesh, pose: Pose, level: f64) -> f64 {
    let flux = |&[a, b, c]: &[DVec3; 3]| {
        let height = (a.y + b.y + c.y) / 3.0 - level;
        0.5 * (b - a).cross(c - a).y * height
    };
    let corner = |n: u32| pose.to_world(mesh.vertices[n as usize].into());
    let triangles = mesh.triangles.iter().map(|corners| corners.map(corner));
    triangles.flat_map(|triangle| below(triangle, level)).map(|part| flux(&part)).sum()
}

/// The part of a triangle below a level, as triangles.
fn below(triangle: [DVec3; 3], level: f64) -> Vec<[DVec3; 3]> {
    let mut polygon: Vec<DVec3> = Vec::with_capacity(4);
    for (n, &from) in triangle.iter().enumerate() {
        let to = triangle[(n + 1) % 3];
        if from.y <= level {
            polygon.push(from);
        }
        if (from.y <= level) != (to.y <= level) {
            polygon.push(from.lerp(to, (level - from.y) / (to.y - from.y)));
        }
    }
    polygon.windows(2).skip(1).map(|edge| [polygon[0], edge[0], edge[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use volmap_fluid::shapes::{ball, cuboid};
    use volmap_runtime::DQuat;

    #[test]
    fn a_ball_is_under_water_as_its_caps_formula_says() {
        let ball = ball(1.0, 5);
        for level in [-1.5, -0.6, 0.0, 0.3, 1.2] {
            let pose = Pose { translation: DVec3::new(3.0, 2.0, 1.0), ..Pose::default() };
            let height = (1.0_f64 + level).clamp(0.0, 2.0);
            let cap = PI * height * height * (3.0 - height) / 3.0;
            assert!((volume_below(&ball, pose, 2.0 + level) - cap).abs() < 1e-2, "{level}");
        }
    }

    #[test]
    fn a_turned_box_is_half_under_water_at_its_middle() {
        let cube = cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
        let pose =
            Pose { rotation: DQuat::from_rotation_x(0.6) * DQuat::from_rotation_z(0.3), ..Pose::default() };
        assert!((volume_below(&cube, pose, 0.0) - 0.5).abs() < 1e-12);
        assert!((volume_below(&cube, pose, 2.0) - 1.0).abs() < 1e-12);
        assert_eq!(volume_below(&cube, pose, -2.0), 0.0);
    }
}
