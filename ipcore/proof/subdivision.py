"""Blocks halved until something is settled on each of them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ipcore._typing import BoolArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.proof.blocks import LEFT_OUT, Blocks
from ipcore.proof.restriction import restricted

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
        Blocks that may have zeros, and on which it is not: they were hopeless, as small as wanted, or too many. Without
        coefficients.
    looked_at
        The number of all blocks that were looked at.
    hopeless
        Whether one of those that are left is: smaller blocks would not settle it.

    """

    settled: list[Blocks]
    left: list[Blocks]
    looked_at: int
    hopeless: bool

    @property
    def complete(self) -> bool:
        """Return whether nothing is left."""
        return not self.left


@dataclass(frozen=True)
class Question:
    """What is to be settled on blocks, and with how much effort.

    Attributes
    ----------
    is_settled, is_hopeless
        Return for which of given blocks (B,) it is settled, and for which no smaller ones would settle it.
    halvings
        Blocks that have been halved so often are left.
    most
        When so many blocks have been looked at, the others are left.

    """

    is_settled: Judgement
    is_hopeless: Judgement
    halvings: int
    most: int

    def ask(self, polynomial: ImplicitPolynomial, first: Iterable[Blocks]) -> Subdivision:
        """Halve blocks, from the first ones on, until f has no zero on them, or they are settled, or left."""
        settled, left, looked_at, none_hopeless = list[Blocks](), list[Blocks](), 0, True
        for some in first:
            blocks = some
            while len(blocks):
                looked_at += len(blocks)
                done, hopeless, rest = self._judged(blocks[blocks.may_vanish()])
                settled.append(done)
                left.append(hopeless.without_coefficients())
                none_hopeless &= not len(hopeless)
                halvings = self.halvings if none_hopeless else min(self.halvings, FEW_HALVINGS)
                if not len(rest) or rest.halvings >= halvings or looked_at > self.most:
                    left.append(rest.without_coefficients())
                    break
                blocks = halved(polynomial, rest)
        return Subdivision(_some(settled), _some(left), looked_at, not none_hopeless)

    def _judged(self, blocks: Blocks) -> tuple[Blocks, Blocks, Blocks]:
        """Return the blocks on which the question is settled, those that are hopeless, and the others."""
        done = self.is_settled(blocks)
        rest = blocks[~done]
        hopeless = self.is_hopeless(rest)
        return blocks[done], rest[hopeless], rest[~hopeless]


def halved(polynomial: ImplicitPolynomial, blocks: Blocks) -> Blocks:
    """Return the parts of blocks that may have a zero, their coefficients computed afresh where the slack is large."""
    blocks = blocks.reduced(LEFT_OUT)
    parts = Blocks.together([chunk.halved() for chunk in blocks.chunks()])
    stale = parts.is_stale()
    if not stale.any():
        return parts
    return Blocks.together([parts[~stale], restricted(polynomial, parts[stale]).up_to(parts.degree)])


def _some(blocks: list[Blocks]) -> list[Blocks]:
    """Return those that are not empty."""
    return [one for one in blocks if len(one)]
