#!/usr/bin/env bash
# Compares the contact query with its peers and writes all of docs/performance.md.
#   tools/performance.sh FOLDER    all measurements; FOLDER temporarily holds a scene of 100 million Gaussians and its
#                                  index: 20 GB. Needs 16 GB of memory, one hour, and an otherwise idle machine.
#   tools/performance.sh --quick   without the scenes of 10 and 100 million, to build/bench/performance-quick.md
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"

usage="usage: tools/performance.sh FOLDER | --quick"
[[ $# -eq 1 ]] || die "$usage"
quick=no
page=$root/docs/performance.md
sizes=(10000 100000 1000000 10000000)
if [[ $1 == --quick ]]; then
  quick=yes
  page=$root/build/bench/performance-quick.md
  sizes=(10000 100000 1000000)
else
  [[ -d $1 && -w $1 ]] || die "$1 is not a folder that can be written; $usage"
  needed_kib=$((20 * 1000 * 1000))
  [[ $(df --output=avail -k "$1" | tail -n 1) -gt $needed_kib ]] || die "$1 has less than 20 GB of free space"
fi

ensure_packages "${build_packages[@]}" libfcl-dev libbullet-dev libembree-dev libbenchmark-dev
build_preset bench OFF peers growth limit make_bench_scene
bin=$root/build/bench/bin

work=$(mktemp -d)
large='' # file of the scene of 100 million Gaussians
trap 'rm -rf "$work" ${large:+"$large" "$large.palpate"}' EXIT

# measure NAME PROGRAM [ARGS...]: runs a program and stores its table as $work/NAME.
measure() {
  local name=$1 program=$2
  shift 2
  say "$program $*"
  "$bin/$program" "$@" --markdown "$work/$name" >/dev/null 2>"$work/log" || {
    cat "$work/log" >&2
    die "$program $* failed"
  }
}

# table NAME: prints a stored table without its first two lines: machine and date, and an empty line.
table() { tail -n +3 "$work/$1"; }

measure one_sigma peers
measure three_sigma peers --sigma 3
measure shuffled peers --shuffle
measure whole_scene peers --whole-scene
measure sizes growth --sweep gaussians --gaussians "${sizes[@]}"
measure density growth --sweep density
measure sigma growth --sweep sigma
measure tool growth --sweep tool
measure limit limit
if [[ $quick == no ]]; then
  large=$(mktemp --tmpdir="$1" palpate-XXXXXX.ply)
  say "make_bench_scene 100000000 $large"
  "$bin/make_bench_scene" 100000000 "$large"
  measure large growth --scene "$large"
fi

write_page() {
  cat <<END
# Performance

Written by \`tools/performance.sh$([[ $quick == no ]] || echo ' --quick')\`, to be edited there.

$(head -n 1 "$work/one_sigma")

## What is measured, and how

The question: given the tool, an ellipsoid, which Gaussians does it overlap, and how far? The scene is a hall of floors,
spheres, boxes, tori and walls, covered with flat Gaussians 3.5 mm apart, of which one in a hundred is 2 to 20 times as
large, as captures have them; a larger scene has more of them, not denser ones. The tool comes down on a surface, slides
along it for a few centimetres and leaves, at 1000 poses a second. All of it follows from a seed and can be made again.

Every pipeline answers the same poses in the same run, on one thread. The clock is read before and after a single query.
A time is the least of three rounds, because whatever else the machine does only adds; quantiles are over poses, so that
p99.9 is what the hardest poses cost. Every answer is held against a brute-force truth in extended precision, which
shares no code with any pipeline: *misses* are contacts that were not found, *extras* Gaussians that do not touch,
*worst dK* is the largest error of K_min.

The peers are the pipeline of the paper (kd-tree over centres, golden section; with the search radius that reaches 99 %
of the Gaussians, and with the one that reaches all), FCL (dynamic AABB tree, GJK), Bullet (dbvt) and Embree (point
query), the latter two with the paper's golden section. *palpate AVX3* is a fresh query on AVX-512, the others are the
same on lesser processors; *single* has its figures in single precision (the verdicts are the same); the *tracker*
follows the tool from pose to pose. The last two columns say how many times as long the medians of the paper and of the
best peer are.

## Peers, a million Gaussians

$(table one_sigma)

The same with larger ellipsoids, hence more contacts:

$(table three_sigma)

The same poses in random order: none is near the one before, which a tracker does not like.

$(table shuffled)

Every pose somewhere else in the scene: cold caches for every pipeline.

$(table whole_scene)

## What makes it slower

The size of the scene does not, but for memory that is farther away. *Wrong verdicts* are misses and extras together.
$(table sizes)

The number of contacts does, here by packing Gaussians closer, a million each time,
$(table density)

and here by larger ellipsoids around the same centres.
$(table sigma)

So does the tool, since a larger one touches more. Its length is in the table; its other two axes are half of that.
$(table tool)
END
  if [[ $quick == no ]]; then
    cat <<END

## A hundred million Gaussians

From a file, as a user has it. The index is made in bounded memory, then mapped, so that all processes share it and the
system may have its pages back; *anonymous memory* is what remains, sampled while the index was made. The first contact
includes that all of the index file is read and checked. *Build* is the time to make the index file, *memory* its size.
$(table large)
END
  fi
  cat <<END

## Distance from the theoretical limit

What is the least that the mathematics needs? Count the arithmetic of each stage from its formulas (\`bench/limit.cpp\`
has the counts), multiply by how often a query of the first table needs it, and divide by what one core does when
nothing holds it up. No program gets there: numbers must also be fetched, packed and stored, divisions and square roots
take longer than multiplications, and a stage must know its result before the next begins.

$(table limit)

## On your own scene

    palpate bench scene.ply --trajectory path.csv --histogram times.svg

times the same query on a scene and a path of yours (without \`--trajectory\`, on a path that it makes), and
the tracker and the force model with it; \`--json\` prints the same for programs.
END
}
mkdir -p "$(dirname "$page")"
write_page >"$work/page"
cp "$work/page" "$page"
say "wrote $page"
