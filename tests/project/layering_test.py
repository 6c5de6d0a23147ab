"""A folder of src/palpate includes only folders to its left, and every header says what it is for."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ORDER = ["base", "geometry", "kinematics", "rosbridge", "scene", "collision", "haptics", "servo", "device", "gateway"]
INCLUDE = re.compile(r'#include [<"]palpate/(\w+)/')


def violations(root):
    """Lines that include a folder to the right of their own, or something of apps."""
    found = []
    for path in sorted((root / "src/palpate").rglob("*.[hc]*")):
        folder = path.relative_to(root / "src/palpate").parts[0]
        if folder not in ORDER:
            if path.suffix in (".h", ".cpp"):
                found.append(f"{path}: folder '{folder}' has no place in the order")
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if match and ORDER.index(match.group(1)) > ORDER.index(folder):
                found.append(f"{path}:{number}: {line}")
            if line.startswith("#include") and "apps/" in line:
                found.append(f"{path}:{number}: {line}")
    return found


class Layering(unittest.TestCase):
    def test_folders_include_to_the_left_only(self):
        self.assertEqual(violations(ROOT), [])

    def test_headers_open_with_their_purpose(self):
        for path in sorted((ROOT / "src/palpate").rglob("*.h")):
            with self.subTest(path=path):
                self.assertTrue(path.read_text().startswith("/// \\file\n/// "), "no \\file comment")


if __name__ == "__main__":
    sys.exit(unittest.main())
