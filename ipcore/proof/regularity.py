"""Where a zero set is simple: the gradient turns by less than a right angle on a block (Plantinga and Vegter's C1).

⟨∇f(x), ∇f(y)⟩ > 0 for all x and y in the block: so ∇f does not vanish, the zero set is smooth there, and seen along one
of the axes it is a graph. The gradient is that in coordinates in which the blocks are cubes. S. Plantinga and G.
Vegter, Isotopic meshing of implicit surfaces, The Visual Computer 23 (2007), prove that where every block has it or no
zero, a mesh from the signs at the corners of the blocks has the topology of the zero set.
"""

import numpy as np

from ipcore._typing import BoolArray
from ipcore.proof.blocks import Blocks

ROUNDING = 1e-12  # of a sum of d products, relative to their sizes, and more


def is_regular(blocks: Blocks) -> BoolArray:
    """Return on which blocks ⟨∇f(x), ∇f(y)⟩ > 0 for all x and y, (B,), by bounds of each derivative.

    With bounds l and h of a derivative the product of two of its values is at least min(l², h²) if l and h have one
    sign, else l h.
    """
    low, high = (bound * blocks.size for bound in blocks.slopes())
    one_sign = (low > 0.0) | (high < 0.0)
    products = np.where(one_sign, np.minimum(np.abs(low), np.abs(high)) ** 2, low * high)
    return np.asarray(products.sum(axis=1) > ROUNDING * np.abs(products).sum(axis=1))
