"""`ipfit fit`: fit the points of a file in this process, without a server."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import orjson
import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

import ipcore
from service.cli.options import with_fit_options
from service.cli.point_files import MAX_POINTS, ColumnsOption, MissingOption
from service.formats.picture import page
from service.formats.points import by_ending, decode
from service.formats.zero_set.writers import WRITERS
from service.jobs.errors import InvalidInputError
from service.jobs.fit import ReceivedPoints
from service.jobs.media_types import zero_set_formats


def _endings(dimension: int) -> str:
    """Return the endings of the zero-set files of this dimension, for a help text."""
    return " ".join(f".{known.name}" for known in zero_set_formats(dimension))


@with_fit_options
def fit(  # noqa: PLR0913, PLR0917 - one option each
    file: Annotated[
        Path, typer.Argument(exists=True, dir_okay=False, help=f"Points, as one of {', '.join(by_ending.ENDINGS)}.")
    ],
    mesh: Annotated[
        Path | None, typer.Option(help=f"Write the zero set here: {_endings(3)} in 3D, {_endings(2)} in 2D.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Write a picture of the fit and its trace here, as SVG.")] = None,
    output: Annotated[Path | None, typer.Option(help="Write the whole result here, as JSON.")] = None,
    resolution: Annotated[
        int | None,
        typer.Option(help="Grid points along the longest axis, for --mesh; by default chosen by the thickness."),
    ] = None,
    columns: ColumnsOption = None,
    missing: MissingOption = "refuse",
    *,
    options: ipcore.FitOptions,
) -> None:
    """Fit the points of FILE and say what came out."""
    try:
        given = by_ending.read_file(file, MAX_POINTS, columns=columns, missing=missing)
        targets = {"mesh": mesh, "plot": plot, "output": output}
        _run(file, given, options, targets, resolution)
    except (InvalidInputError, ipcore.IPCoreError, OSError) as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error


def _run(
    file: Path,
    given: ReceivedPoints,
    options: ipcore.FitOptions,
    targets: dict[str, Path | None],
    resolution: int | None,
) -> None:
    writer = _mesh_writer(targets["mesh"], given.dimension)  # a wrong ending is reported before the work
    points, normals = decode.split(given.content, given.dimension)
    checked = given.summary.restored(points, normals)
    with _bar(options.degree_cap(given.dimension)) as show:
        result = ipcore.fit(checked, options=options, progress=show)
    _summarise(file, given, result)
    if targets["mesh"] is not None and writer is not None:
        zero_set = ipcore.zero_set(result.polynomial, resolution=resolution, data=points)
        _write(targets["mesh"], writer(zero_set))
        if zero_set.warning is not None:
            typer.echo(f"warning: {zero_set.warning}")
    if targets["plot"] is not None:
        _write(targets["plot"], page.plot(result, points))
    if targets["output"] is not None:
        _write(targets["output"], orjson.dumps(result.to_dict(), option=orjson.OPT_INDENT_2))


def _mesh_writer(path: Path | None, dimension: int) -> Callable[[ipcore.ZeroSet], bytes] | None:
    """Return the writer of zero sets of this dimension for the ending of a path; None without a path."""
    if path is None:
        return None
    known = [one.name for one in zero_set_formats(dimension)]
    if path.suffix[1:].lower() not in known:
        raise InvalidInputError(
            f"--mesh of a {dimension}D fit must end in one of {', '.join(known)}, not {path.suffix!r}"
        )
    return WRITERS[path.suffix[1:].lower()]


@contextmanager
def _bar(last: int) -> Iterator[Callable[[ipcore.Step], None]]:
    """Yield a callable that shows each step in a progress bar; `last` is the last degree."""
    columns = (
        TextColumn("degree {task.completed:>2.0f} of at most {task.total:.0f}"),
        BarColumn(),
        TextColumn("{task.fields[closeness]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as progress:
        bar = progress.add_task("fit", total=last, closeness="")

        def show(step: ipcore.Step) -> None:
            closeness = f"D_dist {step.d_dist:.4f}  D_smooth {step.d_smooth:.4f}"
            progress.update(bar, completed=step.degree, closeness=closeness)

        yield show


def _summarise(file: Path, given: ReceivedPoints, result: ipcore.FitResult) -> None:
    found = result.diagnostics
    typer.echo(f"{file.name}: {given.points} points in {given.dimension}D, normals {found.normal_source}")
    typer.echo(
        f"degree {result.degree}, {len(result.polynomial.coefficients)} coefficients, stopped: {result.stop_reason}"
    )
    typer.echo(f"D_dist {found.d_dist:.4f} mean radii, D_smooth {found.d_smooth:.4f}")
    if found.components == 0:
        typer.echo("zero set: there is none within the bounds")
    elif found.stray is not None:
        typer.echo(f"zero set: {found.components} components, {found.stray:.2%} of it away from the data")
    for warning in result.warnings:
        typer.echo(f"warning: {warning}")


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    typer.echo(f"wrote {path} ({len(content)} bytes)")
