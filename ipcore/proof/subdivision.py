"""Blocks halved until something is settled on each of them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ipcore._typing import BoolArray
from ipcore.proof.blocks import Blocks

# With a hopeless block the whole is not settled: how often the others are halved then, to say where else it is not.
FEW_HALVINGS = 4
Judgement = Callable[[Blocks], BoolArray]


@dataclass(frozen=True, eq=False)
class Subdivision:
    """What has become of blocks. Those on which f has no zero are gone.

    Attributes
    ----------
    settled
        Blocks that may have zeros, and on which the question is settled.
    left
        Blocks that may have zeros, and on which it is not: they were hopeless, as small as wanted, or too many.
    looked_at
        The number of all blocks that were looked at.

    """

    settled: list[Blocks]
    left: list[Blocks]
    looked_at: int

    @property
    def complete(self) -> bool:
        """Return whether nothing is left."""
        return not self.left


def subdivided(
    first: Iterable[Blocks], is_settled: Judgement, is_hopeless: Judgement | None, halvings: int, most: int
) -> Subdivision:
    """Halve blocks until f has no zero on them, or they are settled, or hopeless.

    Parameters
    ----------
    first
        The blocks to begin with.
    is_settled, is_hopeless
        Return for which of given blocks (B,) the question is settled, and for which smaller ones would not settle it.
    halvings
        Blocks that have been halved so often are left.
    most
        When so many blocks have been looked at, the others are left.

    """
    settled, left, looked_at = list[Blocks](), list[Blocks](), 0
    waiting = [chunk for blocks in first for chunk in blocks.chunks()]
    while waiting:
        blocks = waiting.pop()
        looked_at += len(blocks)
        blocks = blocks[blocks.may_vanish()]
        done = is_settled(blocks) if len(blocks) else np.zeros(0, dtype=np.bool_)
        settled.append(blocks[done])
        blocks = blocks[~done]
        if is_hopeless is not None and len(blocks):
            hopeless = is_hopeless(blocks)
            left.append(blocks[hopeless])
            blocks = blocks[~hopeless]
            if hopeless.any():
                halvings = min(halvings, FEW_HALVINGS)
        if blocks.halvings >= halvings or looked_at > most:
            left.append(blocks)
        elif len(blocks):
            waiting += blocks.halved().chunks()
    return Subdivision(_some(settled), _some(left), looked_at)


def _some(blocks: list[Blocks]) -> list[Blocks]:
    """Return those that are not empty."""
    return [one for one in blocks if len(one)]
