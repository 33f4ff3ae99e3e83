"""What bench/PEERS.md says around its tables. It gives no number that was measured: those come from the run."""

from contest.degrees import LAYER, RIDGE
from contest.fitting import FEW, LINEAR
from contest.room import CORES, DATA

TITLE = """# Beside others

The same points and the same machine for everyone: how long it takes, how much memory, and how close it comes. Every
contender runs in a process of its own, which has its input in memory and its libraries loaded before the clock starts,
and has done the same work once on a small input. Nothing tells a library how many threads to take."""

RUN = f"""Made by `make bench`, or `python bench/peers.py`; every number is that run's. A process gets {CORES} cores and
{DATA / 1e9:.0f} GB; one that fails says why in its row. *Peak MB* is the peak of what is resident above what was before
the small work, so it holds what a library keeps for later, too. D_dist (mean distance, in mean radii) and D_smooth
(mean cosine of normals) are worked out alike for all, after the clock has stopped."""

FOLDER = "The point sets are those of the folder in IPFIT_BENCH_DATA (see bench/sets.py)."
MADE = "No folder of point sets was named: bent shapes of `ipcore.shapes` and letters stand in."

TARGETS = """## What was asked for

As the issue on speed and scale has it."""

_OPTIONS = ", ".join(f"{name}={value!r}" for name, value in LINEAR.items())

BEFORE = {
    "degrees": f"""## Every degree to {LINEAR["max_degree"]} of the same rows

3L rows of oriented points with c = {LAYER}. ipfit fits with
`{_OPTIONS}`,
which also finds D_dist and D_smooth at every degree, checks its input, and by default measures the zero set once at the
end; the others only solve. What helps them they get: normalised points; for numpy one matrix for all degrees; for
LAPACK one factorisation, in place, without Q, the right-hand side its last column. scikit-learn's Ridge has alpha =
{RIDGE:g}. *First* is the small work before, on {FEW:,} points, with all that a process does but once.""",
    "agreement": """## The error against a backward-stable solve, by degree

D_dist at every degree against that of `factor="block"`, which is Gram–Schmidt done twice: the relative difference, and
in brackets the condition of the system at that degree, its columns scaled, as `block` estimates it.""",
    "scale": """## Many points

`factor="auto"`, points of the same surface drawn again with a little random motion along it. The *further* points are
those between one size and the next: what is left when the work that does not depend on points cancels.""",
    "outlines": """## Outlines

One process fits them all. *Plain* is the linear 3L fit, *default* has no options at all.""",
    "zero_sets": """## Zero sets on fine grids

A sphere of degree 12 with random bumps, in a cube. ipfit's triangles are polished onto f = 0 and measured against
points; scikit-image's lie where linear interpolation puts them.""",
    "meshes": """## From points to a mesh

Points with normals in, a triangle mesh out, whatever is in between. *D_dist* is the mean distance of the points from
the mesh, in mean radii, *D_smooth* the mean cosine of their normals with those of the triangles there; *stray* is the
share of area far from all points.""",
    "threads": """## Threads

The fit of *Many points* with `threads=`, alone, and twice at once.""",
}
