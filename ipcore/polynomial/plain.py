"""The parts of a polynomial as plain lists and numbers, ready for JSON."""

from typing import Any

import numpy as np

from ipcore._typing import FloatArray
from ipcore.errors import InvalidPolynomialError
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.univariate import Basis

# degree, coefficients in graded order, frame, bounds, basis
Parts = tuple[int, FloatArray, Frame, FloatArray, Basis]


def write(degree: int, coefficients: FloatArray, frame: Frame, bounds: FloatArray, basis: Basis) -> dict[str, Any]:
    """Return the parts by name, with the exponents of the coefficients; `read` reads them back bit for bit."""
    return {
        "degree": degree,
        "basis": str(basis),
        "exponents": graded.exponents(len(frame.centre), degree).tolist(),
        "coefficients": coefficients.tolist(),
        "frame": {"centre": frame.centre.tolist(), "scale": frame.scale},
        "bounds": bounds.tolist(),
    }


def read(parts: dict[str, Any]) -> Parts:
    """Return the parts that `write` wrote. Exponents may stand in any order, and missing ones mean zero.

    Raises
    ------
    InvalidPolynomialError
        If a part is missing, or the exponents are not those of the coefficients.

    """
    try:
        frame = Frame(np.array(parts["frame"]["centre"], dtype=float), float(parts["frame"]["scale"]))
        degree, powers = int(parts["degree"]), np.array(parts["exponents"], dtype=np.intp)
        given, bounds = np.array(parts["coefficients"], dtype=float), np.array(parts["bounds"], dtype=float)
        kind = Basis(parts.get("basis", Basis.MONOMIAL))
    except (KeyError, TypeError, ValueError) as error:
        raise InvalidPolynomialError(f"not a polynomial: {error}") from error
    d = len(frame.centre)
    if powers.shape != (len(given), d) or powers.min() < 0 or powers.sum(axis=1).max() > degree:
        raise InvalidPolynomialError(
            f"exponents must be one row of {d} per coefficient, of total degree 0 to {degree}", ("exponents",)
        )
    a = np.zeros(graded.count(d, degree))
    np.add.at(a, graded.column(powers), given)
    return degree, a, frame, bounds, kind
