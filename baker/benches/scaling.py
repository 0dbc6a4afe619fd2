#!/usr/bin/env python3
"""Time and memory of bakes against cells and against triangles, with fitted exponents.

    python3 baker/benches/scaling.py --mesh dragon.obj [--triangles a.stl b.stl ...]

Whole process, best of --rounds; peak memory as the system counts it. The exponent is that of the last step.
"""
import argparse
import json
import math
import os
import subprocess
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


def bake(program, mesh, rounds, *options):
    best, info = math.inf, {}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            command = [program, "bake", mesh, "-o", os.path.join(folder, "map.h5"), "--json", *options]
            start = time.perf_counter()
            child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
            text = child.stdout.read()
            _, status, usage = os.wait4(child.pid, 0)
            best = min(best, time.perf_counter() - start)
            if status:
                raise SystemExit(f"{command} failed")
            info = dict(json.loads(text), peak=usage.ru_maxrss / 1024)
    return best, info


def exponents(rows, column):
    out = ["" for _ in rows]
    for i in range(1, len(rows)):
        (a, *x), (b, *y) = rows[i - 1], rows[i]
        out[i] = f"{math.log(y[column] / x[column]) / math.log(b / a):.2f}"
    return out


def table(title, rows):
    time_exponent, memory_exponent = exponents(rows, 0), exponents(rows, 1)
    print(f"\n| {title} | seconds | exponent | peak, MiB | exponent |\n| --- | --- | --- | --- | --- |")
    for row, t, m in zip(rows, time_exponent, memory_exponent):
        print(f"| {row[0]:,} | {row[1]:.3f} | {t} | {row[2]:.0f} | {m} |", flush=True)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--mesh", required=True)
    ap.add_argument("--radius", default="0.05")
    ap.add_argument("--triangles", nargs="*", default=[])
    ap.add_argument("--rounds", type=int, default=2)
    ap.add_argument("--threads", default="1")
    ap.add_argument("--volmap", default=os.path.join(ROOT, "target", "release", "volmap"))
    args = ap.parse_args()
    rows = []
    for n in (1, 2, 4, 8):
        options = ["--resolution", f"{30 * n},{20 * n},{20 * n}", "--support-radius", args.radius]
        seconds, info = bake(args.volmap, args.mesh, args.rounds, "--threads", args.threads, "--max-memory", "16GiB", *options)
        rows.append((info["cells"]["band"], seconds, info["peak"]))
    table("cells of the band", rows)
    rows = []
    for mesh in args.triangles:
        options = ["--resolution", "60", "--support-radius", "0.1", "--threads", args.threads]
        seconds, info = bake(args.volmap, mesh, args.rounds, *options)
        rows.append((info["source"]["triangles"], seconds, info["peak"]))
    if rows:
        table("triangles", rows)


main()
