"""Broken inputs, one row each: what is run, and words that the refusal must contain.

A row is a Row(name, arguments, words, code, files): `files` maps names to the bytes to write before
`palpate *arguments` runs in that folder. Code 1 is an error, 2 is bad usage. Every row also finds a
sound scene `a.ply`, trajectory `path.csv` and run `run.csv`.
"""

import struct
from dataclasses import dataclass, field

from support import INRIA, LIVE_HEADER, RUN_HEADER, path_csv, ply, ply_header, splat


@dataclass
class Row:
    name: str
    args: list
    words: list
    code: int = 1
    files: dict = field(default_factory=dict)


ROWS = []


def row(name, args, words, code=1, files=None):
    ROWS.append(Row(name, args, [words] if isinstance(words, str) else words, code, files or {}))


def scene(name, content, words, file="bad.ply"):
    """A broken scene file, which the refusal must name."""
    row("scene: " + name, ["info", file], [file, *([words] if isinstance(words, str) else words)], 1, {file: content})


def table(name, content, words, command="replay"):
    """A broken trajectory, or a broken run for `report`."""
    args = (["replay", "a.ply", "--trajectory", "bad.csv", "--out", "out.csv"] if command == "replay"
            else ["report", "bad.csv", "--out", "out.html"])
    row(f"{command}: {name}", args, ["bad.csv", *([words] if isinstance(words, str) else words)], 1, {"bad.csv": content})


def config(name, content, words):
    row("config: " + name, ["query", "a.ply", "--pose", "0,0,0", "--config", "bad.toml"],
        ["bad.toml", *([words] if isinstance(words, str) else words)], 1, {"bad.toml": content})


def materials(name, content, words):
    row("materials: " + name, ["query", "a.ply", "--pose", "0,0,0", "--materials", "bad.toml"],
        ["bad.toml", *([words] if isinstance(words, str) else words)], 1, {"bad.toml": content})


def tool(name, content, words):
    row("tool: " + name, ["query", "a.ply", "--pose", "0,0,0", "--tool", "bad.toml"],
        ["bad.toml", *([words] if isinstance(words, str) else words)], 1, {"bad.toml": content})


def option(args, words=None, command=("query", "a.ply", "--pose", "0,0,0")):
    row("option: " + " ".join(args)[:60], [*command, *args], words or args[0], 2)


# --- scenes -------------------------------------------------------------------------------------

GOOD = ply([splat(k) for k in range(3)])
HEADER = ply_header(3)
BARE = "x y z opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()


def edited(*changes, data=GOOD):
    for old, new in changes:
        old, new = (s.encode() if isinstance(s, str) else s for s in (old, new))
        assert old in data, old
        data = data.replace(old, new, 1)
    return data


row("scene: missing", ["info", "nowhere.ply"], ["nowhere.ply", "No such file"])
row("scene: empty name", ["info", ""], "", 1)
row("scene: a folder", ["info", "."], ["is a folder"])
row("scene: below a file", ["info", "a.ply/b.ply"], ["a.ply/b.ply", "Not a directory"])
row("scene: too long a name", ["info", "n" * 300], "File name too long")
row("scene: a device", ["info", "/dev/zero"], ["/dev/zero", "regular file"])
scene("empty", b"", "is empty")
scene("empty .splat", b"", "is empty", "bad.splat")
scene("one byte", b"p", "not a .ply")
scene("binary garbage", bytes(range(256)) * 100, "not a .ply")
scene("text", b"Dear reader,\nthis is no scene.\n", "neither", "letter.txt")
scene("gzip (SPZ 3)", b"\x1f\x8b\x08\0\0\0\0\0" + bytes(64), "gzip", "bad.spz")
scene("SPZ 4", b"NGSP" + bytes(64), "SPZ", "bad.spz")
scene("zip (SOG)", b"PK\x03\x04" + bytes(64), "zip", "bad.sog")
scene("glTF", b"glTF\2\0\0\0" + bytes(64), "glTF", "bad.glb")
scene("JSON", b'{"asset": {"version": "2.0"}}', "JSON", "bad.json")
scene("gzip called .ply", b"\x1f\x8b\x08\0\0\0\0\0" + bytes(64), "gzip")
scene("compressed .ply", b"ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\n"
      b"property uint packed_position\nproperty uint packed_rotation\nend_header\n" + bytes(12), "compressed")
scene("point cloud", ply([[1, 2, 3]], ["x", "y", "z"]), ["'opacity'", "not a Gaussian splatting scene"])
scene("mesh", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      b"element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "'opacity'")
for size in (1, 31, 33, 32 * 1000 + 16):
    scene(f".splat of {size} bytes", bytes(size), [f"byte {size}", "32 bytes per Gaussian"], "bad.splat")

for length in (4, 5, 20, len(HEADER) // 2, len(HEADER) - 5, len(HEADER) - 1):
    scene(f"header cut at {length}", GOOD[:length], "end_header")
for length in (len(HEADER), len(HEADER) + 1, len(HEADER) + 68, len(GOOD) - 68, len(GOOD) - 1):
    scene(f"data cut at {length}", GOOD[:length], [f"byte {length}", "of 3"])

for count in ("1000000000000000000", "4294967297", "18446744073709551615", "4294967295", "4"):
    scene(f"count {count}", edited(("vertex 3", "vertex " + count)), count)
    scene(f"ASCII count {count}", edited(("vertex 3", "vertex " + count), data=ply([splat()] * 3, encoding="ascii")),
          "bad.ply")
for count in ("-1", "18446744073709551616", "1e3", "3.5", "three", "0x3", "3,"):
    scene(f"count {count}", edited(("vertex 3", "vertex " + count)), ["line 3", f"'{count}'"])
scene("count 0", edited(("vertex 3", "vertex 0")), "no Gaussians")

scene("two formats", edited(("element", "format ascii 1.0\nelement")), ["line 3", "second format"])
scene("no format", edited(("format binary_little_endian 1.0\n", "")), "format")
scene("format 2.0", edited((" 1.0", " 2.0")), ["line 2", "1.0"])
scene("unknown format", edited(("binary_little", "binary_middle")), ["line 2", "binary_middle_endian"])
scene("two vertex elements", edited(("end_header", "element vertex 3\nproperty float x\nend_header")), "second element 'vertex'")
scene("no vertex element", edited(("element vertex", "element vortex")), "'vertex'")
scene("two x", edited(("float y", "float x")), ["line 5", "'x'"])
scene("property before element", edited(("element", "property float w\nelement")), ["line 3", "before the first element"])
scene("list among the properties", edited(("property float nx", "property list uchar float nx")), "list")
scene("list for a number", edited(("property float x", "property list uchar float x")), ["'x'", "list"])
scene("unknown type", edited(("float x", "quad x")), ["line 4", "'quad'"])
scene("element without count", edited(("vertex 3", "vertex")), "line 3")
scene("property without name", edited(("property float x\n", "property float\n")), "line 4")
scene("unknown keyword", edited(("element", "elephant 1\nelement")), ["line 3", "'elephant'"])
for missing in ("x", "y", "z", "opacity", "scale_0", "scale_1", "rot_0", "rot_3"):
    names = [name for name in INRIA if name != missing]
    scene("no " + missing, ply([[0.5] * 16], names), [f"'{missing}'", "missing"])
for names in (["f_dc_0"], ["f_dc_0", "f_dc_1"], ["f_dc_2"]):
    scene("f_dc partial: " + " ".join(names), ply([[0.5] * (11 + len(names))], BARE + names), "f_dc_")
for count in (1, 10, 44, 46):
    scene(f"{count} f_rest_", ply([[0.5] * (11 + count)], BARE + [f"f_rest_{k}" for k in range(count)]), [str(count), "f_rest_"])
scene("f_rest_ with a gap", ply([[0.5] * 20], BARE + [f"f_rest_{k}" for k in (0, 1, 2, 3, 4, 5, 6, 7, 9)]), "'f_rest_8'")
scene("header of 2 MiB without end", b"ply\nformat ascii 1.0\n" + b"comment " + b"c" * (2 << 20) + b"\nend_header\n", "end_header")
scene("2 MiB of comments", b"ply\nformat ascii 1.0\n" + b"comment c\n" * 210_000 + b"end_header\n", "end_header")
scene("Macintosh line ends", GOOD.replace(b"\n", b"\r"), "end_header")
scene("60,000 elements", b"ply\nformat ascii 1.0\n" + b"".join(b"element e%d 0\n" % k for k in range(60_000)) + b"end_header\n",
      ["line 103", "more than 100 elements"])
scene("45,000 properties", b"ply\nformat ascii 1.0\nelement vertex 1\n" +
      b"".join(b"property char p%d\n" % k for k in range(45_000)) + b"end_header\n", ["line 1004", "more than 1000 properties"])
scene("a word of 1 MB", b"ply\n" + b"w" * 1_000_000 + b"\nend_header\n", "line 2")
scene("a type of 100 kB", edited(("float x", "q" * 100_000 + " x")), "line 4")
scene("a name of 100 kB twice", edited(("float x", "float " + "q" * 100_000), ("float y", "float " + "q" * 100_000)), "line 5")
scene("escape sequences in the header", edited(("element", b"\x1b]0;owned\x07\x1b[31m\nelement")), "line 3")
scene("C1 control characters in the header", edited(("element", "\u009b31m\nelement")), "line 3")
scene("bytes that are no UTF-8 in the header", edited(("element", b"\xff\x9b\xfe\nelement")), "line 3")
scene("NUL in the header", edited(("float x", b"float\0 x")), "line 4")
scene("an element that is cut", edited(("end_header", "element face 5\nproperty double d\nend_header")), ["'face'", "truncated"])
scene("an element before that is a lie", edited(("element vertex", "element face 1000000000000\nproperty double d\nelement vertex")),
      "'face'")
scene("a list that claims 2e9 items", edited(("element vertex", "element face 1\nproperty list uint double l\nelement vertex"),
      ("end_header\n", b"end_header\n" + struct.pack("<I", 2_000_000_000))), "'l'")
scene("a list that claims -1 items", edited(("element vertex", "element face 1\nproperty list int double l\nelement vertex"),
      ("end_header\n", b"end_header\n" + struct.pack("<i", -1))), "'l'")

ASCII = ply_header(2, BARE, "ascii")
LINE = b"1 2 3 4 5 6 7 8 9 10 11\n"
scene("ASCII row too short", ASCII + LINE + b"1 2 3 4 5 6 7 8 9 10     \n", [f"byte {len(ASCII + LINE)}", "Gaussian 1", "'rot_3'"])
scene("ASCII row too long", ASCII + LINE + b"1 2 3 4 5 6 7 8 9 10 11 12\n", [f"byte {len(ASCII + LINE)}", "more than 11"])
scene("ASCII word", ASCII + LINE + b"1 2 3 4 five 6 7 8 9 10 11\n", "'scale_0'")
scene("ASCII comma", ASCII + LINE + LINE.replace(b" ", b","), "'x'")
scene("ASCII two signs", ASCII + LINE + b"+-1 2 3 4 5 6 7 8 9 10 11\n", "'x'")
scene("ASCII one row of two", ASCII + LINE + b" " * 64, "truncated")
scene("ASCII huge line", ASCII + b"1 " * (20 << 19) + b"\n", "line")
scene("ASCII line without end", ASCII + b"1" * (20 << 20), "line")
scene("ASCII binary garbage", ASCII + bytes(range(256)) * 4, "bad.ply")
scene("binary data called ASCII", edited(("binary_little_endian", "ascii")), "bad.ply")

for hostile in ("bad\x1b[31m.ply", "bad\nname.ply", "bad\u009b31m.ply", "bad\x7f\x07.ply", b"bad\xff\xfe.ply", "bad\u202e.ply"):
    text = hostile.decode("utf-8", "replace") if isinstance(hostile, bytes) else hostile
    row(f"name {text!r}: missing", ["info", hostile], "No such file")
    row(f"name {text!r}: broken", ["info", hostile], "end_header", 1, {hostile: b"ply\n"})

# --- tables -------------------------------------------------------------------------------------

GOOD_RUN = RUN_HEADER.encode() + b"\n" + b",".join([b"0"] * 4 + [b"1"] + [b"0"] * 17) + b"\n"


def tables(command, good, width):
    table("empty", b"", "empty", command)
    table("header only", good.split(b"\n")[0] + b"\n", "row", command)
    table("no header", good.split(b"\n", 1)[1] * 2, ["line 1", "no column names"], command)
    table("two columns of a name", good.replace(b"x,y", b"x,x", 1), ["line 1", "'x'"], command)
    table("a column without a name", good.replace(b"x,y", b"x,", 1), "line 1", command)
    table("a missing column", good.replace(b"x,y", b"x,yy", 1), "'y'", command)
    table("a word", good + b"1,zero" + b",0" * (width - 2) + b"\n", ["line 3", "'x'", "zero"], command)
    table("NaN", good + b"1,nan" + b",0" * (width - 2) + b"\n", ["line 3", "'x'"], command)
    table("infinity", good + b"1,-inf" + b",0" * (width - 2) + b"\n", ["line 3", "'x'"], command)
    table("1e400", good + b"1,1e400" + b",0" * (width - 2) + b"\n", ["line 3", "'x'"], command)
    table("an empty cell", good + b"1," + b",0" * (width - 2) + b"\n", ["line 3", "'x'"], command)
    table("a cut line", good + b"1,0,0\n", ["line 3", "truncated"], command)
    table("a line too long", good + b"1" + b",0" * width + b"\n", ["line 3"], command)
    table("time that stands still", good + good.split(b"\n")[1] + b"\n", "order of time", command)
    table("binary", bytes(range(1, 256)) * 64, "line ", command)
    table("NULs", bytes(4096), "line 1", command)
    table("a cell of 1 MB", good + b"1," + b"9" * 1_000_000 + b"x" + b",0" * (width - 2) + b"\n", "line 3", command)
    table("a header of 1 MB", b"c" * 1_000_000 + b"\n", "line 1", command)
    table("100,000 columns", b",".join(b"c%d" % k for k in range(100_000)) + b"\n", "line 1", command)
    table("the same name for 1 MB", (b"c" * 500_000 + b",") * 2 + b"\n", "line 1", command)
    table("escape sequences", b"\x1b[31mt,x\n" + good, ["line 1", "binary"], command)
    table("C1 in a cell", good + "1,\u009b31m".encode() + b",0" * (width - 2) + b"\n", "line 3", command)
    table("a .ply", GOOD, "is a .ply file", command)
    table("semicolons", good.replace(b",", b";"), ["line 1", "semicolons", "by commas"], command)
    table("tabs", good.replace(b",", b"\t"), ["line 1", "tabs", "by commas"], command)


GOOD_PATH = path_csv([(0, 0, 0, 1, 1, 0, 0, 0)], "t,x,y,z,qw,qx,qy,qz").encode()
tables("replay", GOOD_PATH, 8)
tables("report", GOOD_RUN, 22)
row("replay: missing", ["replay", "a.ply", "--trajectory", "no.csv", "--out", "out.csv"], ["no.csv", "No such file"])
row("report: missing", ["report", "no.csv", "--out", "out.html"], ["no.csv", "No such file"])
row("replay: a folder", ["replay", "a.ply", "--trajectory", ".", "--out", "out.csv"], "folder")
table("a cut last line", GOOD_PATH + b"1,0,0", ["line 3", "truncated"])
table("nothing but a cut line", GOOD_RUN.split(b"\n")[0] + b"\n0,0,0", "no rows", "report")
table("a last line that is worse than cut", GOOD_RUN + b"1,0,zero", ["line 3", "'y'"], "report")
table("a last line too long", GOOD_RUN + b"1" + b",0" * 22, ["line 3", "more than 22"], "report")
table("half a user force", GOOD_RUN.replace(b"compute_us", b"compute_us,ufy").replace(b"0\n", b"0,0\n"), "'ufx'", "report")
table("half of a live run", GOOD_RUN.replace(b"compute_us", b"compute_us,state").replace(b"0\n", b"0,0\n"), "'vx'", "report")
LIVE_RUN = GOOD_RUN.replace(b"compute_us", b"compute_us" + LIVE_HEADER.encode()).replace(b"0\n", b"0" + b",0" * 19 + b"\n")
table("a state that is none", LIVE_RUN.replace(b",0,0,0,0,0,0,0\n", b",5,0,0,0,0,0,0\n"), ["line 2", "'state'", "5"], "report")
table("a fault that is none", LIVE_RUN.replace(b",0,0,0,0,0,0\n", b",1.5,0,0,0,0,0\n"), ["line 2", "'fault'", "1.5"], "report")
table("a live run of a line that is not ended", LIVE_RUN[:-1], "no rows", "report")
for args, words in ((["--from", "1"], ["from 1 s on", "last is at 0 s"]), (["--to", "-1"], ["up to -1 s", "first is at 0 s"])):
    row("report: no rows " + args[0], ["report", "run.csv", "--out", "out.html", *args], ["run.csv", *words])
for args in (["--from", "x"], ["--to", "nan"], ["--from", "2", "--to", "1"]):
    option(args, args[-2], ("report", "run.csv", "--out", "out.html"))
table("zero quaternion", GOOD_PATH + b"1,0,0,0,0,0,0,0\n", ["line 3", "quaternion"])
table("a table of evaluate", b"shape,spacing_m,model,x\nbox,0.01,proxy,1\n", ["no trajectory", "'t', 'y', 'z' are missing"])
row("replay: scene and trajectory swapped", ["replay", "path.csv", "--trajectory", "a.ply", "--out", "out.csv"],
    ["a.ply", "is a .ply file"])
table("half a quaternion", b"t,x,y,z,qw,qx\n0,0,0,0,1,0\n", "'qy'")
table("half a user force", b"t,x,y,z,ufx\n0,0,0,0,1\n", "'ufy'")
table("counts that are none", GOOD_RUN.replace(b"0,0,0,1,0,0,0,0", b"0,0,0,1,0,0,0,1.5"), "count", "report")
table("negative counts", GOOD_RUN.replace(b"0,0,0,1,0,0,0,0", b"0,0,0,1,0,0,0,-1"), "count", "report")
row("report: a broken scene", ["report", "run.csv", "--scene", "bad.ply", "--out", "out.html"], "bad.ply", 1, {"bad.ply": GOOD[:-1]})

# --- options ------------------------------------------------------------------------------------

for value in ("0", "-1", "nan", "inf", "1e400", "", "x", "1x", "1,2", "0x1", "9" * 400, "1e-400"):
    option(["--sigma", value])
for value in ("1.1", "-0.1", "nan"):
    option(["--opacity-min", value])
for value in ("0", "1", "-1", "2", "nan"):
    option(["--iso", value])
option(["--iso", "0.2", "--sigma", "1"], ["--iso", "--sigma"])
for value in ("0.02,0.02", "0.02,0.02,0", "0.02,-0.02,0.02", "1,2,3,4", "nan,1,1", "1,,1", ",,", "1e300,1,1", "1;1;1"):
    option(["--tool", value])
for value in ("0", "-1", "nan", "inf"):
    option(["--scale", value])
for value in ("0,0,0,0", "1,0,0", "1,0,0,0,0", "nan,0,0,0", "1e-300,0,0,0"):
    option(["--rotate", value])
for value in ("1,2", "1,2,3,4", "inf,0,0"):
    option(["--translate", value])
for value in ("1,2", "1,2,3,4", "1,2,3,0,0,0,0", "1,2,3,1,0,0", "1,2,3,nan,0,0,0", "a,b,c", ""):
    row("option: --pose " + value, ["query", "a.ply", "--pose", value], "--pose", 2)
for value in ("1,1,1,0,0,0", "0,0,0,1,1"):
    option(["--crop-box", value])
for value in ("0,0,0,0", "0,0,0,-1", "0,0,1"):
    option(["--crop-sphere", value])
for name, value in (("--max-scale", "0"), ("--frame", "up"), ("--model", "magic"), ("--pipeline", "fast"),
                    ("--search-radius", "-1"), ("--iterations", "0"), ("--iterations", "1e9"), ("--k-base", "-1"),
                    ("--f-max", "nan"), ("--tau-direction", "-1"), ("--damping", "x")):
    option([name, value])
for value in ("0", "-1", "x", "1.5", "99999999999999999999"):
    option(["--threads", value], command=("replay", "a.ply", "--trajectory", "path.csv", "--out", "out.csv"))
option(["--sigma", "1", "--sigma", "2"])
option(["--frobnicate"])
option(["-x"])
option(["--sigm", "1"])
option(["surplus"], "surplus")
option(["--\x1b[31mred"], "red")
option(["--pose=\x1b]0;owned\x07"], "--pose")
option(["--sigma", "\u009b31m"], "--sigma")
option(["two\nlines"], "two")
option(["--tool", "9" * 100_000 + "x"], "--tool")
option(["s" * 100_000], "s")
row("option: unknown command", ["frobnicate"], "frobnicate", 2)
row("option: unknown command with escapes", ["\x1b[31mred"], "red", 2)
row("option: no scene", ["info"], "SCENE", 2)
row("option: no pose", ["query", "a.ply"], "--pose", 2)
row("option: no trajectory", ["replay", "a.ply", "--out", "out.csv"], "--trajectory", 2)
row("option: no out", ["replay", "a.ply", "--trajectory", "path.csv"], "--out", 2)
row("option: report without out", ["report", "run.csv"], "--out", 2)
row("option: unknown shape", ["make-scene", "cube", "--out", "out.ply"], "cube", 2)
row("option: unknown shell", ["completion", "cmd"], "cmd", 2)
row("option: too fine a still life", ["make-scene", "still-life", "--spacing", "1e-4", "--out", "out.ply"], "0.001 m to 0.02 m")
row("option: a noisy still life", ["make-scene", "still-life", "--noise", "0.001", "--out", "out.ply"], "neither --noise")
row("option: too fine a spacing", ["make-scene", "plane", "--spacing", "1e-9", "--out", "out.ply"], "Gaussians")
row("option: absurdly fine a spacing", ["make-scene", "plane", "--spacing", "1e-300", "--out", "out.ply"], "Gaussians")

# --- configuration ------------------------------------------------------------------------------

config("not TOML", b"sigma == 1", "line 1")
config("binary", bytes(range(256)), "line ")
config("an unknown key", b"sigma = 1\nsigmma = 2", ["line 2", "sigmma"])
config("a bad value", b"\nsigma = -1", ["line 2", "sigma"])
config("a table", b"[query]\nsigma = 1", ["line 1", "query"])
config("a key twice", b"sigma = 1\nsigma = 2", "line 2")
config("sigma and iso", b"sigma = 1\niso = 0.2", ["iso", "sigma"])
config("10,000 nested arrays", b"x = " + b"[" * 10_000, "line 1")
config("10,000 nested arrays, closed", b"x = " + b"[" * 10_000 + b"]" * 10_000, "line 1")
config("10,000 nested tables", b"x = " + b"{a=" * 10_000, "line 1")
config("900 kB", b"k" * 900_000 + b" = 1", "65536")
config("30,000 dotted keys", b"a." * 30_000 + b"a = 1", "line 1")
config("a table of 30,000 dots", b"[" + b"a." * 30_000 + b"a]", "line 1")
config("10,000 inline tables", b"a = " + b"{a = " * 10_000, "line 1")
config("a value of 60 kB", b'sigma = "' + b"9" * 60_000 + b'x"', ["line 1", "sigma"])
config("a key of 60 kB", b"k" * 60_000 + b" = 1", "line 1")
config("escape sequences in a key", b'"\\u001b[31mred\\u009b" = 1', ["line 1", "red"])
config("escape sequences in a value", b'model = "\\u001b[31mred\\u009b"', ["line 1", "red"])
config("a file of 2 MiB", b"#" * (2 << 20), "bytes")
config("bytes that are no UTF-8", b"sigma = 1 # \xff\xfe\n", "line 1")

# --- materials ----------------------------------------------------------------------------------

REGION = b"[[region]]\nfriction = 0.5\n"
row("materials: missing", ["query", "a.ply", "--pose", "0,0,0", "--materials", "no.toml"], ["no.toml", "No such file"])
row("materials: a folder", ["query", "a.ply", "--pose", "0,0,0", "--materials", "."], "folder")
materials("empty", b"", "[[region]]")
materials("not TOML", b"[[region]]\nfriction = ", "line 2")
materials("binary", bytes(range(256)), "line ")
materials("a configuration", b"sigma = 1", ["line 1", "'sigma'"])
materials("a misspelt property", b"[[region]]\nfrictoin = 1", ["line 2", "'frictoin'", "friction"])
materials("negative stiffness", b"[[region]]\nstiffness = -1", ["line 2", "'stiffness'", "-1"])
materials("too much friction", b"[[region]]\nfriction = 1e3", ["line 2", "'friction'", "10"])
materials("damping that is no number", b"[[region]]\ndamping = nan", ["line 2", "'damping'", "nan"])
materials("no property", b'\n[[region]]\nname = "mat"', ["line 2", "stiffness, friction or damping"])
materials("two shapes", REGION + b"ids = [1]\nsphere = {center = [0, 0, 0], radius = 1}", ["line 1", "one of box, sphere and ids"])
materials("a box inside out", REGION + b"box = {min = [0, 0, 1], max = [1, 1, 0]}", ["line 3", "'min'"])
materials("a box of one corner", REGION + b"box = {min = [0, 0, 1]}", ["line 3", "'max'"])
materials("a sphere without a radius", REGION + b"sphere = {center = [0, 0, 0]}", ["line 3", "'radius'"])
materials("a point of two numbers", REGION + b"sphere = {center = [0, 0], radius = 1}", ["line 3", "'center'", "3"])
materials("a negative id", REGION + b"ids = [1, -1]", ["line 3", "'ids'", "-1"])
materials("an id of 33 bits", REGION + b"ids = [4294967296]", ["line 3", "'ids'"])
materials("a range inside out", REGION + b"ids = [[2, 1]]", ["line 3", "[2, 1]"])
materials("300 regions", REGION * 300, "300 regions")
materials("5 MiB", b"#" * (5 << 20), "bytes")
materials("2,000,000 ids and a word", REGION + b"ids = [" + b"1," * 2_000_000 + b"one]", "line 3")
materials("2,000,000 ids, the last negative", REGION + b"ids = [" + b"1," * 2_000_000 + b"-1]", ["line 3", "'ids'"])
materials("1,000,000 brackets", REGION + b"ids = [" + b"[" * 1_000_000, "line 3")
materials("escape sequences in a key", REGION + b'"\\u001b[31mred\\u009b" = 1', ["line 3", "red"])

HARD = INRIA + ["stiffness", "friction"]
for name, value in (("negative", -1.0), ("infinite", float("inf")), ("too large", 11.0)):
    row(f"materials: {name} friction in a .ply", ["query", "bad.ply", "--pose", "0,0,0", "--no-index-file"],
        ["bad.ply", "Gaussian 1", "'friction'"], 1, {"bad.ply": ply([splat() + [500, 0.5], splat() + [500, value]], HARD)})

# --- tools --------------------------------------------------------------------------------------

NAMED = b'[[ellipsoid]]\nname = "tip"\n'
BALL = NAMED + b"semi_axes = [0.01, 0.01, 0.01]\n"
row("tool: missing", ["query", "a.ply", "--pose", "0,0,0", "--tool", "no.toml"], ["no.toml", "No such file"])
row("tool: a folder", ["query", "a.ply", "--pose", "0,0,0", "--tool", "d.toml/"], "--tool", 2)
row("tool: of another extension", ["query", "a.ply", "--pose", "0,0,0", "--tool", "tool.json"], "--tool", 2)
tool("empty", b"", "'ellipsoid'")
tool("not TOML", BALL + b"position = ", "line 4")
tool("binary", bytes(range(256)), "line ")
tool("a configuration", b"sigma = 1", ["line 1", "'ellipsoid'"])
tool("materials", REGION, "'ellipsoid'")
tool("no ellipsoid", b"ellipsoid = []", "0 ellipsoids")
tool("one table", b'[ellipsoid]\nname = "tip"\nsemi_axes = [1, 1, 1]', ["line 1", "[[ellipsoid]]"])
tool("no name", b"[[ellipsoid]]\nsemi_axes = [1, 1, 1]", ["line 1", "'name'"])
tool("no semi-axes", NAMED, ["line 1", "'semi_axes'"])
for value in ("[0.01, 0.01, 0]", "[0.01, -0.01, 0.01]", "[0.01, nan, 0.01]", "[1e300, 1, 1]", "[0.01, 0.01]", "[]", "0.01", '"small"'):
    tool("semi-axes " + value, NAMED + b"semi_axes = " + value.encode(), ["line 3", "'semi_axes'"])
tool("a position of two numbers", BALL + b"position = [0, 0]", ["line 4", "'position'", "3"])
tool("a position out of this world", BALL + b"position = [0, 0, 1e9]", ["line 4", "'position'"])
tool("a quaternion of zeros", BALL + b"orientation = [0, 0, 0, 0]", ["line 4", "'orientation'", "qw, qx, qy, qz"])
tool("a quaternion of three numbers", BALL + b"orientation = [1, 0, 0]", ["line 4", "'orientation'", "4"])
tool("an unknown key", BALL + b"radius = 0.01", ["line 4", "'radius'", "semi_axes"])
tool("an unknown table", BALL + b"[handle]\nx = 1", ["line 4", "'handle'"])
tool("300 ellipsoids", BALL * 300, "300 ellipsoids")
tool("900 kB", b"#" * 900_000, "bytes")
tool("escape sequences in a key", BALL + b'"\\u001b[31mred\\u009b" = 1', ["line 4", "red"])
tool("10,000 nested arrays", NAMED + b"semi_axes = " + b"[" * 10_000, "line 3")

# --- outputs ------------------------------------------------------------------------------------

for command in (["replay", "a.ply", "--trajectory", "path.csv"], ["report", "run.csv"], ["make-scene", "sphere", "--spacing", "0.02"]):
    row(f"output: {command[0]} to a missing folder", [*command, "--out", "missing/out"], ["missing/out", "No such file"])
    row(f"output: {command[0]} to a folder", [*command, "--out", "."], "is a folder")
    row(f"output: {command[0]} to a full disk", [*command, "--out", "/dev/full"], ["/dev/full", "No space left"])
row("output: over the scene", ["replay", "a.ply", "--trajectory", "path.csv", "--out", "a.ply"], ["a.ply", "input"])
row("output: over the trajectory", ["replay", "a.ply", "--trajectory", "path.csv", "--out", "path.csv"], ["path.csv", "input"])
row("output: over the materials", ["replay", "a.ply", "--trajectory", "path.csv", "--materials", "m.toml", "--out", "m.toml"],
    ["m.toml", "input"], 1, {"m.toml": REGION})
row("output: over the run", ["report", "run.csv", "--out", "run.csv"], ["run.csv", "input"])
row("output: hostile name", ["replay", "a.ply", "--trajectory", "path.csv", "--out", "no\x1b[31m\n/x\u009b.csv"], "No such file")
