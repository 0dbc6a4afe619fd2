#!/usr/bin/env python3
"""The authors' own tube maps (SPlisHSPlasH 2.19, PyPI: pysplishsplash) in the experiment `tubes` of volmap-sim.

compare_tube_maps.py --python VENV/bin/python [--order 2] [--cells 4] [--threads 2] [--density-maps] [--no-scene]

Needs numpy. Densities at 0.5 to 3 rp from the solids of `volmap-sim reproduce tubes`, over the integral of gamma W (gamma
ending at r / 5, as their density maps have it): rms errors in percent of the peer's tube maps and, as a check of the
integral, of its density maps (minutes each). Then the scene with a ridge and a plate of r / 4 and r / 16. Cells of
r / `cells`.
"""
import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile

import numpy as np

import splishsplash

RP, R = 0.025, 0.1
METHODS = {"tube map": 3, "density map": 1}

# One particle is put where a density is wanted, step by step; what it sees is read before it is moved on.
DENSITIES = """
import json, sys
import pysplishsplash as sph
base = sph.Exec.SimulatorBase()
base.init(sceneFile=sys.argv[1], useGui=False, initialPause=False, useCache=False, outputDir=sys.argv[2], stopAt=1e9)
base.initSimulation()
simulation, points, found = sph.Simulation.getCurrent(), json.loads(sys.argv[3]), []
model = simulation.getFluidModel(0)
def after_step():
    found.append(simulation.getBoundaryModel(0).getBoundaryDensity(0, 0))
    if len(found) <= len(points):
        model.setPosition(0, points[len(found) - 1])
        model.setVelocity(0, [0.0, 0.0, 0.0])
    else:
        base.setValueFloat(base.STOP_AT, 1e-12)
base.setTimeStepCB(after_step)
base.runSimulation()
print("RESULT", json.dumps(found[1:]), flush=True)
"""

POUR = """
import json, sys
import pysplishsplash as sph
base = sph.Exec.SimulatorBase()
base.init(sceneFile=sys.argv[1], useGui=False, initialPause=False, useCache=False, outputDir=sys.argv[2], stopAt=2.0)
base.initSimulation()
model, fastest = sph.Simulation.getCurrent().getFluidModel(0), [0.0]
def speeds():
    return [sum(float(c) ** 2 for c in model.getVelocity(i)) for i in range(model.numActiveParticles())]
def after_step():
    fastest[0] = max(fastest[0], max(speeds()) ** 0.5)
base.setTimeStepCB(after_step)
base.runSimulation()
places = [[float(c) for c in model.getPosition(i)] for i in range(model.numActiveParticles())]
rms, mass = (sum(speeds()) / len(places)) ** 0.5, model.getMass(0)
print("RESULT", json.dumps({"places": places, "fastest": fastest[0], "rms": rms, "mass": mass}), flush=True)
"""


def cuboid(low, high):
    vertices = [[(low, high)[n >> axis & 1][axis] for axis in range(3)] for n in range(8)]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def ball(radius, levels=5):
    points = [np.array(p, float) for p in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1))]
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    for _ in range(levels):
        middles, quarters = {}, []
        for face in faces:
            new = []
            for a, b in zip(face, face[1:] + face[:1]):
                key = (min(a, b), max(a, b))
                if key not in middles:
                    middles[key] = len(points)
                    points.append((points[a] + points[b]) / np.linalg.norm(points[a] + points[b]))
                new.append(middles[key])
            (a, b, c), (ab, bc, ca) = face, new
            quarters += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = quarters
    return [list(radius * p) for p in points], faces


def prism(section, half):
    n = len(section)
    vertices = [[x, y, z] for z in (-half, half) for x, y in section] + [[0, 0, -half], [0, 0, half]]
    faces = []
    for i in range(n):
        a, b = i, (i + 1) % n
        faces += [(a, b, b + n), (a, b + n, a + n), (2 * n, b, a), (2 * n + 1, a + n, b + n)]
    return vertices, faces


def box_distance(low, high):
    def distance(x):
        out = np.maximum(np.array(low) - x, x - np.array(high))
        return np.linalg.norm(np.maximum(out, 0), axis=-1) + np.minimum(out.max(axis=-1), 0)
    return distance


def solids():
    """Name, mesh, whether the solid is outside, distance, where a ray begins and its way; as in reproduce/tubes.rs."""
    half, aside, slant = [0.3] * 3, np.array([0.013, 0, 0.021]), np.array([0.48, 0.6, 0.64])

    def cube(name, low, high, invert, start, way):
        way = np.array(way, float) / np.linalg.norm(way)
        return name, cuboid(low, high), invert, box_distance(low, high), np.array(start, float), way

    def round_one(name, radius, invert):
        return name, ball(radius), invert, lambda x: np.linalg.norm(x, axis=-1) - radius, radius * slant, -slant if invert else slant

    circle = [(R * math.cos(a), R * math.sin(a)) for a in (2 * math.pi * n / 240 for n in range(240))]
    low = [-v for v in half]
    return [
        cube("plane", low, half, False, np.array([0, 0.3, 0]) + aside, [0, 1, 0]),
        round_one("ball of 4 r", 4 * R, False), round_one("ball of r", R, False), round_one("ball of r / 2", R / 2, False),
        round_one("hollow of 4 r", 4 * R, True),
        ("cylinder of r", prism(circle, 0.5), False, lambda x: np.linalg.norm(x[..., :2], axis=-1) - R,
         R * np.array([0.6, 0.8, 0]), np.array([0.6, 0.8, 0])),
        cube("convex edge", low, half, False, [0.3, 0.3, 0], [1, 1, 0]),
        cube("convex corner", low, half, False, half, [1, 1, 1]),
        cube("concave edge", low, half, True, [0.3, 0.3, 0], [-1, -1, 0]),
        cube("concave corner", low, half, True, half, [-1, -1, -1]),
        cube("plate of r / 4", [-0.3, -R / 4, -0.3], [0.3, 0, 0.3], False, aside, [0, 1, 0]),
        cube("gap of r", [-0.3, -R, -0.3], [0.3, 0, 0.3], True, aside, [0, -1, 0]),
    ]


GROUPS = [("all smooth ones", 0, 6), ("all edges and corners", 6, 10), ("plate and gap", 10, 12)]


def kernel(s):
    q = s / R
    return 8 / math.pi / R**3 * np.where(q < 0.5, 6 * (q**3 - q**2) + 1, np.where(q < 1, 2 * (1 - q) ** 3, 0))


def integral(distance, invert, place, across=64):
    """Of gamma W, by the middles of small cubes."""
    edge = 2 * R / across
    middles = (np.arange(across) + 0.5) * edge - R
    ways = np.stack(np.meshgrid(middles, middles, middles, indexing="ij"), -1).reshape(-1, 3)
    weights = kernel(np.linalg.norm(ways, axis=1)) * edge**3
    phi = distance(ways + place) * (-1 if invert else 1)
    return float((weights * np.maximum(1 - phi / (R / 5), 0)).sum())


def body(folder, name, mesh, invert, translation, support, cells, order):
    vertices, faces = mesh
    path = folder / f"{name.replace(' ', '_').replace('/', 'over')}.obj"
    lines = ["v %.9g %.9g %.9g" % tuple(v) for v in vertices] + ["f %d %d %d" % tuple(i + 1 for i in f) for f in faces]
    path.write_text("\n".join(lines) + "\n")
    # The peer's grid is the box of the mesh and 8 support radii around it.
    size = np.ptp(np.array(vertices, float), axis=0) + 16 * support
    return {"geometryFile": str(path), "translation": list(translation), "rotationAxis": [1, 0, 0], "rotationAngle": 0,
            "scale": [1, 1, 1], "isDynamic": False, "isWall": invert, "mapInvert": invert, "mapThickness": 0.0,
            "mapResolution": [math.ceil(s / support * cells) for s in size], "tubeMapOrder": order}


def peer(args, folder, program, scene, *more):
    path = folder / "scene.json"
    path.write_text(json.dumps(scene))
    env = dict(os.environ, LD_PRELOAD="libGLdispatch.so.0", OMP_NUM_THREADS=str(args.threads))
    done = subprocess.run([args.python, "-c", program, path, folder / "out", *more], env=env, capture_output=True, text=True)
    found = re.findall(r"RESULT (.*)", done.stdout)
    if not found:
        raise SystemExit(f"the peer ended with {done.returncode}:\n{(done.stdout + done.stderr)[-2000:]}")
    return json.loads(found[0])


def scene(method, radius, bodies, low, high, gravity, **more):
    solve = {"minIterations": 2, "maxIterations": 100, "maxError": 0.05, "maxIterationsV": 100, "maxErrorV": 0.1}
    return {"Configuration": {"particleRadius": radius, "simulationMethod": 4, "gravitation": [0, gravity, 0],
                              "boundaryHandlingMethod": method, "DFSPH": solve, **more},
            "Materials": [{"id": "Fluid", "density0": 1000, "viscosityMethod": 1, "Standard viscosity": {"viscosity": 0.01}}],
            "RigidBodies": bodies, "FluidBlocks": [{"denseMode": 0, "start": low, "end": high}]}


def compare(args, folder):
    errors = {method: [] for method in args.methods}
    for name, mesh, invert, distance, start, way in solids():
        places = [start + d * RP * way for d in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0) if name != "gap of r" or d <= 2.0]
        exact = np.array([integral(distance, invert, place) for place in places])
        for method in args.methods:
            solid = body(folder, name, mesh, invert, [0, 0, 0], R, args.cells, args.order)
            far = scene(METHODS[method], RP, [solid], [-0.1, 10, -0.1], [0.1, 10.2, 0.1], 0, cflMethod=0, timeStepSize=1e-7)
            found = peer(args, folder, DENSITIES, far, json.dumps([list(place) for place in places]))
            errors[method].append(100 * np.sqrt(np.mean((np.array(found) / exact - 1) ** 2)))
        print(f"{name:24}", ", ".join(f"{method} {all[-1]:6.1f} %" for method, all in errors.items()), flush=True)
    for name, first, end in GROUPS:
        means = {method: np.sqrt(np.mean(np.square(all[first:end]))) for method, all in errors.items()}
        print(f"{name:24}", ", ".join(f"{method} {mean:6.1f} %" for method, mean in means.items()))


def pour(args, folder, method, thickness):
    radius, half, depth, height = 0.015, 0.3, 0.15, 0.7
    support, plate = 4 * radius, 0.5 * thickness * radius
    shapes = [("tank", cuboid([-half, 0, -depth], [half, height, depth]), True, [0, 0, 0]),
              ("plate", cuboid([-plate, -0.1, -depth - 0.1], [plate, height, depth + 0.1]), False, [0, 0, 0]),
              ("ridge", prism([(0, 0.1), (-0.04, -0.05), (0.04, -0.05)], depth + 0.1), False, [-half / 2, 0.05, 0])]
    bodies = [body(folder, *shape, support, args.cells, args.order) for shape in shapes]
    low, high = [-half, 0.2 - radius, -depth], [-plate, 0.6 + radius, depth]
    found = peer(args, folder, POUR, scene(METHODS[method], radius, bodies, low, high, -9.81, cflMethod=1, cflFactor=1,
                                           cflMaxTimeStepSize=0.002, timeStepSize=0.001))
    if not splishsplash.same(found["mass"], 1000 * (2 * radius) ** 3):
        raise SystemExit(f"the peer's particles have {found['mass']:g} kg instead of {1000 * (2 * radius) ** 3:g}, as ours")
    places = np.array(found["places"])
    finite = np.isfinite(places).all(axis=1)
    inner = (np.abs(places[:, 0]) < half + radius) & (np.abs(places[:, 2]) < depth + radius) & (places[:, 1] > -radius)
    print(f"plate of {thickness} rp, {method}: through {100 * np.mean(places[finite, 0] > 0):.1f} %, out of the tank "
          f"{int((~(inner & finite)).sum())} of {len(places)}, largest speed over a free fall's "
          f"{found['fastest'] / math.sqrt(2 * 9.81 * 0.6):.2f}, rms speed at the end {found['rms']:.3f} m/s", flush=True)


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--python", required=True)
parser.add_argument("--order", type=int, default=2, help="0: planes, 1: mean curvature, 2: Gaussian curvature as well")
parser.add_argument("--cells", type=float, default=4, help="cells in a support radius")
parser.add_argument("--threads", type=int, default=2)
parser.add_argument("--density-maps", action="store_true", help="those as well")
parser.add_argument("--no-scene", action="store_true", help="densities only")
args = parser.parse_args()
args.methods = list(METHODS) if args.density_maps else ["tube map"]
with tempfile.TemporaryDirectory() as name:
    compare(args, pathlib.Path(name))
    for thickness in () if args.no_scene else (1.0, 0.25):
        for method in args.methods:
            pour(args, pathlib.Path(name), method, thickness)
