#!/usr/bin/env python3
"""Time and memory of volmap-sim as a block of water in the corner of a tank grows.

scaling.py [--sim target/release/volmap-sim] [--steps 20] [--threads 2] [--particles 60000 250000 1000000 3000000]

Cubes of water of particle radius 0.025 m that fill half of their tank's floor edge, cells of the map half a support radius,
6 + 2 iterations in every step.
Prints nanoseconds a particle and step, iterations, and the process's largest resident memory.
"""
import argparse
import json
import os
import pathlib
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--sim", default=str(ROOT / "target/release/volmap-sim"))
parser.add_argument("--steps", type=int, default=20)
parser.add_argument("--threads", type=int, default=2)
parser.add_argument("--particles", type=int, nargs="+", default=[60_000, 250_000, 1_000_000, 3_000_000])
args = parser.parse_args()


def scene(count):
    edge = round(count ** (1 / 3)) * 0.05
    scale = 2 * edge / 3.1
    return {
        "version": 1, "particle_radius": 0.025,
        # The same work at every size.
        "solver": {"density": {"min_iterations": 6, "max_iterations": 6},
                   "divergence": {"min_iterations": 2, "max_iterations": 2}},
        "blocks": [{"min": [-edge, 0, -edge], "max": [0, edge, 0]}],
        "bodies": [{"name": "tank", "mesh": str(ROOT / "data/tank.obj"),
                    "bake": {"invert": True, "scale": [scale] * 3, "cell_size": 0.05}}],
        "output": {"frames_per_second": 0, "preview": [], "formats": [], "checkpoint_interval": 0}}


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    for count in args.particles:
        path = folder / "scene.json"
        path.write_text(json.dumps(scene(count)))
        command = [args.sim, "run", str(path), "-o", str(folder / str(count)), "--quiet", "--steps"]
        # Once for the cache of maps, so that the bake's memory isn't counted.
        os.spawnv(os.P_WAIT, args.sim, [*command, "1", "--overwrite"])
        process = os.spawnv(os.P_NOWAIT, args.sim, [*command, str(args.steps), "--threads", str(args.threads), "--overwrite"])
        _, status, usage = os.wait4(process, 0)
        assert status == 0
        found = json.loads((folder / str(count) / "stats.json").read_text())
        stages = {name: spread["mean"] for name, spread in found["stages_ms"].items() if name != "output"}
        iterations = found["density_iterations"]["mean"] + found["divergence_iterations"]["mean"]
        solve = (stages["pressure"] + stages["divergence"]) / iterations
        particles, step = found["particles"], sum(stages.values())
        print(f"{particles:9,} particles: {step:8.1f} ms a step, {iterations:.1f} iterations, "
              f"{1e6 * step / particles:.0f} ns a particle, {1e6 * (step - solve * iterations) / particles:.0f} of them without "
              f"the solves, {1e6 * solve / particles:.1f} an iteration, {usage.ru_maxrss / 1024:.0f} MB", flush=True)
