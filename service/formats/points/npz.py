"""Point sets as npz: arrays `points` and perhaps `normals`; or one array of any name, as in an npy file."""

import zlib
from io import BytesIO
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile

from service.formats.points import columns, npy
from service.formats.points.reading import Array, RawPoints, ReadOptions, shortened
from service.jobs.errors import InvalidInputError, MalformedInputError, TooLargeError

# What the standard library raises on an archive that is broken, encrypted, or packed as it does not know.
NOT_NPZ = (BadZipFile, zlib.error, NotImplementedError, RuntimeError, ValueError, EOFError, OSError, KeyError)
# Bytes that an unpacked array may have per point: more than any record of numbers needs. Together with MEMBER_BYTES it
# bounds what a small archive can unpack to.
BYTES_PER_POINT = 128
MEMBER_BYTES = 1 << 20


def read_npz(content: bytes, options: ReadOptions) -> RawPoints:
    """Return the points, and the normals if there are any, of an npz file.

    Raises
    ------
    MalformedInputError
        If the bytes are not an npz file of real numbers.
    InvalidInputError
        If no array is called `points` and there is not exactly one, or if it cannot be told which column is what.
    TooLargeError
        If there are more than `max_points` points, or an array is larger than so many points can be.

    """
    try:
        with ZipFile(BytesIO(content)) as archive:
            members = {name.removesuffix(".npy"): name for name in archive.namelist()}
            chosen = _chosen(members)
            unpacked = {name: _unpacked(archive, members[name], options.max_points) for name in chosen}
    except NOT_NPZ as error:
        raise MalformedInputError(f"not an npz file: {shortened(str(error), 200)}", ("points",)) from error
    arrays = {name: npy.read_array(unpacked[name], name, options.max_points) for name in chosen}
    points, normals = npy.split(arrays[chosen[0]], options)
    if len(chosen) == 1:
        return RawPoints(points, normals)
    if normals is not None:
        raise InvalidInputError("there are normals in two places: in points and in normals", ("normals",))
    return RawPoints(points, _normals(arrays[chosen[1]], points.shape[1]))


def _chosen(members: dict[str, str]) -> list[str]:
    """Return the name of the array of points and, if there is one, that of the normals."""
    if "points" in members:
        return [name for name in ("points", "normals") if name in members]
    if len(members) == 1:
        return list(members)
    listed = shortened(", ".join(sorted(members)) or "none", 80)
    raise InvalidInputError(f"of several arrays one must be called points; here are {listed}", ("points",))


def _unpacked(archive: ZipFile, name: str, max_points: int) -> bytes:
    """Return the bytes of a member, of which no more are unpacked than so many points can have."""
    if archive.getinfo(name).compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        raise MalformedInputError(f"{shortened(name)} is not packed as numpy packs arrays", ("points",))
    most = BYTES_PER_POINT * max_points + MEMBER_BYTES
    with archive.open(name) as member:
        content = member.read(most + 1)
    if len(content) > most:
        raise TooLargeError(f"{shortened(name)} is larger than {max_points} points can be", ("points",))
    return content


def _normals(table: Array, dimension: int) -> Array:
    """Return normals (N, d) of numbers (N, d), or of records (N,) with as many fields as axes, in their order."""
    if table.dtype.names is None:
        return table
    names = table.dtype.names
    axes = tuple(i for i, name in enumerate(names) if columns.role(name) is not None)
    if len(axes) != dimension:
        raise InvalidInputError(f"normals must have {dimension} fields, as points have", ("normals",))
    order = sorted(axes, key=lambda i: columns.role(names[i]) or "")
    return npy.numbers(table, tuple(order))
