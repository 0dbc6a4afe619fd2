//! The volume's inner loop alone: nanoseconds a sample and the part of this core's multiply-add throughput.
//!
//! `cargo bench -p volmap-baker --bench kernel`
//!
//! A sample needs 3 multiply-adds for s, 4 products and 2 multiply-adds for gamma*: 9 operations on the two units that
//! multiply. The peak is measured in the same process, by a loop of independent multiply-adds.
#![allow(unsafe_code)]

use std::hint::black_box;
use std::time::Instant;
use volmap_bake::volume_map::dispatch;
use volmap_bake::volume_map::kernel::{self, Content, Group, Window};

const CELLS: usize = 48;
const SAMPLE_OPERATIONS: f64 = 9.0;

fn main() {
    let peak = peak();
    println!("peak: {peak:.1} products or multiply-adds of f64 a nanosecond\n");
    println!("| points of a cell | samples | ns a sample | of the peak, 9 operations a sample |");
    println!("| --- | --- | --- | --- |");
    for (name, planes, lines, points) in [
        ("gl30, r = 1 cell: 8 planes x 8 lines x 8", 8, 8, 8),
        ("gl30, r = 2 cells: 4 x 4 x 4", 4, 4, 4),
        ("gl30, r = 4 cells: 2 x 2 x 2", 2, 2, 2),
        ("chord8, r = 1 cell: 10 lines x 4", 10, 1, 4),
        ("chord8, r = 2 cells: 5 lines x 2", 5, 1, 2),
        ("one point", 1, 1, 1),
    ] {
        let group = group(planes, lines, points);
        let samples = group.points.len() * CELLS;
        let ns = median(|| time(&group)) / samples as f64;
        println!("| {name} | {samples} | {ns:.2} | {:.0} % |", 100.0 * SAMPLE_OPERATIONS / ns / peak);
    }
}

fn place(i: usize, n: usize) -> f64 {
    (2.0 * i as f64 + 1.0) / n as f64 - 1.0
}

fn group(planes: usize, lines: usize, points: usize) -> Group {
    let mut group = Group::default();
    for plane in 0..planes {
        group.planes.push((place(plane, planes), lines as u32));
        for line in 0..lines {
            group.lines.push((place(line, lines), points as u32));
            group.points.extend((0..points).map(|point| [place(point, points), 0.1]));
        }
    }
    group.total = kernel::total(&group);
    group
}

/// Nanoseconds of one pass over a row of cells that the surface crosses.
fn time(group: &Group) -> f64 {
    let kernel = dispatch::kernel::<64>();
    let mut window = Window::<64> { width: CELLS, ..Window::default() };
    window.contents.fill(Content::Mixed as u8);
    for (a, row) in window.values.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(i, s)| *s = ((a * 7 + i * 3) % 11) as f64 / 11.0);
    }
    (kernel.to_monomials)(&mut window);
    let mut sums = [0.0; CELLS];
    let passes = 2_000_000 / (group.points.len() * CELLS) + 1;
    let start = Instant::now();
    for _ in 0..passes {
        (kernel.accumulate)(std::slice::from_ref(black_box(group)), black_box(&window), 0, &mut sums);
    }
    black_box(sums);
    1e9 * start.elapsed().as_secs_f64() / passes as f64
}

fn median(mut run: impl FnMut() -> f64) -> f64 {
    let mut times: Vec<f64> = (0..15).map(|_| run()).collect();
    times.sort_by(f64::total_cmp);
    times[7]
}

/// Multiply-adds a nanosecond.
fn peak() -> f64 {
    const ROUNDS: usize = 400_000;
    let run = || {
        let start = Instant::now();
        let done = multiply_adds(black_box(ROUNDS));
        done / (1e9 * start.elapsed().as_secs_f64())
    };
    (0..15).map(|_| run()).fold(0.0, f64::max)
}

/// Twelve independent chains of four; returns how many multiply-adds it did.
#[inline(always)]
fn chains(rounds: usize) -> f64 {
    let mut sums = [[1.0f64; 4]; 12];
    let (factor, addend) = (black_box(0.999_999), black_box(1e-6));
    for _ in 0..rounds {
        for sum in &mut sums {
            for lane in sum {
                *lane = lane.mul_add(factor, addend);
            }
        }
    }
    black_box(sums);
    (rounds * 48) as f64
}

fn multiply_adds(rounds: usize) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        #[target_feature(enable = "avx2,fma")]
        fn wide(rounds: usize) -> f64 {
            chains(rounds)
        }
        // SAFETY: this processor has AVX2 and FMA.
        return unsafe { wide(rounds) };
    }
    chains(rounds)
}
