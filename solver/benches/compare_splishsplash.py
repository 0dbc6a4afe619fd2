#!/usr/bin/env python3
"""A double dam break in volmap-sim and in SPlisHSPlasH (PyPI: pysplishsplash), in turns.

compare_splishsplash.py --python VENV/bin/python [--sim target/release/volmap-sim] [--steps 200] [--rounds 3] [--threads 2]

Both have 61,250 particles of radius 0.025 m and volume (2 rp)^3, cubic spline, the same tank and time-step rule, mean
errors of 0.05 % (density) and 0.1 % (divergence), volume maps; ours with the closures `offset`, which is nearly the
peer's, and `mirror`. The peer's own settings and masses are read from it, and the bench ends if they aren't ours.
Milliseconds a step, medians over the rounds of each round's mean, and the machine's load before each round. Beside them
is processor time, which what else runs disturbs less; with more than one thread the peer's waiting counts in it.
"""
import argparse
import json
import os
import pathlib
import re
import resource
import statistics
import subprocess
import tempfile

import splishsplash

ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCKS = [([-1.475, 0.025, -1.475], [-0.225, 2.475, -0.225]), ([0.225, 0.025, 0.225], [1.475, 2.475, 1.475])]
DAM = splishsplash.Conditions([[-1.55, 1.55], [-0.05, 3.05], [-1.55, 1.55]], BLOCKS)
VOLUME_MAP = 2

PEER = """
base = begin()
found, iterations, times = fluid_conditions(), [], []
def clocks():
    return time.perf_counter(), time.process_time()
started = clocks()
def after_step():
    global started
    times.append([1e3 * (now - then) for now, then in zip(clocks(), started)])
    if not iterations:
        found.update(tank_conditions())
    step = sph.Simulation.getCurrent().getTimeStep()
    iterations.append((step.getValueUInt(step.SOLVER_ITERATIONS), step.getValueUInt(step.SOLVER_ITERATIONS_V)))
    if len(iterations) >= int(sys.argv[3]):
        base.setValueFloat(base.STOP_AT, 1e-9)
    started = clocks()
base.setTimeStepCB(after_step)
base.runSimulation()
# The first step has the map's bake in it.
steps, seconds = times[1:], sph.TimeManager.getCurrent().getTime()
density, divergence = (sum(c) / len(iterations) for c in zip(*iterations))
step, cpu = (sum(c) / len(steps) for c in zip(*steps))
result = {"step": step, "cpu": cpu, "density": density, "divergence": divergence, "seconds": seconds}
print("RESULT", json.dumps({"conditions": found, "result": result}), flush=True)
base.cleanup()
"""


def cpu_of_ours(args, folder, closure, steps):
    """Runs ours; the processor time of it, milliseconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([args.sim, "run", DAM.our_scene(folder, closure), "-o", folder / closure, "--overwrite", "--quiet",
                    "--steps", str(steps), "--threads", str(args.threads)], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def run_ours(args, folder, closure):
    out = folder / closure
    # What is no step's: start, and the bake where the map isn't kept from before. The first run keeps it.
    start = min(cpu_of_ours(args, folder, closure, 1) for _ in range(2))
    cpu = (cpu_of_ours(args, folder, closure, args.steps) - start) / (args.steps - 1)
    found = json.loads((out / "stats.json").read_text())
    DAM.check("volmap-sim", {"particles": found["particles"]})
    stages = {name: spread["mean"] for name, spread in found["stages_ms"].items() if name != "output"}
    return {"step": sum(stages.values()), "cpu": cpu, "density": found["density_iterations"]["mean"],
            "divergence": found["divergence_iterations"]["mean"], "seconds": found["simulated_seconds"],
            **{f"{k}_ms": v for k, v in stages.items()}}


def run_peer(args, folder):
    scene = DAM.peer_scene(folder, VOLUME_MAP, [25, 25, 25])
    found, text = splishsplash.run_peer(args.python, PEER, scene, folder / "peer", args.threads, args.steps)
    DAM.check("SPlisHSPlasH", found["conditions"])
    stages = {f"{k}_ms": float(v) for k, v in re.findall(r"Average time: (\S+): ([\d.e+-]+) ms", text)}
    return {**found["result"], **stages}


def show(results):
    medians = {who: {key: statistics.median(run.get(key, 0.0) for run in runs) for key in runs[0]}
               for who, runs in results.items()}
    peer = medians["peer"]
    for who, median in medians.items():
        iterations = median["density"] + median["divergence"]
        times = {key: peer[key] / median[key] for key in ("step", "cpu")}
        per = {key: ratio * iterations / (peer["density"] + peer["divergence"]) for key, ratio in times.items()}
        steps = [run["step"] for run in results[who]]
        span = median["seconds"] / peer["seconds"]
        print(f"{who:8} {median['step']:7.1f} ms a step ({min(steps):.1f} to {max(steps):.1f}), "
              f"{median['density']:.2f} + {median['divergence']:.2f} iterations, {median['seconds']:.3f} s simulated; "
              f"processor time {median['cpu']:.1f} ms a step")
        for key, what in (("step", "wall clock"), ("cpu", "processor time")):
            print(f"         by {what}: {times[key]:.2f} x the peer's steps, {per[key]:.2f} x for each iteration, "
                  f"{times[key] * span:.2f} x for a simulated second")
        print("        ", ", ".join(f"{key[:-3]} {value:.2f}" for key, value in median.items() if key.endswith("_ms")))


def main():
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
        for round in range(args.rounds):
            for who, runs in results.items():
                load = os.getloadavg()[0]
                runs.append(run_peer(args, folder) if who == "peer" else run_ours(args, folder, who))
                print(f"round {round + 1}, {who}: {runs[-1]['step']:.1f} ms a step, "
                      f"{runs[-1]['cpu']:.1f} ms of processor time, load before it {load:.1f}", flush=True)
    show(results)


if __name__ == "__main__":
    main()
