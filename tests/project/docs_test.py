"""Links between documents lead somewhere, and the code that they name is there."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
LINK = re.compile(r"\]\(([^)\s]+)\)")
# `folder/file.h` or `folder/file.h:symbol`, below src/palpate
CODE = re.compile(r"`((?:\w+/)+[\w.-]+\.(?:h|cpp))(?::(\w+))?`")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def anchors(page):
    """The names of a page's headings, as GitHub makes them."""
    found = set()
    for heading in re.findall(r"^#+ (.*)$", FENCE.sub("", page.read_text()), re.MULTILINE):
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        found.add(re.sub(r"[^\w\- ]", "", text).replace(" ", "-"))
    return found


class Documents(unittest.TestCase):
    def test_links_lead_somewhere(self):
        for page in PAGES:
            for target in LINK.findall(FENCE.sub("", page.read_text())):
                if re.match(r"[a-z]+:", target):
                    continue
                path, _, anchor = target.partition("#")
                with self.subTest(page=page.name, target=target):
                    there = (page.parent / path).resolve() if path else page
                    self.assertTrue(there.exists(), "no such file")
                    if anchor and there.suffix == ".md":
                        self.assertIn(anchor, anchors(there))

    def test_code_of_the_glossary_is_there(self):
        named = CODE.findall((ROOT / "docs/glossary.md").read_text())
        self.assertGreater(len(named), 30)
        for path, symbol in named:
            with self.subTest(path=path, symbol=symbol):
                source = ROOT / "src/palpate" / path
                self.assertTrue(source.exists(), "no such file")
                self.assertRegex(source.read_text(), rf"\b{symbol}\b")

    def test_every_page_is_reached_from_the_index(self):
        index = (ROOT / "docs/index.md").read_text()
        for page in sorted((ROOT / "docs").glob("*.md")):
            if page.name != "index.md":
                with self.subTest(page=page.name):
                    self.assertIn(f"({page.name})", index)


if __name__ == "__main__":
    sys.exit(unittest.main())
