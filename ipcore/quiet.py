"""Quiet fits."""
from time import perf_counter
import numpy as np
from scipy import ndimage
from ipcore import basis, contraction, monomials, signs
from ipcore.basis import Basis
from ipcore.geometric import Extra, Geometric, Rows
from ipcore.sides import Sides

PER = {2: 10, 3: 6}
TS = (.7, .95, 1)
FARTOL = None
CHECK = {2: (251, 501), 3: (91, 129)}
SUBSET = 2000
CLOSE, SLOPE, BOOST, ROUNDS = .02, .25, .02, 8
FAR = {2: .10, 3: .12}


class Survey:
    """f on a fine even grid: far wrong nodes, components."""
    def __init__(self, sides, half, mid, count):
        self.sides, self.d = sides, sides.d
        self.half, self.mid = half, mid
        self.count = count
        self.u = signs.BEYOND * np.linspace(-1, 1, self.count)
        self.far = max(FAR[self.d], 2.5 * sides.spacing)

    def look(self, a, n):
        T = basis.table(Basis.CHEBYSHEV, self.u, n).T.copy()
        f = contraction.along_axes(contraction.to_tensor(a, self.d, n), [T] * self.d)
        neg = f < 0
        regions, small = 0, np.zeros_like(neg)
        for part in (neg, ~neg):
            labels, count = ndimage.label(part)
            regions += count
            if count > 1:
                sizes = np.bincount(labels.ravel())
                sizes[0] = 0
                small |= part & (labels != sizes.argmax())
        edge = np.zeros_like(neg)
        for k in range(self.d):
            lo = [slice(None)] * self.d; hi = list(lo)
            lo[k], hi[k] = slice(None, -1), slice(1, None)
            lo, hi = tuple(lo), tuple(hi)
            c = neg[lo] != neg[hi]
            edge[lo] |= c; edge[hi] |= c
        idx = np.argwhere(edge)
        q = self.mid + self.half * self.u[idx]
        dist = self.sides.tree.query(q, distance_upper_bound=self.far)[0]
        far = np.isinf(dist)
        stray = far.sum() / max(1, len(idx))
        wrong = small.copy()
        wrong[tuple(idx[far].T)] = True
        return f, regions - 1, stray, wrong, small


class QuietFit:
    def __init__(self, data, top, t1=.01, t2=.95, angle=1e-3, cnt=None):
        self.data, self.top, self.t1, self.t2, self.angle = data, top, t1, t2, angle
        self.d = d = data.points.shape[1]
        self.sides = Sides(data.points, data.normals, data.bounds)
        self.mid, self.half = data.bounds.mean(0), (data.bounds[1] - data.bounds[0]) / 2
        self.levels = {}
        self.rows = Rows(data.points, data.normals, data.bounds, 2 * top)
        self.surveys = [Survey(self.sides, self.half, self.mid, c) for c in CHECK[d]]
        some = np.random.default_rng(2).permutation(len(data.points))
        self.some, self.halfrows = some, None
        self.extra = None
        self.a = None
        self.its = 0

    def forget(self):
        self.extra = None

    def level(self, n):
        d = self.d
        cnt = max(33, 16 * int(np.ceil(PER[d] * n / 16)) + 1)
        if cnt not in self.levels:
            u = signs.lobatto(cnt)
            q = np.stack(np.meshgrid(*[c + h * u for c, h in zip(self.mid, self.half)], indexing='ij'), -1).reshape(-1, d)
            side, margin, dist = self.sides.nodes(q)
            self.levels[cnt] = signs.SignNodes(side.reshape((cnt,) * d), margin.reshape((cnt,) * d))
        return self.levels[cnt]

    def excess(self, D, S):
        return max(D / self.t1, (1 - S) / (1 - self.t2))

    def refine(self, G, a, ts, steps, tol):
        for t in ts:
            G.t = t
            last = t == ts[-1]
            a = G.refine(a, steps if last else 8, 1e-6, tol if last else 1e-2, 2 if last else 1, FARTOL if last else None)
            self.its += G.count
        return a

    def raise_to(self, n, steps=40, tol=1e-3):
        nodes = self.signs = self.level(n)
        m = monomials.count(self.d, n)
        size = max(SUBSET, 6 * m)
        rows = self.rows
        if len(self.some) > 1.5 * size:
            i = np.sort(self.some[:size])
            rows = Rows(self.data.points[i], self.data.normals[i], self.data.bounds, 2 * self.top)
        self.G = G = Geometric(rows, nodes, n, self.angle, extra=self.extra)
        G.top = self.top
        self.forget()
        G.extra = None
        if self.a is None:
            a = self.refine(G, np.zeros(G.m), (0, .7, .95, 1), steps, tol)
        else:
            a = self.refine(G, np.r_[self.a, np.zeros(G.m - len(self.a))], TS, steps, tol)
        self.a = a
        D, S = G.stat(G.last)
        if rows is not self.rows and self.excess(D, S) < 1.5:
            G.rows = self.rows
            G.T1, G.T2 = [t[:n + 1] for t in self.rows.tables], [t[:2 * n + 1] for t in self.rows.tables]
            self.a = a = self.refine(G, a, (1,), 15, tol)
        self.balance(G, steps)
        return self.check(G, steps, n == self.top)

    def balance(self, G, steps):
        a = self.a
        D, S = G.stat(G.last)
        best = self.excess(D, S), a, G.last, G.angle
        for _ in range(3):
            x, y = D / self.t1, (1 - S) / (1 - self.t2)
            if max(x, y) < 1 or x * y > 1.3:
                break
            G.angle = float(np.clip(G.angle * (y / x) ** 1.5, self.angle / 100, self.angle * 100))
            a = G.refine(a, 15, 1e-6, 1e-3, 2)
            self.its += G.count
            D, S = G.stat(G.last)
            if self.excess(D, S) < best[0]:
                best = self.excess(D, S), a, G.last, G.angle
            else:
                break
        self.excess_, self.best, G.last, G.angle = best

    def check(self, G, steps, final=False):
        a = self.best
        D, S = G.stat(G.last)
        history = []
        components = stray = None
        rounds = 0
        self.clean = False
        if self.excess_ < 1 or final:
            for rounds in range(ROUNDS):
                for sv in self.surveys:
                    f, components, stray, wrong, small = sv.look(a, G.n)
                    if wrong.any():
                        self.add(sv, f, wrong, small)
                        if self.added:
                            break
                else:
                    self.clean = self.excess(D, S) < 1
                    break
                G.extra = self.extra
                a = G.refine(a, 10, 1e-6, 1e-3, 2)
                self.its += G.count
                D, S = G.stat(G.last)
                if self.excess(D, S) > 1.2 and not final:
                    break
            self.best = a
        return D, S, components, stray, rounds

    def add(self, sv, f, wrong, small):
        zone = ndimage.binary_dilation(wrong, iterations=2)
        t, values = sv.u[np.argwhere(zone)], f[zone]
        d, side = self.sides.at(self.mid + self.half * t)
        side = np.where(d > self.sides.near_at, side, 0.)
        margin = np.minimum(SLOPE * np.minimum(d, .1), CLOSE)
        known = np.zeros(f.shape)
        known[zone] = side
        more = []
        for inside in (True, False):
            mine = (f < 0) == inside
            labels, count = ndimage.label(small & mine)
            if not count:
                continue
            agree = ndimage.sum_labels(known * np.sign(f), labels, np.arange(1, count + 1))
            sure = ndimage.sum_labels(known != 0, labels, np.arange(1, count + 1))
            for k in range(count):
                here = labels == k + 1
                if sure[k] == 0:
                    q = sv.u[np.argwhere(here)]
                    more.append((q, np.full(len(q), 1. if inside else -1.)))
                elif agree[k] > 0:
                    more.append(self.path(sv, here, mine & ~small, -1. if inside else 1.))
        bad = (side != 0) & (side * values < margin)
        contradicted = (side * values < 0).sum()
        t, side, margin = t[bad], side[bad], margin[bad]
        for q, sign in more:
            t, side, margin = np.concatenate([t, q]), np.r_[side, sign], np.r_[margin, np.full(len(q), .002)]
        self.added = contradicted + len(more)
        weight = (self.extra.weight if self.extra else BOOST / 3) * 3
        if self.extra:
            self.extra = self.extra.join(t.T, side, margin, weight, self.top)
        else:
            self.extra = Extra(t.T, side, margin, weight, self.top)

    def path(self, sv, here, main, sign):
        away, nearest = ndimage.distance_transform_edt(~main, return_indices=True)
        i = np.argwhere(here)
        start = i[np.argmin(away[here])]
        end = nearest[(slice(None), *start)]
        steps = max(2, int(2 * abs(end - start).max()))
        q = start + np.linspace(0, 1, steps)[:, None] * (end - start)
        q = sv.u[0] + q * (sv.u[1] - sv.u[0])
        d, side = self.sides.at(self.mid + self.half * q)
        keep = (side * sign >= 0) | (d < self.sides.near_at)
        return q[keep], np.full(keep.sum(), sign)
