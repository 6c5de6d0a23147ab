#!/usr/bin/env python3
"""Draws tool files from above (x to the right, y up) and from the side (x to the right, z up) as one SVG.

    draw_tools.py FILE.toml... > docs/images/tools.svg

An ellipsoid is drawn in orthographic projection, as an ellipse; a cross marks the handle.
"""

import html
import math
import os
import sys
import tomllib

PANEL, HEAD, MARGIN = 250, 44, 16  # pixels
VIEWS = {"from above": (0, 1), "from the side": (0, 2)}  # indices of the axes to the right and up
COLORS = ("#4c78a8", "#72b7b2", "#54a24b", "#eeca3b", "#f58518", "#e45756", "#b279a2")


def rotation(q):
    n = math.sqrt(sum(v * v for v in q))
    w, x, y, z = (v / n for v in q)
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def outline(part, right, up):
    """Projected ellipse of a part: centre, half extents to the right and up, semi-axes, and angle in degrees."""
    turned, a = rotation(part.get("orientation", [1, 0, 0, 0])), part["semi_axes"]

    def product(i, k):  # entry of the shape matrix R diag(a)^2 R^T
        return sum(turned[i][j] * turned[k][j] * a[j] ** 2 for j in range(3))

    xx, yy, xy = product(right, right), product(up, up), product(right, up)
    mean, apart = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    center = part.get("position", [0, 0, 0])
    return ((center[right], center[up]), (math.sqrt(xx), math.sqrt(yy)),
            (math.sqrt(mean + apart), math.sqrt(max(mean - apart, 0))), math.degrees(math.atan2(2 * xy, xx - yy) / 2))


def bounds(parts, axes):
    low, high = [0.0, 0.0], [0.0, 0.0]  # the bounds include the handle
    for center, half, _, _ in (outline(part, *axes) for part in parts):
        low = [min(l, c - h) for l, c, h in zip(low, center, half)]
        high = [max(l, c + h) for l, c, h in zip(high, center, half)]
    return low, high


def panel(parts, axes, scale):
    """SVG of the ellipses, farthest first, and the handle, centred at (0, 0)."""
    low, high = bounds(parts, axes)
    middle = [(l + h) / 2 for l, h in zip(low, high)]
    behind = ({0, 1, 2} - set(axes)).pop()
    towards = 1 if behind == 2 else -1  # seen from +z, or from -y
    svg = []
    for k in sorted(range(len(parts)), key=lambda k: towards * parts[k].get("position", [0, 0, 0])[behind]):
        center, _, (a, b), angle = outline(parts[k], *axes)
        x, y = scale * (center[0] - middle[0]), -scale * (center[1] - middle[1])
        svg.append(f'<ellipse rx="{scale * a:.1f}" ry="{scale * b:.1f}" fill="{COLORS[k % len(COLORS)]}"'
                   f' transform="translate({x:.1f} {y:.1f}) rotate({-angle:.1f})"/>')
    svg.append(f'<path d="M{-scale * middle[0] - 5:.1f} {scale * middle[1]:.1f}h10m-5 -5v10" class="handle"/>')
    return svg


def draw(path, left):
    with open(path, "rb") as file:
        parts = tomllib.load(file)["ellipsoid"]
    extent = max(h - l for axes in VIEWS.values() for l, h in zip(*bounds(parts, axes)))
    scale = (PANEL - 2 * MARGIN) / extent
    middle = left + PANEL / 2
    name = html.escape(os.path.splitext(os.path.basename(path))[0])
    yield f'<text x="{middle}" y="20" class="name">{name}</text>'
    yield f'<text x="{middle}" y="38">{len(parts)} ellipsoid{"s" * (len(parts) > 1)}, {1e3 * extent:.0f} mm</text>'
    for row, axes in enumerate(VIEWS.values()):
        yield f'<g transform="translate({middle} {HEAD + PANEL * (row + 0.5)})">'
        yield from panel(parts, axes, scale)
        yield "</g>"


def main():
    width, height = 90 + PANEL * len(sys.argv[1:]), HEAD + PANEL * len(VIEWS)
    print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">')
    print('<style>text{font:13px sans-serif;text-anchor:middle;fill:#333}.name{font-weight:bold}'
          'ellipse{stroke:#222;stroke-width:.8;fill-opacity:.75}.handle{stroke:#000;stroke-width:2;fill:none}</style>')
    print(f'<rect width="{width}" height="{height}" fill="#fff"/>')
    for row, view in enumerate(VIEWS):
        print(f'<text x="48" y="{HEAD + PANEL * (row + 0.5)}">{view}</text>')
    for k, path in enumerate(sys.argv[1:]):
        print("\n".join(draw(path, 90 + PANEL * k)))
    print("</svg>")


if __name__ == "__main__":
    main()
