//! Pictures: what is in them, and that they don't depend on threads.

use super::scene::{Scene, world};
use std::path::PathBuf;
use volmap_figures::picture::png;
use volmap_runtime::DVec3;
use volmap_scenes::output::Frame;
use volmap_scenes::output::picture::{Camera, ColourBy, Painter, PictureSettings, Style};

/// Leaves a picture in `target/tmp/simulation`, to be looked at.
pub fn keep(name: &str, file: &[u8]) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("simulation");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(name), file).unwrap();
}

#[test]
fn waves_are_drawn() {
    let scene = Scene::new(0.016, 0.4);
    let camera = Camera { position: [2.6, 1.9, 2.4], target: [0.2, 0.4, 0.0], field_of_view: 35.0 };
    let usual = PictureSettings::default;
    for (name, settings) in [
        ("surface.png", usual()),
        ("particles.png", PictureSettings { style: Style::Particles, ..usual() }),
        ("pressure.png", PictureSettings { colour: ColourBy::Pressure, ..usual() }),
        ("camera.png", PictureSettings { camera: Some(camera), width: 1000, height: 1000, ..usual() }),
    ] {
        let file = Painter::new(&settings, world()).draw(&scene.frame(10));
        keep(name, &file);
        let (size, rgb) = png::decode(&file).unwrap();
        assert_eq!(size, [settings.width, settings.height]);
        let pixels = rgb.as_chunks::<3>().0;
        let yellow = pixels.iter().filter(|[r, g, b]| *r > 150 && *g > 90 && *b < 90).count();
        let least = if settings.colour == ColourBy::Speed { pixels.len() / 20 } else { 0 };
        let bluish = pixels.iter().filter(|[r, _, b]| u16::from(*b) > u16::from(*r) + 40).count();
        assert!(yellow > pixels.len() / 400, "{name}: {yellow} pixels of the duck");
        assert!(bluish > least, "{name}: {bluish} pixels of water");
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let scene = Scene::new(0.04, 0.2);
    let settings = PictureSettings { width: 500, height: 333, ..PictureSettings::default() };
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut painter = Painter::new(&settings, world());
            // A painter that has drawn something else draws the same.
            painter.draw(&Scene::new(0.05, 0.0).frame(1));
            painter.draw(&scene.frame(10))
        })
    };
    let one = draw(1);
    assert!(one == draw(3) && one == Painter::new(&settings, world()).draw(&scene.frame(10)));
}

#[test]
fn any_numbers_are_drawn() {
    let odd = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e300, 0.0, 1e-300, 1e10];
    let positions: Vec<DVec3> =
        (0..512).map(|n| DVec3::new(odd[n % 8], odd[n / 8 % 8], odd[n / 64])).collect();
    let velocities: Vec<[f32; 3]> = positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let empty = Scene::new(0.05, 0.0);
    for (radius, range) in
        [(0.025, None), (0.0, Some([0.0, 0.0])), (1e30, Some([f64::NAN, 1.0])), (f64::NAN, None)]
    {
        for camera in [None, Some(Camera { position: [0.0; 3], target: [0.0; 3], field_of_view: f64::NAN })] {
            let frame = Frame {
                particle_radius: radius,
                positions: &positions,
                velocities: &velocities,
                density: &[],
                bodies: &[],
                ..empty.frame(0)
            };
            let settings =
                PictureSettings { width: 0, height: 65, camera, range, ..PictureSettings::default() };
            let file = Painter::new(&settings, world()).draw(&frame);
            assert_eq!(png::size(&file), Some([64, 65]));
        }
    }
}

#[test]
fn nothing_is_drawn_of_nothing() {
    let empty = Scene::new(0.05, 0.0);
    let frame = Frame { positions: &[], velocities: &[], bodies: &[], ..empty.frame(0) };
    let mut nothing = world();
    nothing.props.clear();
    nothing.bounds = volmap_scenes::output::picture::Bounds::EMPTY;
    let file = Painter::new(&PictureSettings::default(), nothing).draw(&frame);
    keep("nothing.png", &file);
    assert!(png::decode(&file).is_some());
}
