#!/usr/bin/env python3
"""A folder of real meshes through `volmap batch`, in every way that a pipeline treats it: the tables of BENCHMARKS.md.

    python3 baker/benches/batch_pool.py MESHES [--volmap target/release/volmap] [--work FOLDER]

MESHES: any folder; those of the tables are Debian's packages libcgal-demo (data.tar.gz, demo.tar.gz and examples.tar.gz
unpacked) and assimp-testmodels. Needs nothing but Python. Takes some ten minutes.
"""
import argparse
import collections
import hashlib
import json
import os
import pathlib
import random
import shutil
import subprocess
import time

ENDINGS = "obj stl ply off gltf glb 3mf vtk vtu vtp".split()


def manifest_of(meshes):
    text = "version = 1\n[defaults]\ntimeout = 300\n"
    for ending in ENDINGS:
        text += f'[[assets]]\nmesh = "{meshes.name}/**/*.{ending}"\nname = "{{path}}.{{extension}}"\n'
    return text


class Pool:
    def __init__(self, volmap, work):
        self.volmap, self.work = volmap, work

    def run(self, out, *more, kill_after=None):
        """Seconds, exit code; `kill_after` seconds it is killed, with no warning."""
        command = [self.volmap, "batch", "pool.toml", "--out", out, "-q", *more]
        start = time.time()
        process = subprocess.Popen(command, cwd=self.work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            code = process.wait(timeout=kill_after)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        return time.time() - start, code

    def summary(self, out):
        return json.loads((self.work / out / "summary.json").read_text())

    def counts(self, out):
        return {name: count for name, count in self.summary(out)["counts"].items() if count}

    def hashes(self, out):
        files = sorted((self.work / out).rglob("*.h5"))
        relative = lambda file: str(file.relative_to(self.work / out))
        return {relative(file): hashlib.blake2b(file.read_bytes()).hexdigest() for file in files}


def row(what, seconds, result):
    print(f"| {what} | {seconds:.1f} s | {result} |", flush=True)


def told(counts):
    return ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counts.items())


def first_good(pool, out, count):
    good = [a for a in pool.summary(out)["assets"] if a["outcome"] == "unchanged" and a["mesh"].endswith(".off")]
    return good[:count]


def changes(pool):
    touched, changed, corrupted = first_good(pool, "whole", 3)
    os.utime(pool.work / touched["mesh"])
    mesh = pool.work / changed["mesh"]
    before = mesh.read_bytes()
    mesh.write_bytes(before.rstrip() + b"\n\n")
    asset = pool.work / "whole" / corrupted["output"]
    content = bytearray(asset.read_bytes())
    content[len(content) // 2] ^= 1
    asset.write_bytes(content)
    seconds, _ = pool.run("whole")
    by_name = {a["name"]: a for a in pool.summary("whole")["assets"]}
    is_ = lambda asset: f"{by_name[asset['name']]['outcome']} ({by_name[asset['name']]['reason']})"
    row("one touched, one changed, one with a bit turned", seconds, told(pool.counts("whole")))
    for what, asset in [("touched", touched), ("changed", changed), ("bit turned", corrupted)]:
        print(f"|   {what} | | {is_(asset)} |")
    mesh.write_bytes(before)
    pool.run("whole")


def kills(pool, whole, times):
    random.seed(1)
    longest, total, moments = whole * 0.12, 0.0, []
    for _ in range(times):
        moment = random.uniform(0.05, longest)
        moments.append(moment)
        seconds, _ = pool.run("killed", kill_after=moment)
        total += seconds
    seconds, _ = pool.run("killed")
    same = pool.hashes("killed") == pool.hashes("whole")
    left = [str(file) for file in (pool.work / "killed").rglob("*.part")]
    row(f"killed {times} times (SIGKILL, after {min(moments):.1f} to {max(moments):.1f} s), then to its end",
        total + seconds, f"{told(pool.counts('killed'))}; same bytes as undisturbed: {same}; leftovers: {len(left)}")


def writers(pool):
    start = time.time()
    command = lambda out: [pool.volmap, "batch", "pool.toml", "--out", out, "-q", "--cache", "cache"]
    both = [subprocess.Popen(command(out), cwd=pool.work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for out in ("one", "two")]
    codes = [process.wait() for process in both]
    whole = pool.hashes("whole")
    same = pool.hashes("one") == whole and pool.hashes("two") == whole
    row("two batches at once on one cache", time.time() - start,
        f"exit codes {codes}; {told(pool.counts('one'))}; {told(pool.counts('two'))}; same bytes as alone: {same}")
    seconds, _ = pool.run("three", "--cache", "cache")
    row("a third, with that cache", seconds,
        f"{told(pool.counts('three'))}; same bytes: {pool.hashes('three') == whole}")


def shards(pool, count):
    loads, total = [], 0.0
    for index in range(1, count + 1):
        seconds, _ = pool.run("shards", "--shard", f"{index}/{count}")
        loads.append(seconds)
        total += seconds
    subprocess.run([pool.volmap, "batch", "--merge", "shards", "-q"], cwd=pool.work, stdout=subprocess.DEVNULL)
    plain = lambda out: [{k: v for k, v in a.items() if k not in ("seconds", "threads", "peak_memory", "reason")}
                         for a in pool.summary(out)["assets"]]
    # Both were built once; of one it is some runs ago.
    once = lambda out: [{**a, "outcome": a["outcome"].replace("built", "unchanged")} for a in plain(out)]
    same = once("shards") == once("whole") and pool.hashes("shards") == pool.hashes("whole")
    row(f"{count} shards, one after the other, and merged", total,
        f"{' + '.join(f'{load:.1f}' for load in loads)} s; {told(pool.counts('shards'))}; equal to one run: {same}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", type=pathlib.Path)
    parser.add_argument("--volmap", type=pathlib.Path, default=pathlib.Path("target/release/volmap"))
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("batch-pool"))
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--shards", type=int, default=4)
    arguments = parser.parse_args()
    work = arguments.work.resolve()
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    shutil.copytree(arguments.meshes, work / arguments.meshes.name)
    (work / "pool.toml").write_text(manifest_of(arguments.meshes))
    pool = Pool(arguments.volmap.resolve(), work)
    print("| what | wall time | came out |\n| --- | --- | --- |")
    whole, _ = pool.run("whole")
    endings = collections.Counter(a["mesh"].rsplit(".", 1)[1].lower() for a in pool.summary("whole")["assets"])
    row(f"all {sum(endings.values())} meshes ({told(endings)})", whole, told(pool.counts("whole")))
    seconds, _ = pool.run("whole")
    row("again", seconds, told(pool.counts("whole")))
    changes(pool)
    kills(pool, whole, arguments.kills)
    writers(pool)
    shards(pool, arguments.shards)


if __name__ == "__main__":
    main()
