"""The text of bench/PEERS.md around its tables. It has no measured number: those come from the run."""

from contest.degrees import LAYER, RIDGE
from contest.fitting import FEW, LINEAR
from contest.resources import CORES, MEMORY

TITLE = """# ipfit beside other libraries

All contenders get the same points on the same machine. The tables say how long each takes, how much memory it
needs, and how close its result is. Every contender runs in a process of its own. Before the clock starts, its input
is in memory, its libraries are imported, and it has done the same work once on a small input. No library is told
how many threads to use."""

RUN = f"""Made by `make bench`, or `python bench/peers.py`; every number comes from that run. A process gets {CORES}
cores and {MEMORY / 1e9:.0f} GB; if it fails, its row has the error. *Peak MB* is the peak of the resident memory
above that before the small work, so it includes what a library keeps for later. D_dist (mean distance, in mean
radii) and D_smooth (mean cosine of normals) are computed in the same way for all, after the clock has stopped."""

FOLDER = "The point sets are those of the folder in IPFIT_BENCH_DATA (see bench/sets.py)."
MADE = "IPFIT_BENCH_DATA named no folder, so the point sets are bent shapes of `ipcore.shapes`, and letters."

TARGETS = """## Targets

From the issue on speed and scale."""

_OPTIONS = ", ".join(f"{name}={value!r}" for name, value in LINEAR.items())

BEFORE = {
    "degrees": f"""## Every degree up to {LINEAR["max_degree"]} of the same rows

3L rows of oriented points with c = {LAYER}. ipfit fits with
`{_OPTIONS}`.
It also computes D_dist and D_smooth at every degree, checks its input, and by default measures the zero set once at
the end; the others only solve. The others are given every advantage: normalised points; for numpy one matrix for
all degrees; for LAPACK one factorisation, in place, without Q, with the right-hand side as its last column.
scikit-learn's Ridge has alpha = {RIDGE:g}. *First* is the small work before, on {FEW:,} points, with the one-time
costs of a process.""",
    "agreement": """## The difference from a backward-stable solve, by degree

D_dist at every degree compared with that of `factor="block"`, which is Gram–Schmidt done twice: the relative
difference, and in brackets the condition of the system at that degree, its columns scaled, as `block` estimates
it.""",
    "scale": """## Many points

`factor="auto"`, points of the same surface, drawn again with a small random motion along it. The *further* points are
those between one size and the next: in this difference the work that does not depend on the points cancels.""",
    "outlines": """## Outlines

One process fits all of them. *Plain* is the linear 3L fit; *default* is the fit without any options.""",
    "zero_sets": """## Zero sets on fine grids

A sphere of degree 12 with random bumps, in a cube. ipfit moves its vertices onto f = 0 and measures them against
points; the vertices of scikit-image lie where linear interpolation puts them.""",
    "meshes": """## From points to a mesh

The input is points with normals, the result is a triangle mesh. *D_dist* is the mean distance of the points from
the mesh, in mean radii; *D_smooth* is the mean cosine between their normals and those of the triangles there;
*stray* is the share of the area that is far from all points.""",
    "threads": """## Threads

The fit of *Many points* with `threads=`, in one process, and in two processes at the same time.""",
}
