"""The geometric fit under sign constraints."""
import numpy as np
from scipy.linalg import lapack
from ipcore import basis, contraction, gram, monomials
from ipcore.basis import Basis


class Rows:
    """Data points' tables."""
    def __init__(self, points, normals, bounds, top):
        self.d = points.shape[1]
        mid, self.half = bounds.mean(0), (bounds[1] - bounds[0]) / 2
        t = ((points - mid) / self.half).T
        self.tables = [basis.table(Basis.CHEBYSHEV, np.ascontiguousarray(r), top) for r in t]
        self.normals = normals.T.copy()
        self.points = points


class Geometric:
    def __init__(self, rows, signs, degree, angle=1e-3, weight=10.):
        self.rows, self.signs, self.n, self.angle, self.weight = rows, signs, degree, angle, weight
        self.d = rows.d
        self.m = monomials.count(self.d, degree)
        self.T1 = [t[:degree + 1] for t in rows.tables]
        self.T2 = [t[:2 * degree + 1] for t in rows.tables]
        self.D = [gram.differentiation(self.d, degree, k) / rows.half[k] for k in range(self.d)]
        self.perm = gram.position(monomials.exponents(self.d, degree), degree)
        self.extra = None

    def look(self, a):
        tensors = contraction.to_tensor(np.stack([a] + [D @ a for D in self.D]), self.d, self.n)
        v = contraction.scattered(tensors, self.T1)
        s = np.maximum(np.sqrt((v[1:] ** 2).sum(0)), 1e-12)
        nodes = self.signs.shortfall(self.signs.values(tensors[0]))
        return v[0] / s, s, v[1:] / s, nodes

    def phi(self, look):
        dist, s, g, v = look
        return (dist ** 2).mean() + self.angle * ((g - self.rows.normals) ** 2).sum(0).mean() + self.weight * np.vdot(v, v) / v.size

    def stat(self, look):
        dist, s, g, v = look
        return abs(dist).mean(), (g * self.rows.normals).sum(0).mean()

    def linearise(self, look):
        dist, s, g, v = look
        N, d = len(s), self.d
        # weights
        u = np.concatenate([np.ones((1, N)), -dist * g]) / s
        pairs = [(i, j) for i in range(d + 1) for j in range(i, d + 1)]
        W = np.empty((len(pairs), N))
        for r, (i, j) in enumerate(pairs):
            W[r] = u[i] * u[j]
            if i:
                W[r] += self.angle * ((i == j) - g[i - 1] * g[j - 1]) / s ** 2
        W /= N
        mu = gram.moments(self.T2, W)
        mu[:, :1] += self.weight * self.signs.gram(v, self.n)
        G = gram.gram(mu, self.d, self.n)
        at = {p: k for k, p in enumerate(pairs)}
        H = 0
        for i in range(d + 1):
            row = 0
            for j in range(d + 1):
                part = G[at[min(i, j), max(i, j)]]
                row = row + (part if j == 0 else (self.D[j - 1].T @ part).T)
            H = H + (row if i == 0 else self.D[i - 1].T @ row)
        nn = self.rows.normals
        cos = (g * nn).sum(0)
        first = u * dist
        first[1:] -= self.angle * (nn - g * cos) / s
        first /= N
        b = gram.moments(self.T1, first)[self.perm]
        r = -b[:, 0] - sum(self.D[k].T @ b[:, k + 1] for k in range(d))
        r = r + self.weight * contraction.from_tensor(self.signs.pull(v, self.n), d, self.n)
        return H, r

    def refine(self, a, steps=25, damping=1e-3, tol=1e-4):
        look = self.look(a)
        now = self.phi(look)
        self.count = 0
        for _ in range(steps):
            self.count += 1
            H, r = self.linearise(look)
            for _ in range(8):
                step = solve(H, r, damping)
                then = self.look(a + step)
                new = self.phi(then)
                if new < now:
                    break
                damping *= 6
            else:
                break
            gain = (now - new) / now
            a, now, look = a + step, new, then
            damping = max(damping / 5, 1e-10)
            if gain < tol:
                break
        self.last = look
        self.now = now
        return a


def solve(H, r, damping=0.):
    s = 1 / np.sqrt(np.diag(H))
    A0 = H * s * s[:, None]
    for shift in (0, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9):
        A = A0.copy()
        A[np.diag_indices(len(A))] += damping + shift
        f, info = lapack.dpotrf(A)
        if info == 0:
            return s * lapack.dpotrs(f, s * r)[0]
    raise ArithmeticError
