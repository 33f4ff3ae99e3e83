"""What a search needs of a way to fit: the polynomials of rising prefixes of columns, with what is known of each."""

from dataclasses import dataclass
from typing import Protocol

from ipcore._typing import FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial


@dataclass(frozen=True, eq=False)
class Fitted:
    """The fit with the first α columns.

    Attributes
    ----------
    polynomial
        In the normalised frame and the basis the fit works in; 0 where a column was dropped or is still to come.
    rows, columns, dropped, ridged
        The system's size: equations, coefficients in use, coefficients left out, coefficients damped.
    freedom
        Degrees of freedom.
    rss
        Residual sum of squares.
    condition, diagonal_ratio
        Estimated condition of R with columns scaled to length 1, and the paper's measure of it.
    loo
        Mean squared error at points left out; None unless asked for.
    iterations
        Steps of the nonlinear fit.
    quiet
        Whether a survey found the zero set by the data and nowhere else; None if it was not looked at.
    unsure
        Share of the box, without what is near the data, where signs could not be told; None if none were asked for.
    weights
        (N,), what each point counts, if not all the same.

    """

    polynomial: ImplicitPolynomial
    rows: int
    columns: int
    dropped: int
    ridged: int
    freedom: float
    rss: float
    condition: float
    diagonal_ratio: float
    loo: float | None
    iterations: int = 0
    quiet: bool | None = None
    unsure: float | None = None
    weights: FloatArray | None = None


class Fitter(Protocol):
    """How the polynomial of so many columns is found: what `DegreeSearch` searches with."""

    def raise_to(self, alpha: int) -> Fitted | None:
        """Return the fit with the first α columns, more than the last time; None if they cannot be told apart."""
        ...

    def orthogonality_loss(self, columns: int) -> float | None:
        """Return ‖QᵀQ − I‖₂ of the first columns that were kept; None where it is rounding by construction."""
        ...
