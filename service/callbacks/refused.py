"""What stands in for the rules of callbacks where none can be sent."""

from service.jobs.errors import InvalidInputError


class NoCallbacks:
    """Refuses every callback: there is no secret to sign it with."""

    def check(self, url: str) -> None:  # noqa: ARG002 - the port's signature
        """Refuse a callback.

        Raises
        ------
        InvalidInputError
            Always.

        """
        raise InvalidInputError(
            "this server sends no callbacks: its operator has not set IPFIT_CALLBACK_SECRET", ("callback",)
        )
