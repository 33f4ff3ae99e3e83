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


class Extra:
    """Sign constraints at scattered points."""
    def __init__(self, t, side, margin, weight, top):
        self.t, self.side, self.margin, self.weight = t, side, margin, weight
        self.tables = [basis.table(Basis.CHEBYSHEV, np.ascontiguousarray(r), 2 * top) for r in t]

    def shortfall(self, tensor, n):
        f = contraction.scattered(tensor[None], [t[:n + 1] for t in self.tables])[0]
        return np.maximum(0., self.margin - self.side * f)

    def join(self, t, side, margin, weight, top):
        return Extra(np.concatenate([self.t, t], 1), np.r_[self.side, side], np.r_[self.margin, margin], weight, top)


class Geometric:
    def __init__(self, rows, signs, degree, angle=1e-3, weight=10., extra=None):
        self.rows, self.signs, self.n, self.angle, self.weight = rows, signs, degree, angle, weight
        self.d = rows.d
        self.m = monomials.count(self.d, degree)
        self.T1 = [t[:degree + 1] for t in rows.tables]
        self.T2 = [t[:2 * degree + 1] for t in rows.tables]
        self.D = [gram.differentiation(self.d, degree, k) / rows.half[k] for k in range(self.d)]
        if self.m <= 150:
            self.D = [D.toarray() for D in self.D]
        self.Dt = [D.T.copy() if self.m <= 150 else D.T.tocsr() for D in self.D]
        self.perm = gram.position(monomials.exponents(self.d, degree), degree)
        self.extra = extra
        self.t = 1.0

    def look(self, a):
        tensors = contraction.to_tensor(np.stack([a] + [D @ a for D in self.D]), self.d, self.n)
        v = contraction.scattered(tensors, self.T1)
        s = np.maximum(np.sqrt(self.t * (v[1:] ** 2).sum(0) + 1 - self.t), 1e-12)
        nodes = self.signs.shortfall(self.signs.values(tensors[0]))
        more = self.extra.shortfall(tensors[0], self.n) if self.extra else None
        return v[0] / s, s, v[1:] / s, nodes, more

    def phi(self, look):
        dist, s, g, v, more = look
        out = (dist ** 2).mean() + self.angle * ((g - self.rows.normals) ** 2).sum(0).mean() + self.weight * np.vdot(v, v) / v.size
        return out if more is None else out + self.extra.weight * np.vdot(more, more)

    def stat(self, look):
        dist, s, g, v, more = look
        k = np.maximum(np.sqrt((g ** 2).sum(0)), 1e-12)
        return (abs(dist) / k).mean(), ((g * self.rows.normals).sum(0) / k).mean()

    def linearise(self, look):
        dist, s, g, v, more = look
        N, d = len(s), self.d
        gg = (g ** 2).sum(0)
        u = np.concatenate([np.ones((1, N)), -self.t * dist * g]) / s
        pairs = [(i, j) for i in range(d + 1) for j in range(i, d + 1)]
        W = np.empty((len(pairs), N))
        for r, (i, j) in enumerate(pairs):
            W[r] = u[i] * u[j]
            if i:
                W[r] += self.angle * ((i == j) - (2 * self.t - self.t ** 2 * gg) * g[i - 1] * g[j - 1]) / s ** 2
        W /= N
        mu = gram.moments(self.T2, W)
        mu[:, :1] += self.weight * self.signs.gram(v, self.n)
        if more is not None:
            mu[:, :1] += gram.moments([t[:2 * self.n + 1] for t in self.extra.tables], self.extra.weight * (more > 0)[None].astype(float))
        G = gram.gram(mu, self.d, self.n)
        at = {p: k for k, p in enumerate(pairs)}
        H = 0
        for i in range(d + 1):
            row = 0
            for j in range(d + 1):
                part = G[at[min(i, j), max(i, j)]]
                row = row + (part if j == 0 else (self.Dt[j - 1] @ part).T)
            H = H + (row if i == 0 else self.Dt[i - 1] @ row)
        nn = self.rows.normals
        cos = (g * nn).sum(0)
        first = u * dist
        first[1:] -= self.angle * (nn - g - self.t * g * (cos - gg)) / s
        first /= N
        b = gram.moments(self.T1, first)[self.perm]
        r = -b[:, 0] - sum(self.Dt[k] @ b[:, k + 1] for k in range(d))
        r = r + self.weight * contraction.from_tensor(self.signs.pull(v, self.n), d, self.n)
        if more is not None:
            pull = gram.moments([t[:self.n + 1] for t in self.extra.tables], self.extra.weight * (more * self.extra.side)[None])
            r = r + pull[self.perm, 0]
        return H, r

    def refine(self, a, steps=25, damping=1e-3, tol=1e-4, patience=1, far=None):
        look = self.look(a)
        now = self.phi(look)
        self.count = 0
        grow = 4.
        slow = 0
        for _ in range(steps):
            self.count += 1
            H, r = self.linearise(look)
            scale = H.diagonal()
            for _ in range(12):
                step = solve(H, r, damping)
                then = self.look(a + step)
                new = self.phi(then)
                if new < now:
                    break
                damping *= grow
                grow *= 2
            else:
                break
            predicted = step @ (2 * r - H @ step)
            rho = (now - new) / predicted
            gain = (now - new) / now
            a, now, look = a + step, new, then
            damping = max(damping * max(1 / 10, 1 - (2 * rho - 1) ** 3), 1e-12)
            grow = 2.
            slow = slow + 1 if gain < tol else 0
            if slow >= patience:
                break
            if far and gain < far[1]:
                D, S = self.stat(look)
                if max(D / .01, (1 - S) / .05) > far[0]:
                    break
        self.last = look
        self.now = now
        self.damping = damping
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
