"""The errors of ipcore. Invalid input raises one; a numerical outcome is a `StopReason` of the result instead."""


class IPCoreError(Exception):
    """The base of all errors that ipcore raises itself.

    Parameters
    ----------
    message
        What is wrong, and where, in one sentence.
    at
        The place in the caller's input, outermost first: `("points", 17, 1)` is column 1 of row 17 of `points`.

    """

    def __init__(self, message: str, at: tuple[str | int, ...] = ()) -> None:
        """Store the message and the place."""
        super().__init__(message)
        self.message = message
        self.at = at

    def __reduce__(self) -> tuple[type["IPCoreError"], tuple[str, tuple[str | int, ...]]]:
        """Pickle with both arguments, so that an error can be sent from a worker process."""
        return type(self), (self.message, self.at)


class InvalidPointsError(IPCoreError):
    """The points cannot be fitted: wrong shape, not finite, too few, all equal or on a line."""


class InvalidNormalsError(IPCoreError):
    """The normals do not fit the points: another shape, not finite, or of zero length."""


class InvalidOptionsError(IPCoreError):
    """An option has a value that is not allowed, alone or together with another option."""


class InvalidPolynomialError(IPCoreError):
    """Coefficients, exponents, frame or bounds do not make a polynomial."""
