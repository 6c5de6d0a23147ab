"""Contacts and forces against a second implementation: numpy, brute force, the paper's own formulas.

Nothing here shares code or form with palpate: the file is parsed anew, K is evaluated from 3x3 solves
of the covariances, and its minimum is found by golden section in double precision.
"""

import math
import unittest

import numpy as np

from support import Case, columns_of, path_csv, ply, random_rows

K_TOLERANCE = 1e-9


def quaternion_matrix(q):
    w, x, y, z = np.asarray(q, float) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def parse_ply(data):
    """The columns of a binary little-endian .ply of floats."""
    header, body = data.split(b"end_header\n", 1)
    names = [line.split()[-1].decode() for line in header.split(b"\n") if line.startswith(b"property")]
    table = np.frombuffer(body, "<f4").reshape(-1, len(names)).astype(float)
    return {name: table[:, k] for k, name in enumerate(names)}


class Scene:
    """Ellipsoids in the world, after filter and registration (paper III-A, eqs. 2 and 3)."""

    def __init__(self, data, opacity_min=0.1, sigma=1.0, iso=None, scale=1.0, rotate=(1, 0, 0, 0), translate=(0, 0, 0),
                 mirror=False):
        p = parse_ply(data)
        alpha = 1 / (1 + np.exp(-p["opacity"]))
        keep = alpha > opacity_min if iso is None else (alpha > opacity_min) & (alpha > iso)
        self.id = np.flatnonzero(keep)
        self.alpha = alpha[keep]
        k = np.full(len(self.id), sigma) if iso is None else np.sqrt(2 * np.log(self.alpha / iso))
        mu = np.stack([p["x"], p["y"], p["z"]], 1)[keep]
        sigmas = np.exp(np.stack([p[f"scale_{i}"] for i in range(3)], 1)[keep])
        turns = np.stack([quaternion_matrix(q) for q in np.stack([p[f"rot_{i}"] for i in range(4)], 1)[keep]])
        world = quaternion_matrix(rotate) @ np.diag([-1 if mirror else 1, 1, 1])
        self.center = scale * mu @ world.T + np.asarray(translate, float)
        axes = np.einsum("ij,njk,nk->nik", world, turns, sigmas) * (scale * k)[:, None, None]
        self.covariance = np.einsum("nij,nkj->nik", axes, axes)
        self.radius = scale * k * sigmas.max(1)


class Tool:
    def __init__(self, position, q=(1, 0, 0, 0), semi_axes=(0.02, 0.02, 0.04)):
        self.center = np.asarray(position, float)
        axes = quaternion_matrix(q) * np.asarray(semi_axes, float)
        self.covariance = axes @ axes.T
        self.radius = max(semi_axes)


def k_function(lam, A, B, d):
    """K(lambda) of paper eqs. 5-6 for every pair."""
    M = (1 - lam)[:, None, None] * B + lam[:, None, None] * A
    return 1 - lam * (1 - lam) * np.einsum("ni,ni->n", d, np.linalg.solve(M, d[:, :, None])[:, :, 0])


def minimum_of_k(A, B, d):
    """min K by golden section; K is convex."""
    g = (math.sqrt(5) - 1) / 2
    low, high = np.zeros(len(d)), np.ones(len(d))
    for _ in range(60):
        a, b = high - g * (high - low), low + g * (high - low)
        left = k_function(a, A, B, d) < k_function(b, A, B, d)
        high, low = np.where(left, b, high), np.where(left, low, a)
    return k_function((low + high) / 2, A, B, d)


def contacts_of(scene, tool):
    """Row in `scene` and K_min of everything that is not clearly apart."""
    near = np.flatnonzero(np.linalg.norm(scene.center - tool.center, axis=1) < scene.radius + tool.radius)
    if not len(near):
        return near, np.zeros(0)
    k = minimum_of_k(scene.covariance[near], tool.covariance, tool.center - scene.center[near])
    return near[k > -K_TOLERANCE], k[k > -K_TOLERANCE]


class DensityForce:
    """Paper eqs. 7-11, with averages in time."""

    def __init__(self, k_base=0.1, damping=5.0, f_max=12.0, tau_direction=0.01, tau_opacity=0.01, tau_velocity=0.005):
        self.__dict__.update(locals())
        self.velocity = None
        self.inward = None

    @staticmethod
    def blend(dt, tau):
        return 1 - math.exp(-dt / tau) if tau > 0 else 1.0

    def __call__(self, scene, tool, rows, k, velocity, dt):
        if self.velocity is None:
            self.velocity = velocity
        else:
            self.velocity = self.velocity + self.blend(dt, self.tau_velocity) * (velocity - self.velocity)
        if not len(rows):
            self.inward = None
            return np.zeros(3)
        w = np.exp(k) / np.exp(k).sum()  # eq. 7
        p = w @ scene.center[rows]  # eq. 8
        inward = (p - tool.center) / np.linalg.norm(p - tool.center)
        alpha = w @ scene.alpha[rows]
        if self.inward is None:
            self.inward, self.alpha = inward, alpha
        else:
            self.inward = self.inward + self.blend(dt, self.tau_direction) * (inward - self.inward)
            self.inward /= np.linalg.norm(self.inward)
            self.alpha += self.blend(dt, self.tau_opacity) * (alpha - self.alpha)
        outward = -self.inward
        magnitude = self.k_base * self.alpha * len(rows) - self.damping * (self.velocity @ outward)  # eqs. 9-10
        return min(max(magnitude, 0.0), self.f_max) * outward  # eq. 11


def text_of(values):
    return ",".join(repr(float(v)) for v in values)


class Oracle(Case):
    def setUp(self):
        super().setUp()
        self.data = ply(random_rows(300, 20))
        self.write("a.ply", self.data)
        self.random = np.random.default_rng(21)

    def random_registration(self):
        """Keyword arguments of Scene, and the same as options."""
        r = self.random
        scale = math.exp(r.uniform(-1.5, 1.5))
        kwargs = {"scale": scale, "rotate": r.normal(size=4) * 2, "translate": r.normal(size=3)}
        options = ["--scale", repr(scale), "--rotate", text_of(kwargs["rotate"]),
                   "--translate", text_of(kwargs["translate"])]
        if r.random() < 0.5:
            kwargs["mirror"] = True
            options.append("--mirror")
        if r.random() < 0.5:
            kwargs["sigma"] = r.uniform(0.3, 3)
            options += ["--sigma", repr(kwargs["sigma"])]
        else:
            kwargs["iso"] = r.uniform(0.02, 0.5)
            options += ["--iso", repr(kwargs["iso"])]
        kwargs["opacity_min"] = r.uniform(0.0, 0.4)
        return kwargs, options + ["--opacity-min", repr(kwargs["opacity_min"])]

    def random_tool(self, scene, scale):
        r = self.random
        at = scene.center[r.integers(len(scene.id))] + 0.05 * scale * r.normal(size=3)
        return at, r.normal(size=4), 0.03 * scale * np.exp(r.normal(size=3))

    def test_contacts_under_random_registrations(self):
        seen = 0
        for _ in range(60):
            kwargs, options = self.random_registration()
            scene = Scene(self.data, **kwargs)
            at, q, semi_axes = self.random_tool(scene, kwargs["scale"])
            q = q / np.linalg.norm(q)
            tool = Tool(at, q, semi_axes)
            document = self.succeed("query", "a.ply", "--json", "--pose", text_of([*at, *q]), "--tool",
                                    text_of(semi_axes), *options).json
            self.check_contacts(scene, tool, document)
            seen += len(document["contacts"])
        self.assertGreater(seen, 300)

    def check_contacts(self, scene, tool, document):
        rows, k = contacts_of(scene, tool)
        expected = {int(scene.id[row]): (row, value) for row, value in zip(rows, k)}
        found = {c["id"]: c for c in document["contacts"]}
        for gaussian in expected.keys() ^ found.keys():
            self.assertIn(gaussian, expected)
            self.assertLess(abs(expected[gaussian][1]), K_TOLERANCE)
        for gaussian, c in found.items():
            row, value = expected[gaussian]
            self.assertAlmostEqual(c["k_min"], value, delta=K_TOLERANCE)
            self.assertAlmostEqual(c["opacity"], scene.alpha[row], delta=1e-12)
            self.check_geometry(scene.center[row], scene.covariance[row], tool, c)
        self.assertLessEqual(document["candidates"], len(scene.id))
        self.assertLessEqual(document["filtered"], document["candidates"])
        self.assertLessEqual(len(document["contacts"]), document["filtered"])

    def check_geometry(self, center, A, tool, c):
        """center, point, normal, depth and lambda of one contact must fit each other."""
        size = math.sqrt(np.trace(A)) + tool.radius
        np.testing.assert_allclose(c["center"], center, rtol=0, atol=1e-12 * (1 + np.abs(center).max()))
        B, d = tool.covariance, tool.center - center
        lam = np.array([c["lambda"]])
        self.assertAlmostEqual(k_function(lam, A[None], B, d[None])[0], c["k_min"], delta=K_TOLERANCE)
        # At the minimum the contact point lies equally deep in both solids: at the level 1 - K_min of each.
        point, normal = np.array(c["point"]), np.array(c["normal"])
        to_tool, to_gaussian = point - tool.center, point - center
        self.assertAlmostEqual(to_tool @ np.linalg.solve(B, to_tool), 1 - c["k_min"], delta=1e-5)
        self.assertAlmostEqual(to_gaussian @ np.linalg.solve(A, to_gaussian), 1 - c["k_min"], delta=1e-5)
        # There the two level surfaces touch: one normal, out of the Gaussian and into the tool.
        self.assertAlmostEqual(np.linalg.norm(normal), 1, delta=1e-12)
        if c["k_min"] < 0.999:
            for gradient in (np.linalg.solve(A, to_gaussian), -np.linalg.solve(B, to_tool)):
                self.assertGreater(normal @ gradient / np.linalg.norm(gradient), 1 - 1e-6)
        depth = math.sqrt(normal @ A @ normal) + math.sqrt(normal @ B @ normal) - normal @ d
        self.assertAlmostEqual(c["depth"], depth, delta=1e-10 * size)

    def test_the_papers_pipeline_finds_the_same_within_its_reach(self):
        scene = Scene(self.data)
        for _ in range(10):
            at, q, semi_axes = self.random_tool(scene, 1.0)
            q = q / np.linalg.norm(q)
            tool = Tool(at, q, semi_axes)
            document = self.succeed("query", "a.ply", "--json", "--pose", text_of([*at, *q]), "--tool",
                                    text_of(semi_axes), "--pipeline", "paper", "--search-radius", "10").json
            rows, k = contacts_of(scene, tool)
            clear = {int(scene.id[row]) for row, value in zip(rows, k) if value > 1e-6}
            self.assertLessEqual(clear, {c["id"] for c in document["contacts"]})
            self.assertEqual(document["candidates"], len(scene.id))
            for c in document["contacts"]:
                value = k[np.flatnonzero(scene.id[rows] == c["id"])[0]]
                self.assertAlmostEqual(c["k_min"], value, delta=1e-6)

    def test_the_force_of_one_pose(self):
        scene = Scene(self.data)
        for options, force in (([], DensityForce()), (["--k-base", "0.37", "--f-max", "1.5"],
                                                      DensityForce(k_base=0.37, f_max=1.5))):
            for _ in range(10):
                at = self.random.uniform(-0.15, 0.15, size=3)
                tool = Tool(at)
                rows, k = contacts_of(scene, tool)
                force.inward = None
                expected = force(scene, tool, rows, k, np.zeros(3), 0.0)
                document = self.succeed("query", "a.ply", "--model", "density", "--json", "--pose", text_of(at),
                                        *options).json
                np.testing.assert_allclose(document["force"], expected, rtol=0, atol=1e-8)
                self.assertEqual(document["torque"], [0, 0, 0])

    def test_the_forces_of_a_replay(self):
        scene = Scene(self.data)
        poses, times = [], np.cumsum(self.random.uniform(1e-3, 4e-3, size=150))
        for t in times:
            s = 6 * t
            poses.append((t, 0.25 * math.sin(3 * s), 0.1 * math.cos(s), 0.05 * math.sin(2 * s)))
        self.write("path.csv", path_csv(poses))
        self.succeed("replay", "a.ply", "--trajectory", "path.csv", "--out", "run.csv", "-q", "--model", "density", "--damping", "2",
                     "--tau-direction", "0.02", "--tau-opacity", "0.03", "--tau-velocity", "0.004")
        run = columns_of(self.read("run.csv"))
        force = DensityForce(damping=2.0, tau_direction=0.02, tau_opacity=0.03, tau_velocity=0.004)
        touching = 0
        for i, (t, *at) in enumerate(poses):
            tool = Tool(at)
            rows, k = contacts_of(scene, tool)
            self.assertEqual(int(run["colliding"][i]), len(rows))
            self.assertAlmostEqual(float(run["k_max"][i]), max(k, default=0.0), delta=K_TOLERANCE)
            before = poses[max(i - 1, 0)]
            dt = t - before[0]
            velocity = (np.array(at) - before[1:]) / dt if dt > 0 else np.zeros(3)
            expected = force(scene, tool, rows, k, velocity, dt)
            found = [float(run[f][i]) for f in ("fx", "fy", "fz")]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7, err_msg=f"row {i}")
            touching += len(rows) > 0
        self.assertTrue(20 < touching < 150, touching)


if __name__ == "__main__":
    unittest.main()
