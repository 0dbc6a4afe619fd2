#!/usr/bin/env python3
"""A double dam break in volmap-sim and in SPlisHSPlasH (PyPI: pysplishsplash), in turns.

compare_splishsplash.py --python VENV/bin/python [--sim target/release/volmap-sim] [--steps 200] [--rounds 3] [--threads 2]

Both have 61,250 particles of radius 0.025 m and volume 0.8 (2 r)^3, cubic spline, the same tank and time-step rule, mean
errors of 0.05 % (density) and 0.1 % (divergence), volume maps; ours with the closures `offset`, which is the peer's, and
`mirror`. Milliseconds a step, medians over the rounds of each round's mean.
"""
import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCKS = [([-1.475, 0.025, -1.475], [-0.225, 2.475, -0.225]), ([0.225, 0.025, 0.225], [1.475, 2.475, 1.475])]

PEER = """
import json, sys, time
import pysplishsplash as sph
base = sph.Exec.SimulatorBase()
base.init(sceneFile=sys.argv[1], useGui=False, initialPause=False, useCache=False, outputDir=sys.argv[2], stopAt=1e9)
base.initSimulation()
simulation, iterations, times = sph.Simulation.getCurrent(), [], [time.perf_counter()]
def after_step():
    times.append(time.perf_counter())
    step = simulation.getTimeStep()
    iterations.append((step.getValueUInt(step.SOLVER_ITERATIONS), step.getValueUInt(step.SOLVER_ITERATIONS_V)))
    if len(iterations) >= int(sys.argv[3]):
        base.setValueFloat(base.STOP_AT, 1e-9)
base.setTimeStepCB(after_step)
base.runSimulation()
ms = [1e3 * (b - a) for a, b in zip(times[1:], times[2:])]
density, divergence = (sum(c) / len(iterations) for c in zip(*iterations))
print("RESULT", json.dumps({"step": sum(ms) / len(ms), "density": density, "divergence": divergence}), flush=True)
base.cleanup()
"""


def peer_scene(folder):
    """The peer's scene, with the unit cube that our tank is."""
    obj = folder / "cube.obj"
    corners = [(x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
    quads = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    lines = ["v %g %g %g" % c for c in corners]
    lines += [f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads]
    obj.write_text("\n".join(lines) + "\n")
    path = folder / "peer.json"
    path.write_text(json.dumps({
        "Configuration": {
            "particleRadius": 0.025, "simulationMethod": 4, "gravitation": [0, -9.81, 0], "cflMethod": 1, "cflFactor": 1,
            "cflMaxTimeStepSize": 0.005, "timeStepSize": 0.001, "boundaryHandlingMethod": 2,
            "DFSPH": {"minIterations": 2, "maxIterations": 100, "maxError": 0.05, "maxIterationsV": 100,
                      "maxErrorV": 0.1, "enableDivergenceSolver": True}},
        "Materials": [{"id": "Fluid", "density0": 1000, "viscosityMethod": 1, "Standard viscosity": {"viscosity": 0.01}}],
        "RigidBodies": [{"geometryFile": str(obj), "translation": [0, 1.5, 0], "rotationAxis": [1, 0, 0],
                         "rotationAngle": 0, "scale": [3.1] * 3, "isDynamic": False, "isWall": True, "mapInvert": True,
                         "mapThickness": 0.0, "mapResolution": [25, 25, 25]}],
        "FluidBlocks": [{"denseMode": 0, "start": [a - 0.025 for a in low], "end": [b + 0.025 for b in high]}
                        for low, high in BLOCKS]}))
    return path


def our_scene(folder, closure):
    path = folder / f"{closure}.json"
    path.write_text(json.dumps({
        "version": 1, "particle_radius": 0.025, "closure": closure, "solver": {"time_step": {"max": 0.005}}, "fluid": {"volume_factor": 0.8},
        "blocks": [{"min": low, "max": high} for low, high in BLOCKS],
        "bodies": [{"name": "tank", "mesh": str(ROOT / "data/tank.obj"), "bake": {"invert": True},
                    "translation": [0, -0.05, 0]}],
        "output": {"frames_per_second": 0, "preview": [], "formats": [], "checkpoint_interval": 0}}))
    return path


def run_ours(args, folder, closure):
    out = folder / closure
    subprocess.run([args.sim, "run", our_scene(folder, closure), "-o", out, "--overwrite", "--quiet", "--steps",
                    str(args.steps), "--threads", str(args.threads)], check=True)
    found = json.loads((out / "stats.json").read_text())
    stages = {name: spread["mean"] for name, spread in found["stages_ms"].items() if name != "output"}
    return {"step": sum(stages.values()), "density": found["density_iterations"]["mean"],
            "divergence": found["divergence_iterations"]["mean"], **{f"{k}_ms": v for k, v in stages.items()}}


def run_peer(args, folder):
    env = dict(os.environ, LD_PRELOAD="libGLdispatch.so.0", OMP_NUM_THREADS=str(args.threads))
    done = subprocess.run([args.python, "-c", PEER, peer_scene(folder), folder / "peer", str(args.steps)], env=env,
                          capture_output=True, text=True)
    text = done.stdout + done.stderr
    result = json.loads(re.findall(r"RESULT (.*)", text)[0])
    stages = {f"{k}_ms": float(v) for k, v in re.findall(r"Average time: (\S+): ([\d.e+-]+) ms", text)}
    return {**result, **stages}


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--python", required=True)
parser.add_argument("--sim", default=str(ROOT / "target/release/volmap-sim"))
parser.add_argument("--steps", type=int, default=200)
parser.add_argument("--rounds", type=int, default=3)
parser.add_argument("--threads", type=int, default=2)
args = parser.parse_args()
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    results = {"peer": [], "offset": [], "mirror": []}
    for _ in range(args.rounds):
        results["peer"].append(run_peer(args, folder))
        for closure in ("offset", "mirror"):
            results[closure].append(run_ours(args, folder, closure))
medians = {who: {key: statistics.median(run.get(key, 0.0) for run in runs) for key in runs[0]}
           for who, runs in results.items()}
for who, median in medians.items():
    iterations = median["density"] + median["divergence"]
    peer = medians["peer"]
    per = (peer["step"] / (peer["density"] + peer["divergence"])) / (median["step"] / iterations)
    print(f"{who:8} {median['step']:7.1f} ms a step, {median['density']:.2f} + {median['divergence']:.2f} iterations, "
          f"{peer['step'] / median['step']:.2f} x the peer's steps, {per:.2f} x for each iteration")
    print("        ", ", ".join(f"{key[:-3]} {value:.2f}" for key, value in median.items() if key.endswith("_ms")))
