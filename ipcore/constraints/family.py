"""The interface of a constraint family: the rows that it makes, and the properties by which a fit of it is planned."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from ipcore._typing import FloatArray
from ipcore.constraints.rows import Rows


@dataclass(frozen=True)
class RowParameters:
    """The two numbers that families take from the options.

    Attributes
    ----------
    layer_distance
        c, the distance of the outer layers from the data, in mean radii.
    gradient_weight
        μ, the weight of the squared errors of ∇f against those of f, in squared mean radii.

    """

    layer_distance: float
    gradient_weight: float


class Family(ABC):
    """A constraint family. A subclass sets the attributes in which it differs from the values here.

    Attributes
    ----------
    is_least_squares
        Whether the fit minimises ‖M a − b‖². If not, there is no right-hand side, and the fit is an eigenvector.
    rhs_depends_on_degree
        Whether b is another at every degree of the fit.
    uses_layer_distance, uses_gradient_weight
        Whether the rows depend on c, and on μ.

    """

    is_least_squares: ClassVar[bool] = True
    rhs_depends_on_degree: ClassVar[bool] = False
    uses_layer_distance: ClassVar[bool] = False
    uses_gradient_weight: ClassVar[bool] = False

    @abstractmethod
    def rows(self, points: FloatArray, normals: FloatArray, parameters: RowParameters) -> Rows:
        """Return the rows for points and unit outward normals, (N, d) each, in the normalised frame."""

    @abstractmethod
    def rows_per_point(self, dimension: int) -> int:
        """Return how many rows each point gets in d = 2 or 3 dimensions."""

    def layer_offsets(self, layer_distance: float) -> tuple[float, ...]:  # noqa: ARG002 - for families of layers
        """Return the offsets o of the layers, in mean radii, if all rows are f(x_i + o n_i) = o; else an empty tuple.

        Such a family is determined by moments of its layers (see `ipcore.linear.layer_moments`).
        """
        return ()
