//! Damaged files of every format: each ends in a valid mesh or a clear error, in bounded time and
//! memory. One test in a binary of its own, because memory is counted for the whole process.

#[allow(dead_code)]
#[path = "mesh/samples.rs"]
mod samples;

use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;
use volmap_formats::mesh::{CleanSettings, MeshError, MeshFormat, clean, read_mesh_bytes};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const MUTATIONS: usize = 500;
const MIB: usize = 1 << 20;

/// xorshift64*.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() >> 16) as usize % end.max(1)
    }
}

fn mutate(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..1 + random.below(3) {
        if out.is_empty() {
            break;
        }
        let (a, b) = (random.below(out.len()), random.below(out.len()));
        let (low, high) = (a.min(b), a.max(b));
        match random.below(8) {
            0 => out[a] ^= 1 << random.below(8),
            1 => out[a] = random.next() as u8,
            2 => out.truncate(a),
            3 => drop(out.drain(low..high.min(low + 64))),
            4 => change_digits(&mut out, random),
            5 => swap_lines(&mut out, random),
            6 => out[low..(low + 4).min(high.max(low + 1))].fill(0xFF),
            _ => {
                let block = out[low..high.min(low + 64)].to_vec();
                out.splice(a..a, block);
            }
        }
    }
    out
}

fn change_digits(out: &mut Vec<u8>, random: &mut Random) {
    let digits: Vec<usize> = (0..out.len()).filter(|&k| out[k].is_ascii_digit()).collect();
    if digits.is_empty() {
        return;
    }
    let at = digits[random.below(digits.len())];
    let values: [&[u8]; 10] = [
        b"0",
        b"9",
        b"-1",
        b"4294967295",
        b"999999999999",
        b"1e300",
        b"nan",
        b"inf",
        b"18446744073709551615",
        b".",
    ];
    out.splice(at..=at, values[random.below(values.len())].iter().copied());
}

fn swap_lines(out: &mut Vec<u8>, random: &mut Random) {
    let mut lines: Vec<Vec<u8>> = out.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
    let (a, b) = (random.below(lines.len()), random.below(lines.len()));
    lines.swap(a, b);
    *out = lines.join(&b'\n');
}

/// Reads and checks; true if it was a mesh.
fn check(name: &str, bytes: &[u8], format: MeshFormat) -> bool {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let start = Instant::now();
    let result = read_mesh_bytes(bytes, format).and_then(|raw| clean(raw, &CleanSettings::default()));
    let used = MEMORY.peak_usage().saturating_sub(before);
    assert!(start.elapsed() < Duration::from_secs(5), "{name}: took {:?}", start.elapsed());
    assert!(used <= 64 * bytes.len() + 64 * MIB, "{name}: {used} bytes for {}", bytes.len());
    match result {
        Ok((mesh, _)) => {
            let count = mesh.vertices.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|&v| v < count), "{name}");
            assert!(mesh.vertices.iter().flatten().all(|c| c.is_finite()), "{name}");
            true
        }
        Err(MeshError::Panicked { message, .. }) => panic!("{name}: panicked: {message}"),
        Err(error) => {
            let message = error.to_string();
            assert!(message.len() > 20 && !message.contains('\0'), "{name}: {message}");
            false
        }
    }
}

#[test]
fn damaged_files_end_in_a_mesh_or_an_error() {
    let mut samples = samples::boxes();
    let extra = |name, format, bytes| samples::Sample { name, format, bytes };
    samples.push(extra("glTF scene", MeshFormat::Gltf, samples::gltf_scene()));
    samples.push(extra("3MF assembly", MeshFormat::ThreeMf, samples::threemf_assembly()));
    let skin = "{\"mesh\":0,\"skin\":0},{\"children\":[2]},{}";
    let skins = ",\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":6}]";
    let skin = samples::gltf_box(skin, ",\"JOINTS_0\":4,\"WEIGHTS_0\":5", skins);
    let instancing =
        "{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2}}}}";
    samples.extend([
        extra("glTF skin", MeshFormat::Gltf, skin),
        extra("glTF instances", MeshFormat::Gltf, samples::gltf_box(instancing, "", "")),
        extra("glTF morph", MeshFormat::Gltf, samples::gltf_morph("", ",\"weights\":[0.5]")),
    ]);
    let config = "<config><object id=\"4\"><part id=\"3\" subtype=\"modifier_part\"/></object></config>";
    let parts = samples::threemf_parts("model", "", ("Metadata/model_settings.config", config));
    samples.push(extra("3MF of a slicer", MeshFormat::ThreeMf, parts));
    samples.extend(samples::polyhedra());
    let (vtu, vtk) = samples::vtk_ghosts("1 0 32 0");
    samples.extend([extra("VTU ghosts", MeshFormat::Vtu, vtu), extra("VTK ghosts", MeshFormat::Vtk, vtk)]);
    for sample in &samples {
        let mut random = Random(0x5EED ^ sample.bytes.len() as u64);
        let mut meshes = 0;
        for k in 0..MUTATIONS {
            let bytes = mutate(&sample.bytes, &mut random);
            let name = format!("{}, mutation {k}", sample.name);
            meshes += usize::from(check(&name, &bytes, sample.format));
        }
        // Neither all refused nor all accepted: the mutations reach what they should.
        assert!(meshes < MUTATIONS * 19 / 20, "{}: {meshes}", sample.name);
    }
    for sample in &samples {
        let step = (sample.bytes.len() / 200).max(1);
        for length in (0..sample.bytes.len()).step_by(step) {
            let name = format!("{}, cut to {length}", sample.name);
            check(&name, &sample.bytes[..length], sample.format);
        }
        // Every reader gets every file.
        for format in MeshFormat::ALL {
            check(&format!("{} as {format}", sample.name), &sample.bytes, format);
        }
    }
}
