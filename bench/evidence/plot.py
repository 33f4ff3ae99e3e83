"""Figures: outlines with their zero sets, surfaces as shaded meshes."""

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

import ipcore
from sets import FloatArray, PointSet

rcParams.update({"axes.titlesize": 7, "xtick.labelsize": 6, "ytick.labelsize": 6, "axes.linewidth": 0.5})

DATA, FIT, STRAY = "0.55", "#1f5fa8", "#e4572e"
SKY = np.array([0.3, 0.5, 0.8])  # where the light comes from, in view coordinates


def new(height: int, width: int, size: float) -> tuple[Figure, list[Axes]]:
    """Return a figure of height × width panels, `size` inches each, and its axes row by row."""
    picture = Figure(figsize=(width * size, height * size), layout="constrained")
    axes: list[Axes] = np.atleast_1d(picture.subplots(height, width)).ravel().tolist()
    return picture, axes


def outline(axis: Axes, given: PointSet, polynomial: ipcore.ImplicitPolynomial) -> None:
    """Draw the points of an outline and the whole zero set within the bounds; its stray parts have another colour."""
    axis.plot(*given.points.T, ".", ms=1.2, color=DATA)
    for restrict, colour in ((False, STRAY), (True, FIT)):
        curve = ipcore.zero_set(polynomial, resolution=240, data=given.points, restrict=restrict, cap=False)
        axis.add_collection(LineCollection(list(curve.vertices[curve.cells]), colors=colour, linewidths=1.0))
    frame(axis, polynomial.bounds)


def surface(axis: Axes, given: PointSet, polynomial: ipcore.ImplicitPolynomial, *, whole: bool = True) -> None:
    """Draw the zero set of a surface, seen from the front right; its stray parts have another colour."""
    mesh = ipcore.zero_set(polynomial, resolution=72, data=given.points, restrict=not whole, cap=False)
    near = ipcore.zero_set(polynomial, resolution=72, data=given.points, restrict=True, cap=False)
    view = rotation(np.ptp(given.points, axis=0))
    corners = mesh.vertices[mesh.cells] @ view
    if not len(corners):
        axis.set_axis_off()
        return
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    light = 0.35 + 0.65 * np.abs(normal @ (SKY / np.linalg.norm(SKY)))
    kept = {tuple(row) for row in np.round(near.vertices, 9).tolist()}
    at_data = np.array([tuple(row) in kept for row in np.round(mesh.vertices, 9).tolist()])
    belongs = np.asarray(at_data[mesh.cells].all(axis=1))
    colour = np.where(belongs[:, None], [[0.45, 0.62, 0.82]], [[0.93, 0.45, 0.3]]) * light[:, None]
    order = np.argsort(corners[:, :, 2].mean(axis=1))
    axis.add_collection(PolyCollection(list(corners[order][:, :, :2]), facecolors=colour[order], edgecolors="none"))
    box = np.stack(np.meshgrid(*polynomial.bounds.T, indexing="ij"), axis=-1).reshape(-1, 3) @ view
    frame(axis, np.stack([box.min(axis=0), box.max(axis=0)])[:, :2])


def rotation(extent: FloatArray) -> FloatArray:
    """Return the view as a matrix (3, 3) for row vectors: the longer of y and z up, turned by 35°, tilted by 20°."""
    up = 2 if extent[2] > extent[1] else 1
    axes = np.eye(3)[[0, up, 3 - up]] * [[1.0], [1.0], [1.0 if up == 1 else -1.0]]
    turn, tilt = np.radians(35.0), np.radians(20.0)
    about_up = np.array([[np.cos(turn), 0.0, np.sin(turn)], [0.0, 1.0, 0.0], [-np.sin(turn), 0.0, np.cos(turn)]])
    about_side = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(tilt), -np.sin(tilt)], [0.0, np.sin(tilt), np.cos(tilt)]])
    return np.asarray((about_side @ about_up @ axes).T)


def frame(axis: Axes, box: FloatArray) -> None:
    """Set the limits of the axes to a box (2, 2), with equal units and without ticks."""
    axis.set_xlim(box[0, 0], box[1, 0])
    axis.set_ylim(box[0, 1], box[1, 1])
    axis.set_aspect("equal")
    axis.set_xticks([])
    axis.set_yticks([])
