#!/usr/bin/env bash
# h5wasm answers a read that failed with an array: the right type and length, and numbers of another dataset.
#
# Packages: h5wasm 0.10.3, for node; h5py 3.16.0, hdf5plugin 7.1.0 and numpy 2.2.6, for Python, write the file. Needs node.
#
# Behaviour: h5wasm, HDF5 for browsers and node, has no Zstandard (filter 32015) unless the package h5wasm-plugins is
# added, as its manual says. Without it, `dataset.value` doesn't throw. libhdf5's complaint goes to the console, and the
# array that was to be filled is returned all the same: mostly what it held before, which is the dataset that was read
# before it, displaced. Only `activate_throwing_error_handler()` of the module makes an exception of it.
#
# Seen (one file: distances by gzip, -0.1 to 0.3095; volumes by Zstandard, 0 to 0.004095):
#
#     distance: all 4096 numbers right
#     volume:   no exception, Float32Array(4096), 0 numbers right, 3188 are distances
#               volume[2000..2002] = 0.2022, 0.2023, 0.2024 (0.002000, 0.002001, 0.002002)
#     volume:   an exception after activate_throwing_error_handler()
#     console:  1 complaint of libhdf5, on the standard error
#
# Why it matters: a viewer in a browser is how people look at a field or a frame without installing anything, and
# Zstandard makes large ones quick to write. Most of what such a viewer shows is smooth and of sensible size, for it is
# real values of another field, and few keep the console open.
#
# In this project: "Who reads assets" in formats/SPEC.md has this row, and it is one reason why the default
# compression of assets is gzip, which h5wasm reads.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --no-cache-dir --disable-pip-version-check h5py==3.16.0 hdf5plugin==7.1.0 numpy==2.2.6
npm install --silent --no-audit --no-fund --cache "$work/npm" --prefix "$work" h5wasm@0.10.3 >/dev/null

venv/bin/python - <<'PYTHON'
import h5py
import hdf5plugin
import numpy as np

steps = np.arange(4096)
shape = dict(chunks=(1024,), shuffle=True)
with h5py.File("map.h5", "w") as file:
    file.create_dataset("distance", data=np.float32(-0.1 + 1e-4 * steps), compression="gzip", **shape)
    file.create_dataset("volume", data=np.float32(1e-6 * steps), **shape, **hdf5plugin.Zstd(clevel=3))
with h5py.File("map.h5") as file:
    assert np.array_equal(file["volume"][:], np.float32(1e-6 * steps)), "the file is at fault"
PYTHON

cat >look.mjs <<'NODE'
import assert from "node:assert";
import h5wasm from "h5wasm/node";

const module = await h5wasm.ready;
const file = new h5wasm.File("map.h5", "r");
const distance = file.get("distance").value;
assert(distance.every((value, n) => value === Math.fround(-0.1 + 1e-4 * n)), "gzip isn't read as before");
const volume = file.get("volume").value;
const right = volume.filter((value, n) => value === Math.fround(1e-6 * n)).length;
const known = new Set(distance);
const foreign = volume.filter((value) => known.has(value)).length;
const some = Array.from(volume.slice(2000, 2003), (value) => value.toPrecision(4));
console.log(`distance: all ${distance.length} numbers right`);
console.log(`volume:   no exception, ${volume.constructor.name}(${volume.length}), ${right} numbers right, ` +
    `${foreign} are distances`);
console.log(`          volume[2000..2002] = ${some.join(", ")} (0.002000, 0.002001, 0.002002)`);
assert(volume.length === 4096 && right < 41, "Zstandard is read now, or otherwise");

module.activate_throwing_error_handler();
assert.throws(() => file.get("volume").value, /32015|zstd/);
console.log("volume:   an exception after activate_throwing_error_handler()");
NODE
node look.mjs 2>console.txt || { cat console.txt; exit 1; }
echo "console:  $(grep -c '^HDF5-DIAG' console.txt) complaint of libhdf5, on the standard error"
grep -q 'required filter' console.txt || { echo "the console doesn't name the filter any more"; exit 1; }
