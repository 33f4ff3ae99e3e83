"""Which way to fit the options ask for."""

from ipcore.choices import Constraints, Factor
from ipcore.compressed import CompressedFit
from ipcore.linear import LeastSquaresFit, TaubinFit
from ipcore.options import FitOptions
from ipcore.oriented import OrientedPoints
from ipcore.prefix import PrefixFit
from ipcore.quiet import QuietFit
from ipcore.rowsource import DataRows


def way(data: OrientedPoints, options: FitOptions, top: int) -> PrefixFit:
    """Return the way to fit, up to the degree `top`."""
    if options.is_linear or data.planar:
        return linear(data, options, top)
    return QuietFit(data if options.robust else data.thinned, options, top)


def linear(data: OrientedPoints, options: FitOptions, top: int) -> PrefixFit:
    """Return the linear way."""
    if options.constraints is Constraints.TAUBIN:
        return TaubinFit(data, options, top)
    if options.factor in {Factor.BLOCK, Factor.GRAM_SCHMIDT} or options.needs_rows:
        return LeastSquaresFit(data, options, top)
    return CompressedFit(data, options, top, DataRows(data, options))
