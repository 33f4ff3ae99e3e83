"""The enumeration of all constraint families: the name that a caller gives, and the class that it stands for."""

from enum import StrEnum

from ipcore.constraints.family import Family
from ipcore.constraints.five_layer import FiveLayer
from ipcore.constraints.gradient_one import GradientOne
from ipcore.constraints.min_max import MinMax
from ipcore.constraints.min_var import MinVar
from ipcore.constraints.taubin import Taubin
from ipcore.constraints.three_layer import ThreeLayer
from ipcore.constraints.three_layer_gradient import ThreeLayerGradient


class Constraints(StrEnum):
    """Which equations the data give: one module of `ipcore.constraints` each, with its formula and source."""

    THREE_LAYER = "3l"
    FIVE_LAYER = "5l"
    THREE_LAYER_GRADIENT = "3l+gradient"
    GRADIENT_ONE = "gradient-one"
    MIN_MAX = "min-max"
    MIN_VAR = "min-var"
    TAUBIN = "taubin"

    @property
    def family(self) -> Family:
        """Return the family that this name stands for.

        >>> Constraints("3l").family.rows_per_point(dimension=2)
        3
        """
        return _FAMILIES[self]


_FAMILIES: dict[Constraints, Family] = {
    Constraints.THREE_LAYER: ThreeLayer(),
    Constraints.FIVE_LAYER: FiveLayer(),
    Constraints.THREE_LAYER_GRADIENT: ThreeLayerGradient(),
    Constraints.GRADIENT_ONE: GradientOne(),
    Constraints.MIN_MAX: MinMax(),
    Constraints.MIN_VAR: MinVar(),
    Constraints.TAUBIN: Taubin(),
}

# The families that are determined by moments of layers, as a phrase for messages.
LAYERED_NAMES = " and ".join(name for name in Constraints if name.family.layer_offsets(1.0))
