"""The fits that predictions.py predicts and measures."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

NOISE = 0.03  # standard deviation, in mean radii: three times t1, so that no degree is close enough


@dataclass(frozen=True)
class Case:
    """A fit to predict and to measure.

    Attributes
    ----------
    group
        The part of the prediction that it is about.
    dimension, points
        d and N.
    options
        Options by name.
    normals
        `given`, `estimated`, or `outline` for 2D points in order along their curve.
    noise
        Standard deviation of the points along their normals, in mean radii.
    calibrates
        Whether the constants of `ipcore.planning` were fitted to it.

    """

    group: str
    dimension: int
    points: int
    options: dict[str, Any] = field(default_factory=dict)
    normals: str = "given"
    noise: float = NOISE
    calibrates: bool = False

    @property
    def title(self) -> str:
        """Return dimension, number of points and options in words."""
        chosen = ", ".join(f"{name}={value}" for name, value in self.options.items())
        source = "" if self.normals == "given" else f", normals {self.normals}"
        return f"{self.dimension}D, {self.points:,} points{source}: {chosen}"


def _grouped(
    group: str, cases: list[tuple[int, int, dict[str, Any]]], normals: str = "given", noise: float = NOISE
) -> Iterator[Case]:
    """Yield the cases of a group; every other one calibrates."""
    for i, (dimension, points, options) in enumerate(cases):
        yield Case(group, dimension, points, options, normals, noise, calibrates=i % 2 == 0 and noise > 0.0)


def _degrees(*cases: tuple[int, int, int], **options: Any) -> list[tuple[int, int, dict[str, Any]]]:  # noqa: ANN401 - any
    """Return cases (dimension, points, max_degree) that share the other options."""
    return [(dimension, points, {"max_degree": degree, **options}) for dimension, points, degree in cases]


GEOMETRIC = [
    *_degrees(
        *[(3, 100, 4), (3, 1000, 6), (3, 1000, 9), (3, 3000, 11), (3, 10_000, 6), (3, 10_000, 8), (3, 100_000, 7)],
        *[(3, 100_000, 5), (3, 1_000_000, 4), (3, 400_000, 4), (2, 100, 8), (2, 1000, 10), (2, 10_000, 14)],
        *[(2, 100_000, 12), (2, 1000, 20), (2, 1_000_000, 6)],
    ),
    *_degrees((2, 5000, 24), (2, 3000, 16), (2, 400_000, 8), (3, 20_000, 5), criterion="none"),
    *_degrees((2, 1000, 6), (2, 3000, 18), (3, 3000, 7), (3, 3000, 8), t1=0.003),
]
LINEAR = _degrees(
    *[(3, 1000, 8), (3, 5000, 6), (3, 20_000, 10), (3, 100_000, 7), (3, 400_000, 5), (3, 20_000, 14), (3, 5000, 15)],
    *[(3, 1_000_000, 4), (2, 100_000, 12), (2, 1000, 10), (2, 1_000_000, 8), (2, 10_000, 14), (2, 100_000, 18)],
    *[(2, 20_000, 20), (3, 50_000, 16), (3, 200_000, 10)],
    geometric=False,
)
HELD = [
    *_degrees(
        (3, 5000, 9), (3, 20_000, 7), (2, 5000, 16), (2, 50_000, 10), (3, 20_000, 11), (3, 5000, 13), factor="block"
    ),
    *_degrees((3, 5000, 7), (2, 10_000, 12), constraints="min-max"),
    *_degrees((3, 5000, 7), (2, 10_000, 10), constraints="taubin"),
    *_degrees((2, 5000, 10), (3, 3000, 6), criterion="loo"),
    *_degrees((3, 20_000, 8), (2, 50_000, 14), (3, 20_000, 13), (3, 5000, 15), factor="tsqr"),
    *_degrees((3, 20_000, 8), (2, 50_000, 14), (3, 10_000, 12), (2, 20_000, 20), constraints="3l+gradient"),
    *_degrees((3, 50_000, 8), (2, 50_000, 14), constraints="5l"),
]
PAPER = _degrees(
    (3, 500, 5),
    (3, 3000, 6),
    (2, 500, 10),
    (2, 3000, 12),
    (3, 1000, 8),
    (2, 10_000, 9),
    (3, 2000, 10),
    (2, 2000, 20),
    preset="paper",
)
ROBUST = _degrees(
    (3, 1000, 6), (3, 20_000, 6), (3, 200_000, 4), (2, 1000, 12), (2, 20_000, 10), (2, 200_000, 8), robust=True
)
SIGNS = _degrees((3, 10_000, 6), (3, 2000, 8), (2, 2000, 16), (2, 10_000, 12), signs=True, geometric=False)
ESTIMATED = [
    (dimension, points, {"max_degree": 2, "geometric": False, "neighbours": neighbours})
    for dimension, points, neighbours in [
        *[(3, 1000, 12), (3, 10_000, 12), (3, 10_000, 100), (3, 30_000, 50), (3, 100_000, 12), (3, 300_000, 12)],
        *[(3, 100_000, 100), (2, 1000, 12), (2, 10_000, 12), (2, 10_000, 100), (2, 100_000, 30), (2, 100_000, 12)],
    ]
]
OUTLINES = [(2, points, {"max_degree": 2, "geometric": False}) for points in (1000, 10_000, 100_000)]
CLEAN = [(2, 1000, {}), (2, 100_000, {}), (3, 1000, {}), (3, 20_000, {}), (3, 20_000, {"geometric": False})]
CASES = (
    *_grouped("geometric", GEOMETRIC),
    *_grouped("linear", LINEAR),
    *_grouped("other factors and families", HELD),
    *_grouped("paper", PAPER),
    *_grouped("robust", ROBUST),
    *_grouped("signs only", SIGNS),
    *_grouped("estimated normals", ESTIMATED, "estimated"),
    *_grouped("outlines", OUTLINES, "outline", noise=0.0),
    *_grouped("clean, stops early", CLEAN, noise=0.0),
)
