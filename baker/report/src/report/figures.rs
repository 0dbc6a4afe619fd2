//! Pictures and charts of a report.

use super::findings::Findings;
use super::levels::LevelMap;
use super::slices::ErrorSlice;
use super::thin::Thin;
use super::views::{SHADES, View};
use glam::DVec3;
use volmap_figures::picture::colours::{BLACK, DISTINCT, WHITE};
use volmap_figures::picture::{
    At, Category, Chart, ChartAxis, ColourMap, Colouring, Data, Figure, Limits, Line, Marker, Panel, Pixel,
    PixelLattice, Polyline, Quantity, Raster, Rgb, Series, contours, section,
};
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::{number, typeset};

/// A picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Ending of its file's name.
    pub name: String,
    /// The PNG file.
    pub png: Vec<u8>,
    /// What is seen.
    pub alt: String,
    /// Below it.
    pub caption: String,
}

/// Value and error of each slice side by side. `mesh` is the surface that the asset stands for, and its name.
pub fn slice_pictures(slices: &[ErrorSlice], mesh: Option<(&TriangleMesh, &str)>) -> Vec<Picture> {
    slices.iter().map(|slice| slice_picture(slice, mesh)).collect()
}

fn slice_picture(slice: &ErrorSlice, mesh: Option<(&TriangleMesh, &str)>) -> Picture {
    let lattice = &slice.volume.lattice;
    let mut lines = Vec::new();
    // The mesh below, wide: where both agree it is the edge of the other.
    if let Some((mesh, name)) = mesh {
        lines.push(Line { width: 2.0, ..Line::new(name, section(mesh, lattice), DISTINCT[1]) });
    }
    let surface = contours(lattice, &slice.distance, 0.0);
    lines.push(Line { width: 0.7, ..Line::new("surface of the map", surface, BLACK) });
    let plane = format!("{} = {}", lattice.plane.axis.name(), typeset(&number(lattice.plane.at)));
    let volume = Panel {
        title: format!("volume on {plane} m"),
        raster: slice.volume.clone(),
        quantity: Quantity::new("volume", "m³"),
        colouring: Colouring::Linear(ColourMap::Viridis, Limits::Auto),
        lines: lines.clone(),
        markers: Vec::new(),
    };
    let marker = |(point, _)| Marker {
        name: "largest error of the slice".into(),
        at: lattice.project(point),
        colour: BLACK,
    };
    let error = Panel {
        title: "map − integral of order 100".into(),
        raster: percent(&slice.error),
        quantity: Quantity::new("error", "% of the full ball"),
        colouring: Colouring::Linear(ColourMap::BlueRed, Limits::Auto),
        lines,
        markers: slice.worst.map(marker).into_iter().collect(),
    };
    let largest = slice.worst.map_or(0.0, |(_, error)| 100.0 * error.abs());
    let through = if slice.through_worst { ", through the worst of the random points" } else { "" };
    let wide = lattice.size[0] > 2 * lattice.size[1];
    Picture {
        name: if slice.through_worst { "worst" } else { lattice.plane.axis.name() }.into(),
        png: Figure { title: String::new(), panels: vec![volume, error], columns: if wide { 1 } else { 2 } }
            .to_png(),
        alt: format!("Two maps of colours on the plane {plane}: the volume, and its error"),
        caption: format!(
            "The volume on the plane {plane} m{through}, and its difference to the integral of order 100 on the \
             asset's own distance at every pixel, at most {largest:.3} % of the full ball."
        ),
    }
}

/// Colours of levels, from the largest cells on.
const LEVELS: [Rgb; 8] = [
    [247, 251, 255],
    [214, 230, 244],
    [171, 208, 230],
    [115, 178, 216],
    [65, 145, 198],
    [29, 108, 177],
    [8, 72, 143],
    [8, 48, 107],
];
/// Cells of fewer pixels have no edges drawn.
const LEAST_PIXELS: f64 = 4.0;

/// The cells that each slice cuts.
pub fn level_pictures(slices: &[ErrorSlice], levels: &LevelMap) -> Vec<Picture> {
    slices.iter().map(|slice| level_picture(slice, levels)).collect()
}

fn level_picture(slice: &ErrorSlice, levels: &LevelMap) -> Picture {
    let lattice = &slice.volume.lattice;
    let pixel = |(pixel, point): (&Pixel, DVec3)| match (pixel, levels.level(point)) {
        (Pixel::Value(_), Some(level)) => Pixel::Value(f64::from(level)),
        (Pixel::Value(_), None) => Pixel::Fluid,
        (other, _) => *other,
    };
    let raster = Raster {
        lattice: *lattice,
        pixels: slice.volume.pixels.iter().zip(lattice.points()).map(pixel).collect(),
    };
    let category = |level: u32| Category {
        name: format!("{} m", number(levels.cell_size(level).max_element())),
        colour: LEVELS[(level as usize).min(LEVELS.len() - 1)],
    };
    let edges = Line { width: 0.4, ..Line::new("edges of cells", cell_edges(lattice, levels), [90, 90, 90]) };
    let surface = contours(lattice, &slice.distance, 0.0);
    let plane = format!("{} = {}", lattice.plane.axis.name(), typeset(&number(lattice.plane.at)));
    let panel = Panel {
        title: format!("cells on {plane} m"),
        raster,
        quantity: Quantity::new("edge of a cell", ""),
        colouring: Colouring::Categories((0..levels.count).map(category).collect()),
        lines: vec![edges, Line::new("surface of the map", surface, DISTINCT[1])],
        markers: Vec::new(),
    };
    let name = if slice.through_worst { "worst" } else { lattice.plane.axis.name() };
    Picture {
        name: format!("cells-{name}"),
        png: Figure { title: String::new(), panels: vec![panel], columns: 1 }.to_png(),
        alt: format!("The cells that the plane {plane} cuts, in colours by their size"),
        caption: format!(
            "The cells that the plane {plane} m cuts, by their size. Edges are drawn of cells that are at least {LEAST_PIXELS} \
             pixels large."
        ),
    }
}

/// Edges of the cells that the plane cuts, along the lattice's axes, metres.
fn cell_edges(lattice: &PixelLattice, levels: &LevelMap) -> Vec<Polyline> {
    let axis = lattice.plane.axis.index();
    let [from, to] = [lattice.point(0, 0), lattice.point(lattice.size[0] - 1, lattice.size[1] - 1)];
    let [from, to] = [lattice.project(from), lattice.project(to)];
    let pixel = (to[0] - from[0]).abs() / lattice.size[0].max(2) as f64;
    let is_large = |level: u32| levels.cell_size(level).min_element() >= LEAST_PIXELS * pixel;
    let is_drawn: Vec<bool> = (0..levels.count).map(is_large).collect();
    let mut out = Vec::new();
    for (_, [low, high]) in levels.boxes().filter(|(level, _)| is_drawn[*level as usize]) {
        let [a, b] = [lattice.project(low), lattice.project(high)];
        let is_cut = low[axis] <= lattice.plane.at && lattice.plane.at < high[axis];
        let is_seen =
            (0..2).all(|n| a[n].max(b[n]) >= from[n].min(to[n]) && a[n].min(b[n]) <= from[n].max(to[n]));
        if is_cut && is_seen {
            out.push(vec![a, [b[0], a[1]], b, [a[0], b[1]], a]);
        }
    }
    out
}

fn percent(raster: &Raster) -> Raster {
    let scaled = |pixel: &Pixel| match pixel {
        Pixel::Value(part) => Pixel::Value(100.0 * part),
        other => *other,
    };
    Raster { pixels: raster.pixels.iter().map(scaled).collect(), ..raster.clone() }
}

/// Colours of [`Thin::ALL`].
const THIN: [Rgb; 5] = [[225, 228, 232], DISTINCT[4], DISTINCT[0], DISTINCT[3], DISTINCT[1]];

/// The surface from three sides, coloured by what is thin, and the places where signs differ.
pub fn view_picture(views: &[View], disagreeing: &[DVec3]) -> Option<Picture> {
    if views.is_empty() {
        return None;
    }
    let named = |kind: Thin, shade| if shade == 0 { kind.describe().to_string() } else { String::new() };
    let shaded =
        |colour: Rgb, shade: usize| colour.map(|c| (f64::from(c) * (1.0 - 0.12 * shade as f64)) as u8);
    let mut categories = Vec::new();
    for shade in 0..SHADES {
        let kinds = Thin::ALL.into_iter().zip(THIN);
        categories.extend(
            kinds.map(|(kind, colour)| Category { name: named(kind, shade), colour: shaded(colour, shade) }),
        );
    }
    categories.push(Category { name: String::new(), colour: WHITE });
    let panel = |view: &View| Panel {
        title: format!("seen along {}", view.axis.name()),
        raster: view.kinds.clone(),
        quantity: Quantity::new("what is thin", ""),
        colouring: Colouring::Categories(categories.clone()),
        lines: Vec::new(),
        markers: disagreeing
            .iter()
            .map(|point| Marker {
                name: "signs differ".into(),
                at: view.kinds.lattice.project(*point),
                colour: BLACK,
            })
            .collect(),
    };
    let figure = Figure { title: String::new(), panels: views.iter().map(panel).collect(), columns: 3 };
    Some(Picture {
        name: "thin".into(),
        png: figure.to_png(),
        alt: "The surface from three sides, thin walls and narrow gaps in colour".into(),
        caption: "The surface from the positive ends of the axes. In colour: walls and gaps that are narrower than the \
                  support radius or a cell. Where a wall is thinner than a cell, the map may leak. Marked: where \
                  pseudonormals and winding numbers differ, if they do."
            .into(),
    })
}

/// How many points have an error of which size.
pub fn histogram_chart(findings: &Findings) -> Chart {
    // From the first size that any point has.
    let bars = findings.histogram.iter().skip_while(|bar| bar.part == 0.0);
    let bars = bars.map(|bar| [100.0 * bar.low, 100.0 * bar.high, 100.0 * bar.part]).collect();
    Chart {
        title: "Histogram of the sizes of errors".into(),
        x: ChartAxis {
            quantity: Quantity::new("size of the error", "% of the ball"),
            log: true,
            limits: Limits::Auto,
        },
        y: ChartAxis { quantity: Quantity::new("points", "%"), log: false, limits: Limits::Auto },
        series: vec![Series { name: String::new(), colour: DISTINCT[0], data: Data::Bars(bars) }],
        marks: findings.verdict.allowed.map(allowed_at(At::X)).into_iter().collect(),
    }
}

/// How the error varies with the distance from the surface.
pub fn distance_chart(findings: &Findings) -> Chart {
    let bins = &findings.by_distance;
    let middle = |low: f64, high: f64| 0.5 * (low + high);
    let curve = |value: &dyn Fn(&super::statistics::DistanceBin) -> f64| {
        Data::Curve(bins.iter().map(|bin| [middle(bin.low, bin.high), 100.0 * value(bin)]).collect())
    };
    let series = |name: &str, colour, data| Series { name: name.into(), colour, data };
    Chart {
        title: "Size of the error against the distance from the surface".into(),
        x: ChartAxis {
            quantity: Quantity::new("distance from the surface", "support radii"),
            log: false,
            limits: Limits::Given([-2.0, 2.0]),
        },
        y: ChartAxis {
            quantity: Quantity::new("size of the error", "% of the ball"),
            log: true,
            limits: Limits::Auto,
        },
        series: vec![
            series("largest", DISTINCT[1], curve(&|bin| bin.max)),
            series("90 %", DISTINCT[3], curve(&|bin| bin.percentile_90)),
            series("median", DISTINCT[0], curve(&|bin| bin.median)),
        ],
        marks: findings.verdict.allowed.map(allowed_at(At::Y)).into_iter().collect(),
    }
}

fn allowed_at(at: fn(f64) -> At) -> impl Fn(f64) -> volmap_figures::picture::Mark {
    move |allowed| volmap_figures::picture::Mark {
        name: "allowed".into(),
        colour: BLACK,
        at: at(100.0 * allowed),
    }
}
