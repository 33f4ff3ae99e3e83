"""What the commands that read a file of points have in common."""

from typing import Annotated

import typer

from service.jobs.media_types import Missing

MAX_POINTS = 10_000_000

ColumnsOption = Annotated[
    str | None, typer.Option(help="What the columns of a table hold, in order: x,y,z,nx,ny,nz; _ ignores one.")
]
MissingOption = Annotated[Missing, typer.Option(help="Whether a point with a missing value is refused or left out.")]
