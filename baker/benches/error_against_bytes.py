#!/usr/bin/env python3
"""Largest and root mean square error of the volume against the bytes of the file: equal cells, and cells of several
sizes whose volume is stored as it is or as its difference from a flat wall's.

    cargo build --release -p volmap-baker
    python3 baker/benches/error_against_bytes.py FOLDER [MESH ...]

Without meshes: duck, grid, tank, canyon of `data/` and a tilted plate of r / 4. All errors of a mesh are measured by
`volmap report` at the same kind of points of the fluid, against `chord20` on the exact distance to the mesh. FOLDER gets
`curves.csv` and one SVG for each mesh. A step of a ladder is left out, and told, where a bake is refused for its memory.
"""

import csv
import json
import math
import pathlib
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[2]
VOLMAP = PROJECT / "target/release/volmap"
POINTS = ["--points", "4000", "--mesh-points", "2000", "--pixels", "0"]
# Cells as parts of the support radius, and tolerances.
EQUAL = [2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25]
ADAPTIVE = ["10%", "5%", "2.5%", "1.2%", "0.6%", "0.3%"]
COLOURS = {"equal cells": "#0072b2", "adaptive, plain": "#e69f00", "adaptive, by difference": "#d55e00"}


def plate(folder):
    """A plate of 1 x 0.0125 x 0.7 m, turned by 20 and 10 degrees: a quarter of the support radius thin."""
    corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.00625, 0.00625) for z in (-0.35, 0.35)]
    a, b = math.radians(20), math.radians(10)
    turned = []
    for x, y, z in corners:
        x, y = x * math.cos(a) - y * math.sin(a), x * math.sin(a) + y * math.cos(a)
        y, z = y * math.cos(b) - z * math.sin(b), y * math.sin(b) + z * math.cos(b)
        turned.append(f"v {x:.9f} {y:.9f} {z:.9f}")
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    path = folder / "plate.obj"
    path.write_text("\n".join(turned + ["f " + face for face in faces]) + "\n")
    return path


def meshes(folder, given):
    if given:
        return [(pathlib.Path(path), None, []) for path in given]
    data = PROJECT / "data"
    return [
        (data / "duck.obj", None, []),
        (data / "grid.obj", None, []),
        (data / "tank.obj", None, ["--invert"]),
        (data / "canyon.obj", 0.4, []),
        (plate(folder), 0.05, []),
    ]


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    return done.returncode == 0, (done.stderr or done.stdout).strip()


def measured(mesh, asset, options):
    """Bytes and errors of one bake; none if it is refused."""
    good, told = run(VOLMAP, "bake", mesh, *options, "-q", "-o", asset)
    if not good:
        print(f"    left out: {' '.join(options)}: {told.splitlines()[-1][:140]}")
        return None
    good, told = run(VOLMAP, "report", asset, "--mesh", mesh, *POINTS, "-o", asset.with_suffix(""))
    if not good:
        raise SystemExit(f"{asset}: {told}")
    report = json.loads(asset.with_suffix(".report.json").read_text())
    fluid = [e for e in report["volume"] if (e["reference"], e["region"]) == ("fine-mesh", "fluid")]
    return asset.stat().st_size, fluid[0]["fraction"]["max"], fluid[0]["fraction"]["rms"]


def curves(mesh, radius, options, folder):
    if radius is None:
        run(VOLMAP, "bake", mesh, "-q", "-o", folder / "r.h5")
        done = subprocess.run([VOLMAP, "info", folder / "r.h5", "--json"], capture_output=True, text=True, check=True)
        radius = json.loads(done.stdout)["support_radius"]
    common = [*options, "--support-radius", str(radius)]
    rounded = ["--max-rounding", "0.025%"]
    ladder = {
        "equal cells": [["--cell-size", f"{part * radius:.6g}", *rounded] for part in EQUAL],
        "adaptive, plain": [["--tolerance", t, "--plain-volume", *rounded] for t in ADAPTIVE],
        "adaptive, by difference": [["--tolerance", t, *rounded] for t in ADAPTIVE],
    }
    out = {}
    for name, steps in ladder.items():
        found = []
        for step in steps:
            result = measured(mesh, folder / "a.h5", [*common, *step])
            if result:
                found.append(result)
                print(f"  {name:24} {' '.join(step[:2]):24} {result[0]:10,} bytes, {result[1]:.3%}, rms {result[2]:.4%}", flush=True)
        out[name] = found
    return out


def drawn(name, found):
    """Two panels on logarithmic axes: largest and root mean square error."""
    width, height, left, top = 420, 330, 62, 34
    every = [point for points in found.values() for point in points]
    low_x = math.floor(math.log10(min(p[0] for p in every)))
    high_x = math.ceil(math.log10(max(p[0] for p in every)))
    low_y = math.floor(math.log10(min(p[2] for p in every)))
    high_y = math.ceil(math.log10(max(p[1] for p in every)))
    parts = []
    for panel, (title, column) in enumerate([("largest error", 1), ("root mean square error", 2)]):
        x0 = left + panel * (width + left + 14)

        def at(size, error):
            x = x0 + width * (math.log10(size) - low_x) / (high_x - low_x)
            return x, top + height * (high_y - math.log10(error)) / (high_y - low_y)

        parts.append(f'<text x="{x0 + width / 2}" y="{top - 12}" text-anchor="middle">{name}: {title}</text>')
        for power in range(low_x, high_x + 1):
            x, _ = at(10.0**power, 10.0**low_y)
            label = f"{10 ** power // 1000:,} kB" if power >= 3 else f"{10 ** power} B"
            parts.append(f'<path d="M{x:.1f} {top}v{height}" class="grid"/>')
            parts.append(f'<text x="{x:.1f}" y="{top + height + 18}" text-anchor="middle">{label}</text>')
        for power in range(low_y, high_y + 1):
            _, y = at(10.0**low_x, 10.0**power)
            parts.append(f'<path d="M{x0} {y:.1f}h{width}" class="grid"/>')
            parts.append(f'<text x="{x0 - 6}" y="{y + 4:.1f}" text-anchor="end">{100 * 10.0 ** power:g} %</text>')
        for curve, points in found.items():
            places = [at(point[0], point[column]) for point in points]
            path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
            colour = COLOURS[curve]
            parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
            parts.extend(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>' for x, y in places)
    for n, (curve, colour) in enumerate(COLOURS.items()):
        x, y = left + n * 210, top + height + 46
        parts.append(f'<circle cx="{x}" cy="{y - 4}" r="5" fill="{colour}"/><text x="{x + 10}" y="{y}">{curve}</text>')
    size = (2 * (width + left) + 70, top + height + 62)
    style = "text{font:13px sans-serif;fill:#222}.grid{stroke:#ddd;fill:none}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" width="{size[0]}" height="{size[1]}">'
        f'<style>{style}</style><rect width="100%" height="100%" fill="white"/>{"".join(parts)}</svg>\n'
    )


def main():
    if len(sys.argv) < 2:
        raise SystemExit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "curves.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["mesh", "curve", "bytes", "largest error, part of the ball", "rms"])
        for mesh, radius, options in meshes(folder, sys.argv[2:]):
            print(mesh.name, flush=True)
            found = curves(mesh, radius, options, folder)
            (folder / f"{mesh.stem}.svg").write_text(drawn(mesh.stem, found))
            rows.writerows([mesh.stem, name, *point] for name, points in found.items() for point in points)
            file.flush()


if __name__ == "__main__":
    main()
