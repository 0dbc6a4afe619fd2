//! Pictures of every kind. They are left in the tests' folder (target/tmp/pictures), to be looked at.

use glam::DVec3;
use std::path::Path;
use volmap_figures::picture::colours::{BLACK, DISTINCT};
use volmap_figures::picture::{
    At, Axis, Category, Chart, ChartAxis, ColourMap, Colouring, Data, Figure, Limits, Line, Mark, Marker,
    Panel, Pixel, PixelLattice, Plane, Quantity, Raster, Series, contours, png,
};

fn save(name: &str, file: &[u8]) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(name), file).unwrap();
}

/// A ball of radius 0.5, its band of 0.3 and a wave for an error, on a plane.
fn panel(edges: DVec3, pixels: usize, colouring: Colouring, value: fn(DVec3) -> f64) -> Panel {
    let plane = Plane { axis: Axis::Z, at: 0.0 };
    let lattice = PixelLattice::over(plane, -0.5 * edges, 0.5 * edges, pixels);
    let phi: Vec<f64> = lattice.points().iter().map(|p| p.length() - 0.5).collect();
    let pixel = |(point, phi): (DVec3, &f64)| match phi {
        _ if *phi > 0.3 => Pixel::Fluid,
        _ if *phi < -0.3 => Pixel::Solid,
        _ => Pixel::Value(value(point)),
    };
    let pixels = lattice.points().into_iter().zip(&phi).map(pixel).collect();
    Panel {
        title: "z = 0 m".into(),
        raster: Raster { lattice, pixels },
        quantity: Quantity::new("error of the volume", "m³"),
        colouring,
        lines: vec![Line::new("surface", contours(&lattice, &phi, 0.0), BLACK)],
        markers: vec![Marker {
            name: "largest error 1.2·10⁻⁵ m³".into(),
            at: [0.2, 0.5],
            colour: DISTINCT[1],
        }],
    }
}

fn wave(p: DVec3) -> f64 {
    1.2e-5 * (p.x * 9.0).sin() * (p.y * 9.0).cos()
}

fn linear(map: ColourMap) -> Colouring {
    Colouring::Linear(map, Limits::Auto)
}

/// Red, green and blue of the pixels of a PNG file of ours would need a decoder; the sizes are enough here.
fn assert_size(file: &[u8], width: std::ops::Range<u32>, height: std::ops::Range<u32>) {
    let [w, h] = png::size(file).unwrap();
    assert!(width.contains(&w) && height.contains(&h), "{w} x {h}");
}

#[test]
fn figures_of_every_form() {
    let cube = DVec3::splat(2.0);
    let one = Figure::of(panel(cube, 300, linear(ColourMap::BlueRed), wave)).to_png();
    assert_size(&one, 1400..1700, 1300..1700);
    save("one.png", &one);
    let limits = Limits::Given([-6e-6, 6e-6]);
    let panels = vec![
        panel(cube, 200, linear(ColourMap::Viridis), wave),
        panel(cube, 200, Colouring::Linear(ColourMap::BlueRed, limits), wave),
        panel(cube, 200, Colouring::Log(ColourMap::Reds, Limits::Auto), |p| wave(p).abs()),
        panel(cube, 200, linear(ColourMap::Cividis), wave),
    ];
    let title = "Error of the volume on three planes".to_owned();
    for columns in [2, 3] {
        let file = Figure { title: title.clone(), panels: panels.clone(), columns }.to_png();
        assert_size(&file, 1500..2600, 1200..2600);
        save(&format!("columns{columns}.png"), &file);
    }
    let flat = Figure::of(panel(DVec3::new(12.0, 1.2, 1.0), 768, linear(ColourMap::Viridis), wave)).to_png();
    assert_size(&flat, 1200..1800, 300..600);
    save("flat.png", &flat);
    let tall = Figure::of(panel(DVec3::new(0.5, 3.0, 1.0), 400, linear(ColourMap::BlueRed), wave)).to_png();
    assert_size(&tall, 500..1000, 1200..1800);
    save("tall.png", &tall);
    let large = Figure::of(panel(cube, 2000, linear(ColourMap::Viridis), wave)).to_png();
    assert_size(&large, 2500..2800, 2400..2800);
}

#[test]
fn categories_and_the_unknown() {
    let names = ["walls thinner than a cell", "gaps thinner than r", "neither"];
    let categories =
        names.iter().zip(DISTINCT).map(|(name, colour)| Category { name: (*name).into(), colour }).collect();
    let kind = |p: DVec3| {
        if p.x > 0.1 {
            2.0
        } else if p.y > 0.0 {
            1.0
        } else if p.y < -0.4 {
            f64::NAN
        } else {
            0.0
        }
    };
    let file = Figure::of(panel(DVec3::splat(2.0), 200, Colouring::Categories(categories), kind)).to_png();
    save("categories.png", &file);
    assert_size(&file, 1200..1600, 1300..1700);
}

#[test]
fn hostile_numbers_are_drawn() {
    let odd: [fn(DVec3) -> f64; 5] = [
        |_| f64::NAN,
        |_| f64::INFINITY,
        |_| 0.0,
        |p| if p.x > 0.0 { 1e300 } else { -1e300 },
        |p| 1e-320 * p.x,
    ];
    for value in odd {
        for map in [ColourMap::Viridis, ColourMap::BlueRed] {
            for colouring in [linear(map), Colouring::Log(map, Limits::Auto), Colouring::Categories(vec![])] {
                let mut panel = panel(DVec3::splat(2.0), 20, colouring, value);
                panel.markers[0].at = [f64::NAN, 1e300];
                panel.lines[0].curves.push(vec![[f64::NAN; 2], [f64::INFINITY; 2], [1e308; 2], [-1e308; 2]]);
                panel.raster.pixels.truncate(100);
                assert!(png::size(&Figure::of(panel).to_png()).is_some());
            }
        }
    }
    assert!(png::size(&Figure::default().to_png()).is_some());
    assert!(png::size(&Chart::default().to_png()).is_some());
}

#[test]
fn the_same_picture_has_the_same_bytes() {
    let hash = |file: &[u8]| blake3::hash(file).to_hex().to_string();
    let figure = Figure::of(panel(DVec3::splat(2.0), 100, linear(ColourMap::BlueRed), |p| p.x * p.y));
    assert_eq!(hash(&figure.to_png()), hash(&figure.to_png()));
    assert_eq!(
        hash(&figure.to_png()),
        "8ef193e4d7600d6e55f1cba30eb1d8376364af4a6a0f8e141201227a39476ae1",
        "looks as it did, on every machine"
    );
    assert_eq!(
        hash(&chart(false).to_png()),
        "13d5422bbe739af4b01f9d1d7424edda395e9c9c19acab22ea64b8baccd82b49"
    );
}

/// An error against distance, with bands of percentiles and a limit.
fn chart(log: bool) -> Chart {
    let at = |n: i32| f64::from(n) / 20.0 - 1.0;
    let error = |x: f64| 1e-5 / (1.0 + 10.0 * x * x);
    let band = |low: f64, high: f64| {
        Data::Band((0..=60).map(|n| [at(n), low * error(at(n)), high * error(at(n))]).collect())
    };
    let series = vec![
        Series { name: "99 %".into(), colour: DISTINCT[0], data: band(0.05, 1.0) },
        Series { name: "90 %".into(), colour: DISTINCT[0], data: band(0.1, 0.5) },
        Series {
            name: "median".into(),
            colour: DISTINCT[0],
            data: Data::Curve((0..=60).map(|n| [at(n), 0.3 * error(at(n))]).collect()),
        },
    ];
    let marks = vec![
        Mark { name: "allowed".into(), colour: DISTINCT[1], at: At::Y(9e-6) },
        Mark { name: "support radius".into(), colour: DISTINCT[2], at: At::X(1.0) },
    ];
    Chart {
        title: "Error against distance".into(),
        x: ChartAxis { quantity: Quantity::new("distance to the surface", "r"), ..ChartAxis::default() },
        y: ChartAxis { quantity: Quantity::new("error of the volume", "m³"), log, limits: Limits::Auto },
        series,
        marks,
    }
}

#[test]
fn charts_as_svg_and_png() {
    for (name, log) in [("chart.png", false), ("chart-log.png", true)] {
        let file = chart(log).to_png();
        assert_size(&file, 1600..1601, 900..1300);
        save(name, &file);
    }
    let bars = (0..20).map(|n| [f64::from(n), f64::from(n + 1), f64::from((n - 7) * (n - 7))]).collect();
    let histogram = Chart {
        series: vec![Series { name: "points".into(), colour: DISTINCT[0], data: Data::Bars(bars) }],
        ..Chart::default()
    };
    save("bars.png", &histogram.to_png());
    let text = Chart { title: "a < \"b\" & c".into(), ..chart(false) }.to_svg();
    assert!(text.starts_with("<svg ") && text.ends_with("</svg>"), "{text}");
    assert!(text.contains("aria-label=\"a &lt; &quot;b&quot; &amp; c\""));
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    assert_eq!(
        text.matches("<polygon").count(),
        2 + 3,
        "two bands; one box and one of two layers in the legend"
    );
}
