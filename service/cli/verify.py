"""`ipfit verify`: check the proof of an answer by other means than those that found it."""

from pathlib import Path
from typing import Annotated

import typer

from service.cli import claimed
from service.cli.point_files import MAX_POINTS, ColumnsOption, MissingOption
from service.formats.points import by_ending, decode
from service.jobs.errors import InvalidInputError


def verify(
    result: Annotated[
        Path,
        typer.Argument(exists=True, dir_okay=False, help="The answer, as `ipfit fit --output` or the server wrote it."),
    ],
    points: Annotated[
        Path, typer.Argument(exists=True, dir_okay=False, help=f"The points, as one of {', '.join(by_ending.ENDINGS)}.")
    ],
    columns: ColumnsOption = None,
    missing: MissingOption = "refuse",
) -> None:
    """Check the proof in RESULT with ball arithmetic: where the zero set lies, and that it is smooth."""
    try:
        from service.cli.verification import Claims, UnverifiedError  # noqa: PLC0415 - needs an extra
    except ModuleNotFoundError as error:
        typer.echo('error: this needs python-flint: pip install "ipfit[verify]"', err=True)
        raise typer.Exit(2) from error
    try:
        polynomial, proof = claimed.read(result.read_bytes())
        given = by_ending.read_file(points, MAX_POINTS, columns=columns, missing=missing)
        claimed.check_dimension(polynomial, given.dimension)
    except (InvalidInputError, OSError) as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error
    claims = Claims(polynomial, decode.split(given.content, given.dimension)[0], proof.within)
    try:
        boxes = claims.verify_within()
        typer.echo(f"every zero in the bounds has a point within {proof.within:.6g}: verified on {boxes} boxes")
        if proof.regular:
            typer.echo(f"the zero set is smooth: verified on {claims.verify_regular()} boxes")
    except UnverifiedError as error:
        typer.echo(f"not verified: {error}", err=True)
        raise typer.Exit(1) from error
