//! Bodies whose surface was moved by a thickness: one solid, by closed forms.

use std::f64::consts::PI;
use std::sync::Arc;
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{InputSettings, from_shape};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_fluid::bodies::{
    Bodies, BodyDescription, ContactMaterial, FluidContact, FreeBody, Mass, Motion, Weight,
};
use volmap_runtime::{DVec3, Pose, Sample, VolumeMap};

const EDGE: f64 = 0.2;
/// An eighth of the support radius, as in scenes.
const CELL: f64 = 0.0125;

/// The map of a shape.
fn baked(shape: &str, thickness: f64, invert: bool, cell: f64) -> VolumeMap {
    let input = from_shape(shape.parse().unwrap(), &InputSettings::default()).unwrap();
    let grid = GridChoice::CellSize(cell);
    let map = MapSettings { support_radius: Some(0.1), grid, thickness, invert, ..MapSettings::default() };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    let asset = bake(input, &settings, &Default::default()).unwrap().asset;
    VolumeMap::from_asset(&asset).unwrap()
}

/// Volume, and the integral of x^2, of all that is nearer than `t` to a cube of edge `a`: Steiner's formula, by the
/// cube, plates on its faces, and the parts of cylinders and a ball at its edges and corners.
fn rounded_cube(a: f64, t: f64) -> [f64; 2] {
    let volume = a.powi(3) + 6.0 * a * a * t + 3.0 * PI * a * t * t + 4.0 / 3.0 * PI * t.powi(3);
    let plates = 2.0 * a * a * ((0.5 * a + t).powi(3) - (0.5 * a).powi(3)) / 3.0 + a.powi(4) * t / 3.0;
    let across = 0.25 * PI * t * t * a * a + 4.0 / 3.0 * a * t.powi(3) + 0.25 * PI * t.powi(4);
    let edges = PI * t * t * a.powi(3) / 12.0 + 2.0 * a * across;
    let corners = PI * t.powi(3) * a * a / 3.0 + 0.5 * PI * a * t.powi(4) + 4.0 / 15.0 * PI * t.powi(5);
    [volume, a.powi(5) / 12.0 + plates + edges + corners]
}

#[test]
fn mass_and_inertia_are_those_of_the_moved_surface() {
    let cube = format!("box:{EDGE},{EDGE},{EDGE}");
    let smaller = |a: f64| [a.powi(3), a.powi(5) / 12.0];
    let ball = |r: f64| [4.0 / 3.0 * PI * r.powi(3), 4.0 / 15.0 * PI * r.powi(5)];
    for (shape, thickness, [volume, square], tolerance) in [
        (cube.as_str(), 0.025, rounded_cube(EDGE, 0.025), 5e-4),
        (cube.as_str(), 0.05, rounded_cube(EDGE, 0.05), 5e-4),
        (cube.as_str(), -0.025, smaller(0.15), 3e-3),
        (cube.as_str(), 0.0, smaller(EDGE), 1e-3),
        ("sphere:0.1", 0.03, ball(0.13), 1e-3),
        ("sphere:0.1", -0.03, ball(0.07), 1e-3),
    ] {
        let mass = Mass::of_map(&baked(shape, thickness, false, CELL), 300.0);
        let off = mass.volume / volume - 1.0;
        assert!(off.abs() < tolerance, "{shape} {thickness}: volume off by {off}");
        assert!((mass.mass - 300.0 * mass.volume).abs() < 1e-12 * mass.mass);
        assert!(mass.centre.length() < 1e-4 * EDGE, "{shape} {thickness}: {}", mass.centre);
        let [x, y, z] = [mass.inertia.x_axis, mass.inertia.y_axis, mass.inertia.z_axis];
        for own in [x.x, y.y, z.z] {
            let off = own / (600.0 * square) - 1.0;
            assert!(off.abs() < 2.0 * tolerance, "{shape} {thickness}: inertia off by {off}");
        }
        assert!(DVec3::new(x.y, y.z, z.x).length() < tolerance * x.x);
    }
}

/// Steiner's formula against sums over points of a lattice.
#[test]
fn rounded_cubes_are_as_points_count_them() {
    let (a, t, n) = (EDGE, 0.05, 200);
    let step = (0.5 * a + t) / f64::from(n);
    let at = |i: i32| (f64::from(i) + 0.5) * step;
    let (mut volume, mut square) = (0.0, 0.0);
    for (x, y) in (0..n).flat_map(|i| (0..n).map(move |j| (at(i), at(j)))) {
        let [u, v] = [x, y].map(|x| (x - 0.5 * a).max(0.0));
        // The height of the solid over the point of a quarter of its section.
        let height = 0.5 * a + (t * t - u * u - v * v).max(0.0).sqrt();
        let height = if u * u + v * v < t * t { height } else { 0.0 };
        volume += 8.0 * height * step * step;
        square += 8.0 * x * x * height * step * step;
    }
    let [exact, exact_square] = rounded_cube(a, t);
    assert!((volume / exact - 1.0).abs() < 1e-3, "{volume} {exact}");
    assert!((square / exact_square - 1.0).abs() < 1e-3, "{square} {exact_square}");
}

fn body(name: &str, map: &Arc<VolumeMap>, at: DVec3, motion: Motion) -> BodyDescription {
    BodyDescription {
        name: name.into(),
        map: map.clone(),
        mesh: None,
        pose: Pose { translation: at, ..Pose::default() },
        motion,
        material: ContactMaterial::default(),
        fluid_contact: FluidContact::default(),
    }
}

/// A cube in a box-shaped container rests where both surfaces touch, wherever a thickness has moved them.
#[test]
fn what_touches_is_the_moved_surface() {
    for (walls, own) in [(0.05, 0.025), (0.05, -0.025), (-0.05, 0.025), (0.0, 0.0)] {
        let tank = Arc::new(baked("box:0.6,0.6,0.6", walls, true, 0.05));
        let cube = Arc::new(baked("box:0.2,0.2,0.2", own, false, 2.0 * CELL));
        let weight = Weight::Density(500.0);
        let free = Motion::Free(FreeBody { weight, ..FreeBody::default() });
        let floor = -0.3 + walls;
        let rest = floor + 0.5 * EDGE + own;
        let start = DVec3::new(0.0, rest + 0.02, 0.0);
        let descriptions =
            vec![body("tank", &tank, DVec3::ZERO, Motion::Static), body("cube", &cube, start, free)];
        let mut bodies = Bodies::new(descriptions, DVec3::new(0.0, -9.81, 0.0)).unwrap();
        let mut seconds = |count: f64| {
            for _ in 0..(500.0 * count) as u32 {
                bodies.step(0.002).unwrap();
            }
            bodies.state(1)
        };
        let (before, state) = (seconds(1.0), seconds(1.0));
        let off = state.centre.y - rest;
        assert!(off.abs() < 1e-3, "walls {walls}, cube {own}: rests {off} m off");
        let gone = state.centre.distance(before.centre);
        assert!(gone < 1e-4, "walls {walls}, cube {own}: goes {gone} m in a second");
        let below = bodies.posed()[0].map.sample(DVec3::new(0.0, floor, 0.0));
        let Sample::Near(surface) = below else { panic!("{below:?}") };
        assert!(surface.distance.abs() < 1e-9, "the fluid's floor is {} m off", surface.distance);
    }
}
