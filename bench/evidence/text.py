"""The text of bench/PAPER.md around its tables and figures. It gives no number that is not in a table."""

TITLE = """# The paper's evidence, on real data

Zheng, Takamatsu and Ikeuchi, *Adaptively Determining Degrees of Implicit Polynomial Curves and Surfaces* (ACCV
2007), show five things. Each is repeated here on other outlines and surfaces, with the paper's c = 0.05, T1 =
0.01, T2 = 0.95. In addition the tables show *stray*: the share of the zero set that lies away from all
data, within the data's box grown by 0.3 mean radii. Lengths are in mean radii. Surfaces of more than
4,000 points are sampled. The search ends at degree 18 in 2D and 12 in 3D. The fits are the linear ones of the paper
and of related methods, except for one row of the last table."""

BEFORE = {
    "growth": """## 1. D_dist and D_smooth as columns are added (Fig. 3)

`preset="paper"`: one column after another in Table 1's order, eq. (5), ridge of eq. (8) with κ = 1e-10. Beside it is
the same search with the block factorisation that is done twice. α is the number of columns at the fit that was
returned.""",
    "adaptive": """## 2. The degree follows the shape (Fig. 4)

The adaptive 3L fit, by whole forms, stopping by (7). Blue lies at the data, red away from it.""",
    "families": """## 3. Fixed degrees against the adaptive one, for every family (Fig. 5)

Degree 2, degree 4, and the degree that the search finds. Marks as in the paper: * moderate, † insufficient, ‡
higher than needed.""",
    "instability": """## 4. Over-fitting, ridge, and selective ridge (Fig. 1)

A degree that is too high, and the effect of ridge regression on it: applied to all columns, with the appendix's D
or with the identity, or only to those columns of which less than 1e-3 is new.""",
    "cost": """## 5. What the increment saves

All fits up to a degree, by four methods. Only the solves are timed, each on one thread and with the same matrix:
LAPACK's pivoted QR from scratch for every column, or from scratch for every complete degree; eq. (5) column by
column; block Gram–Schmidt done twice, form by form, which is this library's own. Medians of three runs.""",
    "noise": """## 6. Which criterion to use when

Points moved by Gaussian noise σ in every coordinate, normals as they were, 1,500 points at most. The *true error*
is the mean distance of the points as they were from the fit. *The best degree* is the least error of any degree,
which cannot be known from the noisy points alone. *At the cap* counts the searches that ended because there was no
higher degree. *Geometric* is the default fit of this library; bench/QUALITY.md is about it.""",
}

AFTER = {
    "growth": """*Agrees:* with a stable factorisation D_dist goes to 0 and D_smooth to 1, with small fluctuations,
and the search may stop in the middle of a form. *Does not:* the paper calls the effect of rounding in eq. (5)
small. It is not: beyond some forty columns Q is no longer orthogonal, D_smooth falls again, and shapes that need a
high degree never meet (7). The number of columns α is not a property of the shape alone: it changes when the data are
rotated.""",
    "adaptive": """*Agrees:* simple shapes stop at low degrees, complicated ones at high ones, and most do stop by
(7). *Does not:* where the degree is above 4 the zero set has large parts away from all data, on every shape.
"Neither over-fitting nor insufficient fitting" is true at the data only, because (7) measures nothing elsewhere.
Shapes with thin parts and sharp corners (the apple's stalk, the duck, the blade) never meet it.""",
    "families": """*Agrees:* a fixed degree is insufficient for most shapes and too high for a few. The adaptive
degree suits each. *Beyond the paper:* families with gradient rows meet (7) a little more often than 3L, and at
about the same degree; Gradient-One needs the fewest rows. Min-Max and Min-Var ask for gradients of a length that
varies along the shape, which makes the fits less close; they were made for stable zero sets at fixed degrees, and
have fewer stray parts. Taubin's fit is exact for algebraic shapes without noise, and fails on others beyond about
degree 4, because no equation fixes the sign of f beside the data. No family is free of stray zero sets.""",
    "instability": """*Agrees:* ridge regression removes stray zero sets at a high degree, and accuracy suffers. *Does
not:* it suffers so much that no κ here is both close (D_dist < 0.01) and free of stray parts; a thin
shape falls to pieces before the stray parts are gone. The selective ridge keeps the accuracy, and most of the
stray parts. max/min rᵢᵢ, by which the paper estimates the condition, can be orders of magnitude below the estimated
condition.""",
    "cost": """*Agrees:* the incremental solve is far cheaper than solving from scratch for every column. *Beyond
the paper:* solving from scratch at complete degrees only, which is all that a rotation-invariant search needs, is
already nearly as cheap, because a blocked solver uses the processor better. In 3D, column by column in one pass
costs less than form by form in two, and loses orthogonality.""",
    "noise": """**Which criterion to take.** Clean points, such as most scans of solid objects: `distance`, which
takes the lowest degree that is close enough; on clean points all other criteria go on to high degrees for a small
gain. Known noise above 0.01: `distance` with t1 = σ, which needs lower degrees, for an error up to half larger than
the least one. Unknown noise: `gcv`, whose error is within a sixth of that of the best degree from σ = 0.01 on, at
no extra cost, but whose degrees are not lower. `bic` and `loo` take lower degrees, with larger errors in 3D; `loo`
also takes time. `none` is for a degree that you know. The geometric fit with t1 = σ needs lower degrees, is nearer
the truth on noisy surfaces than the best linear degree, and hardly any of its zero sets strays. Whatever the
criterion, the best fit so far is returned at the cap, with the reason.""",
}
