#!/usr/bin/env python3
"""Bakes the same maps with SPlisHSPlasH, the papers' own program, and with volmap, in turns, and prints a table.

    python3 baker/benches/compare_splishsplash.py --meshes FOLDER [--rounds 3] [--case dragon]

Needs Python 3 and volmap built (cargo build --release); makes an environment with pysplishsplash 2.19.0 in --venv
(default target/splishsplash) the first time. FOLDER holds SPlisHSPlasH's data/models: Dragon_50k.obj, UnitBox.obj,
sphere.obj, torus.obj. One thread each. The peer's time is what it prints for "SDF Construction" and "... Map
Construction"; volmap's is the whole process, from start to the asset on disk. Same mesh, box (the mesh's grown by 8 r),
support radius (0.1) and resolution; then volmap with its own domain, and with two threads.
"""
import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
R = 0.1
# Name, mesh, scale, inverted, resolution, the peer's boundary method (2 volume map, 3 tube map) and thread count.
CASES = [
    ("dragon 60x40x40", "Dragon_50k.obj", 1.0, False, (60, 40, 40), 2),
    ("tank 40^3", "UnitBox.obj", 3.1, True, (40, 40, 40), 2),
    ("sphere 40^3", "sphere.obj", 0.5, False, (40, 40, 40), 2),
    ("torus 40^3", "torus.obj", 0.5, False, (40, 40, 40), 2),
    ("torus 10^3, tube map", "torus.obj", 0.5, False, (10, 10, 10), 3),
]
RUN = """
import sys, pysplishsplash as sph
base = sph.Exec.SimulatorBase()
base.init(sceneFile=sys.argv[1], useGui=False, initialPause=False, useCache=False, outputDir=sys.argv[2], stopAt=1e-6)
base.initSimulation()
base.runSimulation()
base.cleanup()
"""


def environment(venv):
    python = os.path.join(venv, "bin", "python")
    if not os.path.exists(python):
        subprocess.run([sys.executable, "-m", "venv", venv], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "pysplishsplash==2.19.0"], check=True)
    return python


def scene(path, scale, invert, resolution, method):
    body = {"geometryFile": path, "translation": [0, 0, 0], "scale": [scale] * 3, "rotationAxis": [1, 0, 0],
            "rotationAngle": 0, "isDynamic": False, "isWall": invert, "mapInvert": invert, "mapThickness": 0.0,
            "mapResolution": list(resolution)}
    settings = {"particleRadius": R / 4, "simulationMethod": 4, "boundaryHandlingMethod": method,
                "timeStepSize": 0.001, "gravitation": [0, 0, 0]}
    return {"Configuration": settings, "Materials": [{"id": "Fluid", "density0": 1000}], "RigidBodies": [body],
            "FluidBlocks": [{"denseMode": 0, "start": [90, 90, 90], "end": [90.2, 90.2, 90.2]}]}


def peer(python, case, meshes, folder):
    _, mesh, scale, invert, resolution, method = case
    path = os.path.join(folder, "scene.json")
    with open(path, "w", encoding="utf-8") as out:
        json.dump(scene(os.path.join(meshes, mesh), scale, invert, resolution, method), out)
    # The wheel's libGLdispatch crashes with a newer system libGL unless the system's own comes first.
    env = dict(os.environ, OMP_NUM_THREADS="1", LD_PRELOAD="libGLdispatch.so.0")
    done = subprocess.run([python, "-c", RUN, path, folder], env=env, capture_output=True, text=True, check=True)
    times = re.findall(r"(?:SDF|Volume Map|Tube Map) Construction: ([\d.e+]+) ms", done.stdout + done.stderr)
    if len(times) < 2:
        raise SystemExit("the peer printed no times:\n" + (done.stdout + done.stderr)[-2000:])
    return sum(map(float, times)) / 1e3


def bounds(path, scale):
    corners = [[float(x) for x in line.split()[1:4]] for line in open(path, encoding="utf-8") if line.startswith("v ")]
    low = [scale * min(c[i] for c in corners) - 8 * R for i in range(3)]
    return low + [scale * max(c[i] for c in corners) + 8 * R for i in range(3)]


def volmap(program, case, meshes, folder, *options):
    _, mesh, scale, invert, resolution, _ = case
    command = [program, "bake", os.path.join(meshes, mesh), "-o", os.path.join(folder, "map.h5"), "--quiet",
               "--scale", str(scale), "--support-radius", str(R), "--resolution", ",".join(map(str, resolution)),
               *(["--invert"] if invert else []), *options]
    start = time.perf_counter()
    subprocess.run(command, check=True)
    return time.perf_counter() - start


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--meshes", required=True)
    ap.add_argument("--rounds", type=int, default=3)
    ap.add_argument("--case", default="")
    ap.add_argument("--venv", default=os.path.join(ROOT, "target", "splishsplash"))
    ap.add_argument("--volmap", default=os.path.join(ROOT, "target", "release", "volmap"))
    args = ap.parse_args()
    python, meshes = environment(args.venv), os.path.abspath(args.meshes)
    print("| case | peer, s | gl30, s | ratio | default, s | ratio | default, own domain, s | 2 threads, s | speed-up |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for case in (case for case in CASES if args.case in case[0]):
        rows = []
        box = "--domain=" + ",".join(map(str, bounds(os.path.join(meshes, case[1]), case[2])))
        for _ in range(args.rounds):
            with tempfile.TemporaryDirectory() as folder:
                rows.append((
                    peer(python, case, meshes, folder),
                    volmap(args.volmap, case, meshes, folder, box, "--threads", "1", "--quadrature", "gl30"),
                    volmap(args.volmap, case, meshes, folder, box, "--threads", "1"),
                    volmap(args.volmap, case, meshes, folder, "--threads", "1"),
                    volmap(args.volmap, case, meshes, folder, box, "--threads", "2"),
                ))
        p, gl30, default, own, two = (statistics.median(column) for column in zip(*rows))
        ratio = lambda a, b: statistics.median(row[a] / row[b] for row in rows)
        print(f"| {case[0]} | {p:.3f} | {gl30:.4f} | {ratio(0, 1):.1f} | {default:.4f} | {ratio(0, 2):.1f} | {own:.4f} "
              f"| {two:.4f} | {ratio(2, 4):.2f} |", flush=True)


main()
