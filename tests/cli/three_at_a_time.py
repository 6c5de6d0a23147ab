"""Runs the classes of a file of tests three at a time, where they wait for the program most of the time.

usage: three_at_a_time.py FILE
"""

import ast
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor


def tested_classes(path):
    """Names of the classes that have tests."""
    with open(path, encoding="utf-8") as file:
        module = ast.parse(file.read())
    return [node.name for node in module.body if isinstance(node, ast.ClassDef)
            and any(isinstance(one, ast.FunctionDef) and one.name.startswith("test") for one in node.body)]


def run(path, name):
    done = subprocess.run([sys.executable, "-B", path, name], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return f"{name}: {done.stdout}", done.returncode


if __name__ == "__main__":
    [PATH] = sys.argv[1:]
    with ThreadPoolExecutor(3) as pool:
        results = list(pool.map(lambda name: run(PATH, name), tested_classes(PATH)))
    print("\n".join(said for said, _ in results))
    sys.exit(any(code != 0 for _, code in results))
