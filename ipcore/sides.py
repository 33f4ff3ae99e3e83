"""Which side of the shape a place in the box lies on, and whether that is sure."""
import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.spatial import cKDTree
from ipcore import winding

REACH = 0.25
NEAR, NEARS, SLOPE = .02, {2: .7, 3: 1.}, .5
BUDGET = 2e7


class Sides:
    def __init__(self, points, normals, bounds, coarse=None, few=None):
        self.points, self.normals, self.bounds = points, normals, bounds
        self.d = d = points.shape[1]
        self.tree = cKDTree(points)
        r = self.tree.query(points[np.random.default_rng(0).permutation(len(points))[:2000]], k=2)[0][:, 1]
        self.spacing = float(np.median(r))
        few = few or 1500
        coarse = coarse or (64 if d == 2 else 32)
        some = np.random.default_rng(1).permutation(len(points))[:few]
        self.order = np.random.default_rng(1).permutation(len(points))
        self.allA = winding.areas(points)
        self.local = np.maximum(NEAR, NEARS[d] * (self.allA if d == 2 else np.sqrt(self.allA)))
        self.p, self.n = points[some], normals[some]
        self.A = winding.areas(self.p)
        lines = [np.linspace(a, b, coarse) for a, b in bounds.T]
        q = np.stack(np.meshgrid(*lines, indexing='ij'), -1).reshape(-1, d)
        w = winding.winding_number(q, self.p, self.n, self.A)
        level = max(np.quantile(w, .98), .7)
        self.level = level
        self.out = RegularGridInterpolator(lines, (0.5 - w / level).reshape((coarse,) * d), bounds_error=False, fill_value=None)

    def at(self, q):
        """distance, side (0 unsure)."""
        dist, nearest = self.tree.query(q, distance_upper_bound=REACH)
        far = np.isinf(dist)
        self.near_at = np.where(far, 0., self.local[np.where(far, 0, nearest)])
        nearest[far] = 0
        out = self.out(q)
        near = np.flatnonzero(~far)
        e = q[near] - self.points[nearest[near]]
        cos = (e * self.normals[nearest[near]]).sum(1) / np.maximum(dist[near], 1e-300)
        o = out[near]
        doubtful = near[(np.sign(cos) != np.sign(o)) | (abs(cos) < .5) | (abs(o) < .25)]
        self.doubtful = len(doubtful)
        if len(doubtful):
            k = int(min(len(self.points), max(1500, BUDGET / len(doubtful))))
            if k == len(self.points):
                p, n, A = self.points, self.normals, self.allA
            else:
                some = self.order[:k]
                p, n = self.points[some], self.normals[some]
                A = winding.areas(p)
            w = winding.winding_number(q[doubtful], p, n, A)
            out[doubtful] = .5 - w / self.level
        dist[far] = REACH
        return dist, np.where(abs(out) > .12, np.sign(out), 0.)

    def nodes(self, q):
        dist, side = self.at(q)
        near = self.near_at
        side = np.where(dist > near, side, 0.)
        return side, SLOPE * np.minimum(dist - near / 2, .10), dist
