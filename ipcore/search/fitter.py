"""The interface between the search and the methods of fitting: fits with growing prefixes of the columns of M."""

from dataclasses import dataclass
from typing import Protocol

from ipcore._typing import FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial


@dataclass(frozen=True, eq=False)
class PrefixFit:
    """The fit with the first α columns of M, as a method of fitting returns it.

    Attributes
    ----------
    polynomial
        The fit, in the normalised frame and the basis of the method. Coefficients whose columns were dropped, or are
        not yet appended, are 0.
    rows, columns, dropped, ridged
        How many equations, coefficients in use, coefficients left out, and coefficients damped there are.
    degrees_of_freedom
        The trace of the matrix that takes b to M a.
    rss
        Residual sum of squares.
    condition, diagonal_ratio
        Estimated condition of R with columns scaled to length 1, and max |r_ii| / min |r_ii|, the paper's measure.
    loo
        Mean squared error at points left out one by one; None unless it is the criterion.
    iterations
        Iterations of a nonlinear fit; 0 if it is linear.
    quiet
        Whether the checks of `geometric.exchange` found the zero set near the data only, and whole; None if it was not
        checked.
    unsure
        Share of the box, without what is near the data, where the data do not tell inside from outside; None without
        sign constraints.
    weights
        (N,), the weights of the points in the fit; None if all are 1.

    """

    polynomial: ImplicitPolynomial
    rows: int
    columns: int
    dropped: int
    ridged: int
    degrees_of_freedom: float
    rss: float
    condition: float
    diagonal_ratio: float
    loo: float | None
    iterations: int = 0
    quiet: bool | None = None
    unsure: float | None = None
    weights: FloatArray | None = None


class Fitter(Protocol):
    """A method of fitting, with which `DegreeSearch` searches."""

    def raise_to(self, alpha: int) -> PrefixFit | None:
        """Return the fit with the first α columns, more than at the last call; None if they are not determined."""
        ...

    def orthogonality_loss(self, columns: int) -> float | None:
        """Return ‖QᵀQ − I‖₂ of the first columns that were kept; None for methods that keep it at rounding."""
        ...
