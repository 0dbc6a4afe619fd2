#!/usr/bin/env python3
"""Import rings, long functions and long lists of parameters, crate by crate.

Modules of a crate are a tree. At every level of it, siblings with all that is in them must not import each other in a
ring. Imports between a module and what is in it are no ring, and unit tests don't count.
Exit code 1 if there is a ring, or a function over 70 lines.
"""
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TEXT = r'//[^\n]*|/\*.*?\*/|r(#*)"(?:.*?)"\1|b?"(?:\\.|[^"\\])*"|b?\'(?:\\[^\n]*?|[^\\\'\n])\''
TESTS = r"#\[cfg\(test\)\]\s*(?:pub\(\w+\) )?mod \w+\s*\{"


def code_of(source):
    """The source without comments and unit tests; texts are empty, and lines stay where they were."""
    blank = lambda match: ("" if match[0].startswith("/") else '""') + "\n" * match[0].count("\n")
    return re.split(TESTS, re.sub(TEXT, blank, source, flags=re.S))[0]


def modules_of(folder):
    """Of every module of a crate its name, as a tuple, and its code."""
    names = {path.relative_to(folder).with_suffix("").parts: path for path in folder.rglob("*.rs")}
    kept = {name: path for name, path in names.items() if name[-1] != "tests" and name != ("main",)}
    modules = {name: code_of(path.read_text()) for name, path in kept.items()}
    modules[()] = modules.pop(("lib",), "")
    return modules


def expand(tree):
    """All (path, name) of a `use` tree."""
    head, brace, rest = tree.partition("{")
    if not brace:
        path, _, name = tree.partition(" as ")
        parts = [part for part in path.strip().split("::") if part]
        return [(parts, (name or parts[-1]).strip())] if parts else []
    depth, items = 0, [""]
    for letter in rest[: rest.rindex("}")]:
        depth += {"{": 1, "}": -1}.get(letter, 0)
        items = items + [""] if letter == "," and depth == 0 else items[:-1] + [items[-1] + letter]
    return [pair for item in items for pair in expand(head.strip() + item.strip())]


def edges_of(modules):
    """Imports between siblings, as (parent, from, to): from what is in one to what is in the other."""
    uses = {name: [pair for tree in re.findall(r"\buse ([^;]+);", code) for pair in expand(tree)]
            for name, code in modules.items()}

    def module(here, path, depth=0):
        """The module where what a path names is defined; none if that is another crate's."""
        at, path = list(here), list(path)
        if path[0] not in ("crate", "self", "super") and tuple(at + path[:1]) not in modules:
            return None
        while path and path[0] in ("crate", "self", "super"):
            at, path = {"crate": [], "self": at, "super": at[:-1]}[path[0]], path[1:]
        while path and tuple(at + path[:1]) in modules:
            at, path = at + path[:1], path[1:]
        again = [old for old, name in uses[tuple(at)] if path and name == path[0] and tuple(at) != here]
        return again and depth < 5 and module(tuple(at), again[0], depth + 1) or tuple(at)

    for here, code in modules.items():
        paths = [path for path, _ in uses[here]]
        paths += [path.split("::") for path in re.findall(r"\b(?:crate|super)(?:::\w+)+", code)]
        for there in (module(here, path) for path in paths):
            level = next((n for n, (a, b) in enumerate(zip(here, there or ())) if a != b), None)
            if level is not None:
                yield here[:level], here[level], there[level]


def rings_of(edges):
    """Groups of siblings that reach each other."""
    graph = {}
    for parent, source, target in edges:
        graph.setdefault(parent + (source,), set()).add(parent + (target,))

    def reach(start):
        seen, todo = set(), [start]
        while todo:
            new = graph.get(todo.pop(), set()) - seen
            seen, todo = seen | new, todo + list(new)
        return seen

    groups = {frozenset(other for other in reach(node) if node in reach(other)) for node in graph}
    return sorted(", ".join(sorted("::".join(name) for name in group)) for group in groups if group)


def functions_of(code):
    """(name, lines, parameters without self) of every function with a body."""
    def end_of(begin, brackets):
        depth, at, commas = 1, begin, [begin]
        while depth:
            arrow = code[at] == ">" and code[at - 1] in "-="
            depth += 0 if arrow else brackets.get(code[at], 0)
            commas, at = commas + [at + 1] * (code[at] == "," and depth == 1), at + 1
        return at, [code[a:b].strip(" \n,)") for a, b in zip(commas, commas[1:] + [at])]

    for match in re.finditer(r"\bfn (\w+)[^({;]*?(?:<[^({;]*>)?\s*\(", code):
        end, parameters = end_of(match.end(), {"(": 1, "[": 1, "{": 1, "<": 1, ")": -1, "]": -1, "}": -1, ">": -1})
        count = sum(1 for text in parameters if text and not re.match(r"&?\s*('\w+ )?(mut )?self\b", text))
        if body := re.match(r"[^;{]*\{", code[end:]):
            close, _ = end_of(end + body.end(), {"{": 1, "}": -1})
            yield match[1], code.count("\n", match.start(), close) + 1, count


failed = False
print(f"{'crate':20} rings   over 40 lines   over 70   more than 6 parameters")
for member in tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["members"]:
    if not (ROOT / member / "src").is_dir():
        continue
    modules = modules_of(ROOT / member / "src")
    rings = rings_of(edges_of(modules))
    functions = [function for code in modules.values() for function in functions_of(code)]
    long = [f"{name}, {lines} lines" for name, lines, _ in functions if lines > 70]
    over, many = sum(lines > 40 for _, lines, _ in functions), sum(count > 6 for *_, count in functions)
    print(f"{member:20} {len(rings):5}   {over:13}   {len(long):7}   {many:22}")
    for kind, names in (("ring", rings), ("long", long)):
        print("".join(f"    {kind}: {name}\n" for name in names), end="")
    failed |= bool(rings or long)
sys.exit(int(failed))
