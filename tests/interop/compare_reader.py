#!/usr/bin/env python3
"""Holds read_asset.py, written from SPEC.md alone, against `volmap query`.

    compare_reader.py --against VOLMAP [--exact ASSET] ASSET...

For each asset: both give the same region and, to 1e-12 of each column's magnitude, the same numbers
(f32 fields too: a reader computes in f64) at random points, on cell corners and faces, on the
domain's faces and outside; and both refuse copies with one byte flipped. Prints the largest
differences; exits 1 on failure.
"""

import argparse
import csv
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

import read_asset

TOLERANCE = 1e-12
# Of adaptive maps that a reader may round to single precision (section 14); gradients feel it most.
ROUNDED_TOLERANCE = 1e-5


def choose_points(asset):
    rng = np.random.default_rng(1)
    finer = 2 ** (len(asset.levels) - 1) if asset.adaptive else 1
    low, size, resolution = asset.origin, asset.cell_size / finer, asset.resolution * finer
    high = low + size * resolution
    inside = rng.uniform(low, high, (1000, 3))
    corners = low + size * rng.integers(0, resolution + 1, (500, 3))
    cell_faces, faces, outside = inside[:300].copy(), inside[300:600].copy(), inside[600:900].copy()
    one, axis = np.arange(300), rng.integers(0, 3, 300)
    cell_faces[one, axis] = corners[one, axis]
    upper = rng.integers(0, 2, 300) == 1
    faces[one, axis] = np.where(upper, high[axis], low[axis])
    off = size[axis] * rng.random(300)
    outside[one, axis] = np.where(upper, high[axis] + off, low[axis] - off)
    domain = np.array([low, high])
    domain_corners = np.stack(np.meshgrid(*domain.T), -1).reshape(-1, 3)
    just_off = np.concatenate([np.nextafter(domain_corners, 0), np.nextafter(domain_corners, 2 * domain_corners)])
    far = [[1e308, 0, 0], [0, -1e308, 0], [1e6, 1e6, 1e6]]
    return np.concatenate([inside, corners, cell_faces, faces, outside, domain_corners, just_off, far])


def query(volmap, asset, points, folder, columns):
    """(regions, numbers [n, columns]) that the binary gives."""
    path = folder / "points.csv"
    path.write_text("x,y,z\n" + "".join(",".join(map(repr, point)) + "\n" for point in points.tolist()))
    run = subprocess.run([volmap, "query", asset, "--points", path], check=True, capture_output=True, text=True)
    rows = list(csv.DictReader(run.stdout.splitlines()))
    numbers = [[float(row[name] or "nan") for name in columns] for row in rows]
    return [row["region"] for row in rows], np.array(numbers)


def compare(volmap, path, folder):
    asset = read_asset.load(path)
    points = choose_points(asset)
    columns = read_asset.COLUMNS + (() if asset.density is None else read_asset.DENSITY_COLUMNS)
    theirs_region, theirs = query(volmap, path, points, folder, columns)
    answer = asset.sample(points)
    ours_region, ours = [read_asset.REGIONS[region] for region in answer["region"]], read_asset.table(answer)
    if asset.density is not None:
        ours = np.concatenate([ours, answer["density"]], 1)
    counts = ", ".join(f"{ours_region.count(name)} {name}" for name in read_asset.REGIONS)
    print(f"{path} ({asset.precision}): {len(points)} points, {counts}")
    good = ours_region == theirs_region and np.array_equal(np.isnan(ours), np.isnan(theirs))
    if not good:
        print("  FAILED: regions, or what is known, differ")
        return False
    # Where the gradient vanishes but for rounding, readers may differ in direction (SPEC.md, section 7).
    vanishing = answer["slope"] < 1e-9
    good &= vanishing.sum() <= len(points) // 100
    ours[vanishing, 1:7] = theirs[vanishing, 1:7]
    reach = np.nanmax(np.abs(ours[:, 4:7]), initial=0)
    magnitude = [np.abs(asset.phi).max(initial=0), 1, 1, 1, reach, reach, reach, asset.ball_volume]
    if asset.density is not None:
        largest = np.abs(asset.density).max(initial=0)
        magnitude += [largest, *(23.2 * largest / asset.cell_size)]
    tolerance = ROUNDED_TOLERANCE if asset.adaptive and asset.precision != "f64" else TOLERANCE
    differences = np.nanmax(np.abs(ours - theirs), axis=0, initial=0)
    for name, difference, unit in zip(columns, differences, magnitude):
        within = difference <= tolerance * unit
        good &= within
        relative = difference / unit if unit else 0
        print(f"  {name:8} {difference:.2e}, relative {relative:.2e}{'' if within else '  FAILED'}")
    return good


def refuse_damage(volmap, path, folder):
    """Flips a byte in the superblock, in attributes and in each dataset's first chunk, one at a time."""
    content = path.read_bytes()
    places = {"signature": 0, "superblock": 12}
    with h5py.File(path) as file:
        known = {
            "format": b"volmap",
            "extension_function": b"cubic_spline",
            "checksum": bytes(file.attrs["blake3"]),
            "cell_size": file["grid"].attrs["cell_size"].tobytes(),
            "resolution": file["grid"].attrs["resolution"].tobytes(),
        }
        if "scale_factor" in file["fields/volume"].attrs:
            known["scale_factor"] = file["fields/volume"].attrs["scale_factor"].tobytes()
        places |= {name: content.find(value) for name, value in known.items()}
        others = tuple(name for name in (read_asset.DENSITY, read_asset.WEIGHT) if name in file)
        for name in read_asset.TABLES + read_asset.FIELDS + others:
            if file[name].size:
                chunk = file[name].id.get_chunk_info(0)
                places[name] = chunk.byte_offset + chunk.size // 2
    copy, good = folder / "damaged.h5", True
    for name, place in places.items():
        assert place >= 0, name
        copy.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        try:
            read_asset.load(copy)
            ours = False
        except read_asset.Refused:
            ours = True
        points = folder / "points.csv"
        theirs = subprocess.run([volmap, "query", copy, "--points", points], capture_output=True).returncode == 1
        if not (ours and theirs):
            print(f"  FAILED: a flipped byte in {name} is accepted by {'volmap' if ours else 'read_asset.py'}")
            good = False
    print(f"  {len(places)} damaged copies {'refused' if good else 'tried'}")
    return good


def rounded_within_bound(path, exact_path):
    """The first holds the fields of the second, of f64, in 16 bits: no node differs by more than is promised."""
    rounded, exact = read_asset.load(path), read_asset.load(exact_path)
    good = (rounded.precision, exact.precision) == ("i16", "f64") and rounded.band.cells == exact.band.cells
    for name, bound in zip(("phi", "volume"), rounded.max_error):
        ours, theirs = getattr(rounded, name), getattr(exact, name)
        worst = np.abs(ours - theirs).max()
        within = 0 < worst <= bound and (ours[theirs == 0] == 0).all()
        print(f"  {name:8} rounded by at most {worst:.4e}, promised {bound:.4e}{'' if within else '  FAILED'}")
        good &= within
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", metavar="VOLMAP", required=True)
    parser.add_argument("assets", metavar="ASSET", nargs="+", type=pathlib.Path)
    parser.add_argument("--exact", metavar="ASSET", help="the fields before they were rounded to 16 bits")
    options = parser.parse_args()
    good = True
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for path in options.assets:
            good &= compare(options.against, path, folder)
            good &= refuse_damage(options.against, path, folder)
            good &= not options.exact or rounded_within_bound(path, options.exact)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
