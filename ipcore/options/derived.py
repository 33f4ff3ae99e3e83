"""What follows from the options of a fit: which kind of fit it is, and what it needs."""

from ipcore.constraints.family import Family, RowParameters
from ipcore.constraints.registry import Constraints
from ipcore.options.choices import Collinear, Criterion, Factor, Granularity, Ridge
from ipcore.options.idle import Acting


class DerivedOptions:
    """The properties of `FitOptions` that follow from its fields, of which those that decide are named here."""

    constraints: Constraints
    layer_distance: float
    gradient_weight: float
    criterion: Criterion
    granularity: Granularity
    factor: Factor
    collinear: Collinear | None
    ridge: Ridge
    signs: bool | None
    geometric: bool | None

    @property
    def family(self) -> Family:
        """Return the constraint family."""
        return self.constraints.family

    @property
    def row_parameters(self) -> RowParameters:
        """Return what the family's rows depend on."""
        return RowParameters(self.layer_distance, self.gradient_weight)

    @property
    def layer_offsets(self) -> tuple[float, ...]:
        """Return the offsets of the layers, in mean radii, if all rows are values of f on layers; else ()."""
        return self.family.layer_offsets(self.layer_distance)

    @property
    def needs_rows(self) -> bool:
        """Return whether a linear fit needs all rows at once.

        It does to leave points out, for a right-hand side that depends on the degree, and for an eigenvector.
        """
        family = self.family
        return self.criterion.needs_rows or family.rhs_depends_on_degree or not family.is_least_squares

    @property
    def holds_design_matrix(self) -> bool:
        """Return whether a linear fit with these options holds all rows and columns of M at once."""
        return self.needs_rows or self.factor in {Factor.BLOCK, Factor.GRAM_SCHMIDT}

    @property
    def fits_from_moments(self) -> bool:
        """Return whether a fit with these options can be made from moments alone: a linear fit to layers, without Q."""
        by_rows = self.holds_design_matrix or self.factor is Factor.TSQR
        return self.is_linear and not by_rows and bool(self.layer_offsets)

    @property
    def needs_linear(self) -> bool:
        """Return whether an option is given that only a linear fit has."""
        return (
            self.constraints is not Constraints.THREE_LAYER
            or self.granularity is not Granularity.FORM
            or self.factor is not Factor.AUTO
            or self.ridge is not Ridge.NONE
            or self.collinear is not None
            or self.criterion.needs_least_squares
        )

    @property
    def on_geometric(self) -> bool:
        """Return `geometric` with its default filled in: whether distances and angles are minimised."""
        return not self.needs_linear if self.geometric is None else self.geometric

    @property
    def on_signs(self) -> bool:
        """Return `signs` with its default filled in: whether the sign of f is constrained."""
        return self.on_geometric if self.signs is None else self.signs

    @property
    def is_linear(self) -> bool:
        """Return whether the fit is linear: neither geometric nor under sign constraints."""
        return not (self.on_geometric or self.on_signs)

    @property
    def on_collinear(self) -> Collinear:
        """Return `collinear` with its default filled in: what is done with collinear columns."""
        if self.collinear is not None:
            return self.collinear
        return Collinear.RIDGE if self.ridge is Ridge.SELECTIVE else Collinear.DROP

    @property
    def acting(self) -> Acting:
        """Return what decides which options act."""
        return Acting(
            is_linear=self.is_linear,
            family=self.family,
            has_ridge=self.ridge is not Ridge.NONE,
            drops_columns=self.on_collinear is not Collinear.KEEP,
            by_distance=self.criterion is Criterion.DISTANCE,
        )
