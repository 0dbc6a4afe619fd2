//! A lattice of particles from wall to wall begins at rest, whatever the kernel and its support radius.

use volmap_fluid::bodies::{Bodies, Motion};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{BoundaryMethod, FluidSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{Shape, baked, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DVec3, KernelKind};

const RP: f64 = 0.025;
const RADII: [f64; 5] = [3.0, 3.5, 4.0, 4.5, 5.0];

fn world(kernel: KernelKind, radii: f64) -> World {
    World { kernel, particle_radius: RP, support_radius: radii * RP, ..World::default() }
}

/// A tank of half a metre for a support radius (rp).
fn shape(radii: f64) -> Shape {
    baked(cuboid(DVec3::ZERO, DVec3::new(0.5, 0.7, 0.5)), radii * RP, true).unwrap()
}

/// That tank, filled with so many layers.
fn tank(world: World, shape: &Shape, layers: u32) -> Simulation {
    let bodies = vec![shape.body("tank", DVec3::ZERO, Motion::Static)];
    let bodies = Bodies::new(bodies, world.gravity).unwrap();
    let top = DVec3::new(0.5, 2.0 * RP * f64::from(layers), 0.5);
    let places: Vec<DVec3> = fill_box([DVec3::ZERO, top], 2.0 * RP).collect();
    let mut particles = Particles::default();
    particles.add(&places, &vec![[0.0; 3]; places.len()]);
    Simulation::new(Setup::new(world, particles, bodies)).unwrap()
}

#[test]
fn a_full_lattice_has_the_rest_density() {
    for radii in RADII {
        let shape = shape(radii);
        for kernel in KernelKind::ALL {
            let mut simulation = tank(world(kernel, radii), &shape, 10);
            simulation.step().unwrap();
            // By densities of the beginning: the step moved particles by less than a thousandth of rp.
            let of = |x: &DVec3| [x.x, 0.5 - x.x, x.z, 0.5 - x.z, x.y].into_iter().fold(1.0, f64::min);
            let near = simulation.particles().positions.iter().zip(simulation.densities());
            let near: Vec<(f64, f32, f64)> = near.map(|(x, &d)| (of(x), d, x.y)).collect();
            let inner: Vec<f32> = near
                .iter()
                .filter(|(wall, _, y)| *wall > radii * RP && *y < 0.5 - radii * RP)
                .map(|(_, density, _)| *density)
                .collect();
            assert!(!inner.is_empty());
            // The default's 0.99997 is left as it is.
            assert!(inner.iter().all(|d| (d - 1.0).abs() < 1e-4), "{kernel}, {radii}: {inner:?}");
            // Nowhere is it much denser: the image of closure `mirror` is of layers, not of points.
            let most = near.iter().map(|(_, density, _)| *density).fold(0.0, f32::max);
            assert!(most < 1.04, "{kernel}, {radii}: {most}");
        }
    }
}

#[test]
fn it_stays_as_calm_as_with_the_default_kernel() {
    for radii in RADII {
        let shape = shape(radii);
        for kernel in KernelKind::ALL {
            let mut simulation = tank(world(kernel, radii), &shape, 6);
            let (mut speed, mut density) = (0.0_f64, 0.0_f64);
            while simulation.time() < 0.25 {
                let report = simulation.step().unwrap();
                speed = speed.max(report.max_speed);
                density = density.max(report.compression.largest);
            }
            // Particles that burst have 5 m/s and more.
            assert!(speed < 1.0 && density < 0.05, "{kernel}, {radii} rp: {speed} m/s, {density}");
        }
    }
}

#[test]
fn densities_of_all_boundaries_are_by_the_fluids_kernel() {
    // A particle at rp from a wall: what the wall adds is in proportion to 1 / S, beside what the closure itself makes
    // of a kernel that is as wide.
    let sum = world(KernelKind::Spiky, 4.0).rest_sum(&FluidSettings::default());
    assert!((1.2..1.3).contains(&sum), "{sum}");
    for closure in [ClosureKind::Mirror, ClosureKind::Calibrated] {
        for boundary in [BoundaryMethod::VolumeMap, BoundaryMethod::TubeMap] {
            let world = World { closure, boundary, ..world(KernelKind::Spiky, 4.0) };
            let map = world.map_closure();
            let size = DVec3::splat(0.5);
            let hollow = cuboid(DVec3::ZERO, size);
            let shape = volmap_fluid::shapes::baked_for(map, hollow, world.support_radius, true).unwrap();
            let at = DVec3::new(0.25, RP, 0.25);
            let plain = match boundary {
                BoundaryMethod::VolumeMap => {
                    let closure = shape.map.closure(closure, world.kernel_of_size(), RP).unwrap();
                    closure.density(&shape.map.sample(at).near().unwrap(), at).unwrap().density
                }
                _ => {
                    let kernel = world.kernel;
                    volmap_fluid::boundary::tube_map::density(kernel, RP / world.support_radius, [0.0; 2])[0]
                }
            };
            let bodies = vec![shape.body("tank", DVec3::ZERO, Motion::Static)];
            let bodies = Bodies::new(bodies, DVec3::ZERO).unwrap();
            let mut boundary =
                volmap_fluid::boundary::Boundary::new(&world, &FluidSettings::default(), &bodies).unwrap();
            boundary.sample_alone(&bodies, &[at]);
            let found = f64::from(boundary.of_particle[0].density) * sum / plain;
            assert!((found - 1.0).abs() < 0.02, "{closure} {:?}: {found}", world.boundary);
        }
    }
}
