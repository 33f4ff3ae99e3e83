"""The use cases that make files of fits: their zero sets, and their points."""

from collections.abc import Awaitable

from service.jobs.caller import Caller
from service.jobs.errors import FitNotFinishedError, FitWithoutResultError, NotReadyError
from service.jobs.exported_file import ExportedFile
from service.jobs.fit import Fit
from service.jobs.mesh_request import MeshRequest
from service.jobs.ports import Exports
from service.jobs.use_cases import FitService


class FitFiles:
    """Files of fits that a caller has looked up."""

    def __init__(self, fits: FitService, exports: Exports) -> None:
        """Make files by these exports."""
        self._fits, self._exports = fits, exports

    def zero_set_name(self, fit: Fit, wanted: MeshRequest) -> str:
        """Return the name of the file of a zero set: the same for the same polynomial, request and version.

        Raises
        ------
        FitNotFinishedError, FitWithoutResultError
            If the fit has no result yet, or will never have one.

        """
        return self._exports.zero_set_name(_result(fit), fit.input, wanted)

    async def zero_set(
        self, caller: Caller, fit: Fit, wanted: MeshRequest, encoding: str | None = None
    ) -> ExportedFile:
        """Return the file of the zero set of a successful fit, compressed if `encoding` is given.

        Raises
        ------
        FitNotFinishedError, FitWithoutResultError
            If the fit has no result yet, or will never have one.
        FitNotFoundError
            If it was removed meanwhile.

        """
        export = self._exports.zero_set(_result(fit), fit.input, wanted, encoding, caller.client)
        return await self._exported(caller, fit, export)

    async def points(self, caller: Caller, fit: Fit, form: str, encoding: str | None = None) -> ExportedFile:
        """Return the points of a fit as a file of this format, compressed if `encoding` is given.

        Raises
        ------
        FitNotFoundError
            If it was removed meanwhile.

        """
        return await self._exported(caller, fit, self._exports.points(fit.input, form, encoding, caller.client))

    async def _exported(self, caller: Caller, fit: Fit, export: Awaitable[ExportedFile]) -> ExportedFile:
        try:
            return await export
        except NotReadyError:
            await self._fits.get(caller, fit.id)  # raises FitNotFoundError if the fit was removed in this moment
            raise


def _result(fit: Fit) -> bytes:
    if not fit.status.final:
        raise FitNotFinishedError(f"fit {fit.id} is {fit.status}; its zero set can be had when it is successful")
    if fit.result is None:
        raise FitWithoutResultError(f"fit {fit.id} is {fit.status} and has no zero set")
    return fit.result
