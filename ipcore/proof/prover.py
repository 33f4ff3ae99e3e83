"""Proves what is true of a zero set in its bounds: where it lies, that it is simple, its components and their shape.

First: no zero outside the tube about the data. Blocks of the bounds are halved until f has no zero on them or they are
wholly in the tube. Second: the blocks in the tube are halved until the zero set is simple on each of them; third: the
signs at their corners tell its topology. Each step needs the one before.
"""

import time
from dataclasses import dataclass, replace

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.proof.blocks import Blocks
from ipcore.proof.parts import Parts
from ipcore.proof.regularity import is_regular
from ipcore.proof.restriction import first_blocks
from ipcore.proof.subdivision import Question, Subdivision
from ipcore.proof.topology import topology
from ipcore.proof.tube import Tube

# The first blocks along each axis, and how often they are halved at most, to clear them and to find them simple.
PARTS = 8
CLEARING, SIMPLIFYING = 10, 10
WALL_HALVINGS = 4  # of blocks at the walls: large ones touch the walls though the zero set does not
MOST_BLOCKS = 60_000  # that are looked at: good fits need up to 25,000
MOST_UNCLEARED = 16


@dataclass(frozen=True)
class Place:
    """A ball, by its centre (d,) and its radius, in the unit of the polynomial's coordinates."""

    centre: tuple[float, ...]
    radius: float


@dataclass(frozen=True)
class Proof:
    """What has been proved of a polynomial as it is delivered, with all rounding, for its bounds.

    Attributes
    ----------
    within
        The distance within which every zero has a datum, in the caller's unit, if the proof holds; else the radius of
        the largest ball of the tube.
    holds
        Whether it has been proved that all zeros are in the tube about the data, see `tube`.
    regular
        Whether it has been proved that the zero set is smooth: ∇f does not vanish on it.
    components, euler
        The number of its components, and its Euler characteristic: 0 in the plane; in space the sum of 2 − 2 genus over
        the components. None if they have not been proved.
    boxes
        How many blocks were looked at.
    seconds
        Wall-clock time.
    uncleared
        Where zeros away from the data could not be excluded, or where the zero set could not be shown to be smooth: up
        to 16 places.

    """

    within: float
    holds: bool
    regular: bool
    components: int | None
    euler: int | None
    boxes: int
    seconds: float
    uncleared: tuple[Place, ...] = ()

    def to_raw(self, frame: Frame) -> "Proof":
        """Return the proof with lengths and places of the normalised frame in raw coordinates."""
        places = tuple(
            Place(tuple(frame.to_raw(np.array(one.centre)).tolist()), one.radius * frame.scale)
            for one in self.uncleared
        )
        return Proof(
            self.within * frame.scale, self.holds, self.regular, self.components, self.euler, self.boxes, self.seconds,
            places,
        )  # fmt: skip


def prove(polynomial: ImplicitPolynomial, points: FloatArray, scale: float = 1.0) -> Proof:
    """Return what can be proved of the zero set of a polynomial that was fitted to points (N, d).

    `scale` is their mean radius: 1 in the normalised frame, and `polynomial.frame.scale` in raw coordinates. Lengths of
    the proof are in the unit of the points.

    >>> from ipcore import shapes
    >>> torus = shapes.torus()
    >>> found = prove(torus.polynomial, torus.sample(2000)[0])
    >>> found.holds, found.regular, found.components, found.euler
    (True, True, 1, 0)
    """
    began, tube = time.perf_counter(), Tube(points, scale)
    if polynomial.degree == 0:
        slope = np.zeros(polynomial.dimension)
        polynomial = replace(polynomial, degree=1, coefficients=np.append(polynomial.coefficients, slope))
    with np.errstate(over="ignore", invalid="ignore"):  # what is not a number may be 0
        return _proved(polynomial, tube, began)


def _proved(polynomial: ImplicitPolynomial, tube: Tube, began: float) -> Proof:
    """Return the proof, begun at that time."""
    cleared = clear(polynomial, tube)
    if not cleared.complete:
        return _unproved(cleared, tube, began)
    simple = SIMPLE.ask(polynomial, cleared.settled)
    found = topology(polynomial, simple.settled) if simple.complete else None
    return Proof(
        max([tube.reach(blocks) for blocks in simple.settled + simple.left], default=0.0),
        holds=True,
        regular=simple.complete,
        components=None if found is None else found.components,
        euler=None if found is None else found.euler,
        boxes=cleared.looked_at + simple.looked_at,
        seconds=time.perf_counter() - began,
        uncleared=_places(simple.left),
    )


def clear(polynomial: ImplicitPolynomial, tube: Tube) -> Subdivision:
    """Return the blocks that may have zeros: settled if they are in the tube, left if they could not be cleared."""

    def is_hopeless(blocks: Blocks) -> BoolArray:
        """Return the blocks in which there is a zero away from the data."""
        return blocks.vanish() & tube.misses(blocks)

    near = Question(tube.holds, is_hopeless, CLEARING, MOST_BLOCKS)
    return near.ask(polynomial, [first_blocks(polynomial, PARTS)])


def _is_simple(blocks: Blocks) -> BoolArray:
    """Return the blocks on which the zero set is simple, and at the walls only small ones, (B,)."""
    simple = is_regular(blocks)
    return simple if blocks.halvings >= WALL_HALVINGS else simple & ~blocks.touch_walls()


def _never(blocks: Blocks) -> BoolArray:
    """Return that smaller blocks may settle it, (B,)."""
    return np.zeros(len(blocks), dtype=np.bool_)


SIMPLE = Question(_is_simple, _never, SIMPLIFYING, MOST_BLOCKS)


def _places(left: list[Blocks]) -> tuple[Place, ...]:
    """Return balls that cover blocks, those that touch each other together; of many the largest."""
    if not left:
        return ()
    parts = Parts.of(left, len(left[0].size))
    largest = np.argsort(-parts.radius, kind="stable")[:MOST_UNCLEARED]
    return tuple(Place(tuple(parts.centre[k].tolist()), float(parts.radius[k])) for k in largest)


def _unproved(cleared: Subdivision, tube: Tube, began: float) -> Proof:
    """Return that nothing has been proved, and where zeros could not be excluded."""
    seconds = time.perf_counter() - began
    return Proof(
        tube.radius, holds=False, regular=False, components=None, euler=None, boxes=cleared.looked_at, seconds=seconds,
        uncleared=_places(cleared.left),
    )  # fmt: skip
