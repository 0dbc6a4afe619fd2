//! Density maps: quadrature rules on shapes with a closed form of their distance, against a converged rule, and what a
//! density map costs beside a volume map.
//!
//! `cargo bench -p volmap-baker --bench density`

mod shapes;

use glam::DVec3;
use shapes::{SHAPES, points};
use volmap_bake::density_map::cost::{Cost, Costs, measure, paper_settings, unit_cube};
use volmap_bake::density_map::oracle::density;
use volmap_bake::density_map::{DensitySettings, compute_density};
use volmap_bake::maps::compute_maps;
use volmap_bake::plan::{Extent, GridChoice, MapSettings, plan};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_runtime::KernelKind;
use volmap_runtime::layout::serendipity::shape_and_gradient;
use volmap_runtime::layout::{Cell, CellIndex};

const RULES: [&str; 11] =
    ["gl30", "gl50", "gl100", "ball5", "ball6", "ball8", "ball10", "chord6", "chord8", "chord10", "chord12"];

/// Largest error and root of the mean square, per cent of rest density.
fn errors(phi: fn(DVec3) -> f64, settings: &DensitySettings, reference: &[(DVec3, f64)]) -> [f64; 2] {
    let error = |(x, exact): &(DVec3, f64)| 100.0 * (density(phi, settings, 1.0, *x) - exact).abs();
    let all: Vec<f64> = reference.iter().map(error).collect();
    let squares: f64 = all.iter().map(|e| e * e).sum();
    [all.iter().copied().fold(0.0, f64::max), (squares / all.len() as f64).sqrt()]
}

fn rules(kernel: KernelKind) {
    let with = |rule: Rule| DensitySettings { kernel, rule, ..DensitySettings::default() };
    let converged = with(Rule::GaussLegendre(200));
    let references: Vec<Vec<(DVec3, f64)>> = SHAPES
        .iter()
        .map(|(_, phi)| {
            let exact = |x| (x, density(phi, &converged, 1.0, x));
            points(*phi).into_iter().map(exact).collect()
        })
        .collect();
    println!("{kernel}");
    print!("| rule | points | integral of W |");
    SHAPES.iter().for_each(|(name, _)| print!(" {name} |"));
    println!("\n| --- | --- | --- |{}", " --- |".repeat(SHAPES.len()));
    for rule in RULES.map(|name| name.parse().expect("a rule")) {
        let settings = with(rule);
        let integral: f64 = settings.points().iter().map(|p| p.weight).sum();
        print!("| `{rule}` | {} | 1 {:+.1e} |", settings.points().len(), integral - 1.0);
        for ((_, phi), reference) in SHAPES.iter().zip(&references) {
            let [max, rms] = errors(*phi, &settings, reference);
            print!(" {max:.3} ({rms:.3}) |");
        }
        println!();
    }
}

/// Seconds and bytes on the unit cube, medians of three runs that take turns, one thread.
fn costs() {
    const RESOLUTIONS: [u32; 3] = [10, 20, 60];
    let mut runs: Vec<Vec<Costs>> = vec![Vec::new(); RESOLUTIONS.len()];
    for _ in 0..3 {
        for (resolution, own) in RESOLUTIONS.iter().zip(&mut runs) {
            own.push(measure(&unit_cube(), &paper_settings(*resolution), &Watch::default()).expect("maps"));
        }
    }
    let median = |own: &[Costs], of: fn(&Costs) -> Cost| {
        let mut costs: Vec<Cost> = own.iter().map(of).collect();
        costs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        costs[costs.len() / 2]
    };
    println!("| cells | kind | s | kB, ours | kB, the paper's way |");
    println!("| --- | --- | --- | --- | --- |");
    for (resolution, own) in RESOLUTIONS.iter().zip(&runs) {
        let [volume, density] = [median(own, |c| c.volume), median(own, |c| c.density)];
        for (kind, cost) in [("volume", volume), ("density", density)] {
            let [bytes, paper] = [cost.bytes, cost.paper_bytes].map(|bytes| bytes as f64 / 1e3);
            println!("| {resolution}^3 | {kind} | {:.4} | {bytes:.0} | {paper:.0} |", cost.seconds);
        }
    }
    let (volume, density) = (median(&runs[0], |c| c.volume), median(&runs[2], |c| c.density));
    println!(
        "density at 60^3 to volume at 10^3: {:.0} times the time, {:.0} times the bytes, {:.0} the paper's way",
        density.seconds / volume.seconds,
        density.bytes as f64 / volume.bytes as f64,
        density.paper_bytes as f64 / volume.paper_bytes as f64
    );
}

/// How smooth the gradient is: its kinks by the element, and what the rule's error adds.
fn jumps() {
    let rules = ["gl30", "gl50", "gl100"].map(|name| name.parse().expect("a rule"));
    println!("| cells | gl30 | gl50 | gl100 |\n| --- | --- | --- | --- |");
    for resolution in [10, 20, 30, 40, 60] {
        let [a, b, c] = rules.map(|rule| 100.0 * jump(resolution, rule));
        println!("| {resolution}^3 | {a:.2} % | {b:.2} % | {c:.2} % |");
    }
}

/// Largest jump of the density's slope from cell to cell on a line across a face of the unit cube, from r inside to 2 r
/// outside, as a part of its largest slope there.
fn jump(resolution: u32, rule: Rule) -> f64 {
    let all = paper_settings(resolution);
    let density = DensitySettings { rule, ..DensitySettings::default() };
    // A column of cells as large as those of the whole map.
    let settings = MapSettings {
        grid: GridChoice::CellSize(1.4 / f64::from(resolution)),
        domain: Some([[-0.1, -0.1, 0.35], [0.1, 0.1, 0.75]]),
        density: Some(density),
        ..all
    };
    let half = DVec3::splat(0.5);
    let plan = plan(&Extent { min: -half, max: half, area: 6.0 }, &settings).expect("a plan");
    let cube = |x: DVec3| {
        let q = x.abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    };
    let mut maps = compute_maps(&plan, Rule::Chord(4), &cube, &Watch::default()).expect("maps");
    maps.density =
        Some(compute_density(&plan, &density, &cube, &maps, &Watch::default()).expect("a density"));
    let cells = CellIndex::new(plan.grid.resolution, &maps.cells.band, &maps.cells.solid, &maps.nodes);
    let values = maps.density.expect("a density");
    let slope = |z: f64| {
        let at = plan.grid.locate(DVec3::new(0.013, 0.027, z)).expect("in the domain");
        let Cell::Band(numbers) = cells.find(at.cell) else { return 0.0 };
        let (_, gradients) = shape_and_gradient(at.xi);
        let terms = gradients.iter().zip(numbers.all()).map(|(g, number)| g.z * values[number as usize]);
        terms.sum::<f64>() * 2.0 / plan.grid.cell_size.z
    };
    let faces =
        (0..=plan.grid.resolution.z).map(|k| plan.grid.origin.z + plan.grid.cell_size.z * f64::from(k));
    let faces = faces.filter(|z| (0.4..0.7).contains(z));
    let largest = (0..100).map(|n| slope(0.5 + 0.001 * f64::from(n)).abs()).fold(0.0, f64::max);
    faces.map(|z| (slope(z - 1e-9) - slope(z + 1e-9)).abs()).fold(0.0, f64::max) / largest
}

/// `cargo bench ... -- costs` leaves the table of rules out.
fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("a thread");
    costs();
    jumps();
    if !std::env::args().any(|argument| argument == "costs") {
        [KernelKind::CubicSpline, KernelKind::WendlandC2].into_iter().for_each(rules);
    }
}
