#!/usr/bin/env python3
"""Import rings, long functions and long lists of parameters, crate by crate.

Modules of a crate are a tree. At every level of it, siblings with all that is in them must not import each other in a
ring; imports between a module and what is in it are no ring. Unit tests don't count. Exit code 1 if there is a ring, or a
function over 70 lines.
"""
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def without_text(source):
    """The source without comments and unit tests; strings and characters are empty, lines stay where they were."""
    tokens = r'//[^\n]*|/\*.*?\*/|r(#*)"(?:.*?)"\1|b?"(?:\\.|[^"\\])*"|b?\'(?:\\[^\n]*?|[^\\\'\n])\''
    blank = lambda m: ("" if m[0].startswith("/") else '""') + "\n" * m[0].count("\n")
    source = re.sub(tokens, blank, source, flags=re.S)
    return re.split(r"#\[cfg\(test\)\]\s*(?:pub\(\w+\) )?mod \w+\s*\{", source)[0]


def expand(tree):
    """All paths of a `use` tree, as (path, name)."""
    head, brace, rest = tree.partition("{")
    if not brace:
        path, _, name = tree.partition(" as ")
        parts = [part for part in path.strip().split("::") if part]
        return [(parts, (name or parts[-1]).strip())] if parts else []
    depth, items, item = 0, [], ""
    for letter in rest[: rest.rindex("}")]:
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            items, item = items + [item], ""
        else:
            item += letter
    return [pair for item in items + [item] for pair in expand(head.strip() + item.strip())]


def read(folder):
    """Of every module of a crate: its source."""
    modules = {}
    for path in sorted(folder.rglob("*.rs")):
        name = path.relative_to(folder).with_suffix("").parts
        if name[-1] != "tests" and name != ("main",):
            modules[() if name == ("lib",) else name] = without_text(path.read_text())
    return modules


def imports(modules):
    """Pairs of siblings (parent, from, to), one for each import from what is in one to what is in the other."""
    uses = {name: [pair for tree in re.findall(r"\buse ([^;]+);", source) for pair in expand(tree)]
            for name, source in modules.items()}

    def resolve(here, path, depth=0):
        at, path = list(here), list(path)
        if path[0] == "crate":
            at, path = [], path[1:]
        elif path[0] in ("self", "super"):
            while path and path[0] in ("self", "super"):
                at, path = (at[:-1] if path[0] == "super" else at), path[1:]
        elif tuple(at + path[:1]) not in modules:
            return None
        while path and tuple(at + path[:1]) in modules:
            at, path = at + path[:1], path[1:]
        named = [old for old, name in uses.get(tuple(at), []) if path and name == path[0] and tuple(at) != here]
        return resolve(tuple(at), named[0], depth + 1) or tuple(at) if named and depth < 5 else tuple(at)

    for here, source in modules.items():
        paths = [path for path, _ in uses[here]]
        paths += [match.split("::") for match in re.findall(r"\b(?:crate|super)(?:::\w+)+", source)]
        for target in (resolve(here, path) for path in paths):
            common = next((n for n, (a, b) in enumerate(zip(here, target or ())) if a != b), None)
            if common is not None:
                yield here[:common], here[common], target[common]


def rings(edges):
    """Groups of siblings that reach each other."""
    graph = {}
    for parent, source, target in edges:
        graph.setdefault((parent, source), set()).add((parent, target))

    def reach(start):
        seen, todo = set(), [start]
        while todo:
            for node in graph.get(todo.pop(), ()):
                if node not in seen:
                    seen.add(node)
                    todo.append(node)
        return seen

    groups = {frozenset(other for other in reach(node) if node in reach(other)) for node in graph}
    return sorted(sorted("::".join(parent + (name,)) for parent, name in group) for group in groups if group)


def functions(source):
    """(name, lines, parameters without self) of every function with a body."""
    for match in re.finditer(r"\bfn (\w+)[^({;]*?(?:<[^({;]*>)?\s*\(", source):
        depth, end, commas, last = 1, match.end(), 0, match.end()
        while depth:
            letter = source[end]
            depth += {"(": 1, "[": 1, "{": 1, "<": 1, ")": -1, "]": -1, "}": -1}.get(letter, 0)
            depth -= letter == ">" and source[end - 1] not in "-="
            if letter == "," and depth == 1:
                commas, last = commas + 1, end + 1
            end += 1
        count = commas + bool(source[last : end - 1].strip()) - bool(re.match(r"\s*&?\s*(mut )?self\b", source[match.end() :]))
        body = re.match(r"[^;{]*\{", source[end:])
        if body:
            depth, close = 1, end + body.end()
            while depth:
                depth += {"{": 1, "}": -1}.get(source[close], 0)
                close += 1
            yield match[1], source.count("\n", match.start(), close) + 1, count


def main():
    failed = False
    print(f"{'crate':20} rings   over 40 lines   over 70   more than 6 parameters")
    for member in tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["members"]:
        if not (ROOT / member / "src").is_dir():
            continue
        modules = read(ROOT / member / "src")
        found = rings(imports(modules))
        all_functions = [function for source in modules.values() for function in functions(source)]
        long = [name for name, lines, _ in all_functions if lines > 70]
        counts = [sum(lines > 40 for _, lines, _ in all_functions), len(long), sum(n > 6 for *_, n in all_functions)]
        print(f"{member:20} {len(found):5}   {counts[0]:13}   {counts[1]:7}   {counts[2]:22}")
        print("".join(f"    ring: {', '.join(ring)}\n" for ring in found) + "".join(f"    long: {name}\n" for name in long), end="")
        failed |= bool(found or long)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
