//! temp
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{InputSettings, load};
use volmap_bake::settings::*;
use volmap_bake::watch::Watch;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let f = |n: usize| a[n].parse::<f64>().unwrap();
    let input = load(a[1].as_ref(), &InputSettings::default()).unwrap();
    let grid = GridChoice::Tolerance(Tolerances { volume: f(3), distance: f(4), normal: None });
    let precision = a.get(6).map_or(Precision::F32, |p| Precision::Rounded(p.parse().unwrap()));
    let map = MapSettings { support_radius: Some(f(2)), grid, precision, invert: a.get(5).is_some_and(|x| x == "invert"), ..MapSettings::default() };
    let t = std::time::Instant::now();
    let b = bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap();
    println!("{:?}", t.elapsed());
    println!("{}", b.summary);
    let s = &b.asset;
    println!("nodes {} field bytes raw {} weights {:?}", s.volume.len(), s.volume.len() * 8, s.plane_weight.as_ref().map(|w| (w.len(), w.iter().sum::<u32>())));
    for w in &b.summary.warnings { println!("warning {w}"); }
    // compressed size of the two arrays
    let mut plain = s.clone();
    plain.finer.clear();
    if let Ok(bytes) = volmap_formats::asset::encode(&plain, Default::default()) { println!("encoded about {}", bytes.len()); }
}
