#!/usr/bin/env python3
"""All of BENCHMARKS.md, one after the other: against SPlisHSPlasH, Table 1 of Bender et al. 2020, how it scales, pictures and files.

all.py --python VENV/bin/python        # of a virtual environment that has pysplishsplash (PyPI)

Builds the program first. Some ten minutes on two quiet processors.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--python", required=True)
args = parser.parse_args()
benches, sim = ROOT / "solver/benches", ROOT / "target/release/volmap-sim"
subprocess.run(["cargo", "build", "--release", "-p", "volmap-solver"], cwd=ROOT, check=True)
with tempfile.TemporaryDirectory() as folder:
    for title, command in [
        ("Against SPlisHSPlasH", [sys.executable, benches / "compare_splishsplash.py", "--python", args.python, "--threads", "1"]),
        ("Table 1 of Bender et al. 2020", [sim, "reproduce", "table1", "-o", folder]),
        ("How it scales", [sys.executable, benches / "scaling.py", "--steps", "12"]),
        ("Pictures and files", ["cargo", "bench", "-p", "volmap-scenes", "--bench", "output"]),
    ]:
        print(f"\n{title}\n", flush=True)
        subprocess.run(command, cwd=ROOT, check=True)
