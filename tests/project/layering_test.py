"""Folders of src/palpate include only what the graph allows, files do not include one another in a
circle, and every header says what it is for."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Folder -> folders that it may include, besides itself. docs/architecture.md draws it.
EVERYONES = {"base", "geometry"}
GRAPH = {
    "base": set(),
    "geometry": {"base"},
    "kinematics": EVERYONES,
    "rosbridge": EVERYONES,
    "scene": EVERYONES,
    "collision": EVERYONES | {"scene"},
    "haptics": EVERYONES | {"scene", "collision"},
    "servo": EVERYONES | {"scene", "collision", "haptics"},
    "record": EVERYONES | {"scene", "collision", "haptics", "servo"},
    "device": EVERYONES | {"kinematics", "haptics", "servo", "record"},
    "study": EVERYONES | {"kinematics", "scene", "collision", "haptics", "servo", "record", "device"},
    "report": EVERYONES | {"scene", "collision", "haptics", "servo", "record", "device", "study"},
    "gateway": EVERYONES | {"collision", "haptics", "servo", "device", "rosbridge"},
    "live": EVERYONES | {"kinematics", "scene", "collision", "haptics", "servo", "record", "device", "study", "rosbridge", "gateway"},
}
INCLUDE = re.compile(r'#\s*include [<"](.*?)[>"]')


def sources(root):
    """Every source and header of src/palpate, as path relative to it -> the included paths with line numbers."""
    base = root / "src/palpate"
    return {
        path.relative_to(base).as_posix(): [
            (number, match.group(1))
            for number, line in enumerate(path.read_text().splitlines(), 1)
            if (match := INCLUDE.match(line))
        ]
        for path in sorted(base.rglob("*"))
        if path.suffix in (".h", ".cpp")
    }


def violations(files):
    """Includes that the graph does not allow."""
    found = []
    for path, includes in files.items():
        folder = path.split("/")[0]
        if folder not in GRAPH:
            found.append(f"{path}: folder '{folder}' is not in the graph")
            continue
        for number, included in includes:
            parts = included.split("/")
            if parts[0] == "palpate" and parts[1] != folder and parts[1] not in GRAPH[folder]:
                found.append(f"{path}:{number}: {included}")
            elif parts[0] in ("apps", "bench", "bridges", "tests"):
                found.append(f"{path}:{number}: {included}")
    return found


def cycle(edges):
    """A circle in a graph of node -> nodes, as the list of its nodes; empty if there is none."""
    done, way = set(), []

    def visit(node):
        if node in way:
            return way[way.index(node) :] + [node]
        if node in done:
            return []
        way.append(node)
        for other in edges.get(node, ()):
            if found := visit(other):
                return found
        done.add(way.pop())
        return []

    for node in edges:
        if found := visit(node):
            return found
    return []


def file_edges(files):
    """Which files of src/palpate each of them includes."""
    return {
        path: sorted(included.removeprefix("palpate/") for _, included in includes if included.startswith("palpate/"))
        for path, includes in files.items()
    }


class Layering(unittest.TestCase):
    def test_graph_has_no_cycle(self):
        self.assertEqual(cycle(GRAPH), [])

    def test_folders_include_what_the_graph_allows(self):
        self.assertEqual(violations(sources(ROOT)), [])

    def test_files_do_not_include_in_a_circle(self):
        self.assertEqual(cycle(file_edges(sources(ROOT))), [])

    def test_the_checks_see_what_they_look_for(self):
        wrong = {"scene/a.h": [(1, "palpate/servo/b.h")], "new/a.h": [], "base/c.cpp": [(2, "apps/palpate/x.h"), (3, "bridges/ros1/x.h")]}
        self.assertEqual(len(violations(wrong)), 4)
        circle = {"base/a.h": [(1, "palpate/base/b.h")], "base/b.h": [(1, "palpate/base/a.h")]}
        self.assertEqual(cycle(file_edges(circle)), ["base/a.h", "base/b.h", "base/a.h"])

    def test_headers_open_with_their_purpose(self):
        for path in sorted((ROOT / "src/palpate").rglob("*.h")):
            with self.subTest(path=path):
                self.assertTrue(path.read_text().startswith("/// \\file\n/// "), "no \\file comment")


if __name__ == "__main__":
    sys.exit(unittest.main())
