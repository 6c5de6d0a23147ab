"""The table of 0003-depth-by-support.md: two estimates of contact depth against the true separating translation.

Run with numpy: python3 0003-depth-by-support.py
"""
import numpy as np

RNG = np.random.default_rng(1)
TOOL = np.array([0.02, 0.02, 0.04])


def random_rotation():
    w, x, y, z = (q := RNG.normal(size=4)) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def covariance(sigma):
    R = random_rotation()
    return (R * sigma**2) @ R.T


def minimum(A, B, d, iterations=70):
    """K_min and its lambda by golden section."""
    K = lambda l: 1 - l * (1 - l) * d @ np.linalg.solve((1 - l) * B + l * A, d)
    ratio, low, high = (np.sqrt(5) - 1) / 2, 0.0, 1.0
    for _ in range(iterations):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        if K(left) < K(right):
            high = right
        else:
            low = left
    return K((low + high) / 2), (low + high) / 2


def gap(A, B, d, N):
    """How far to move along each row of N until a plane across it separates."""
    h = lambda S: np.sqrt(np.einsum("ij,jk,ik->i", N, S, N))
    return h(A) + h(B) - N @ d


def true_depth(A, B, d):
    """The least gap over all directions: a dense start, then a shrinking random search."""
    k = np.arange(20000) + 0.5
    theta, phi = np.arccos(1 - 2 * k / 20000), np.pi * (1 + 5**0.5) * k
    N = np.c_[np.cos(phi) * np.sin(theta), np.sin(phi) * np.sin(theta), np.cos(theta)]
    best, width = N[gap(A, B, d, N).argmin()], 0.03
    for _ in range(12):
        N = np.vstack([best[None], best + width * RNG.normal(size=(300, 3))])
        N /= np.linalg.norm(N, axis=1)[:, None]
        best, width = N[gap(A, B, d, N).argmin()], width / 2
    return gap(A, B, d, best[None])[0]


def main():
    rows = []
    for _ in range(600):
        B = covariance(TOOL)
        A = covariance(np.exp(RNG.normal(size=3)) * [0.01, 0.01, 0.001])
        u = RNG.normal(size=3)
        u /= np.linalg.norm(u)
        touching = 1e-3 / np.sqrt(1 - minimum(A, B, 1e-3 * u)[0])
        share = RNG.choice([0.99, 0.9, 0.8, 0.6, 0.2, 0.05])
        d = touching * share * u
        k_min, l = minimum(A, B, d)
        q = np.linalg.solve((1 - l) * B + l * A, d)
        truth = true_depth(A, B, d)
        slope = k_min / (2 * l * (1 - l) * np.linalg.norm(q))
        support = gap(A, B, d, q[None] / np.linalg.norm(q))[0]
        rows.append((share, slope / truth, support / truth))
    rows = np.array(rows)
    print("share   slope: median, p99   support: median, p99")
    for share in sorted(set(rows[:, 0]), reverse=True):
        slope, support = rows[rows[:, 0] == share][:, 1:].T
        print(f"{share:5.2f}   {np.median(slope):7.3f} {np.percentile(slope, 99):7.3f}"
              f"      {np.median(support):7.3f} {np.percentile(support, 99):7.3f}")


if __name__ == "__main__":
    main()
