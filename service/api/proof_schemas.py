"""The representation of a proof."""

from pydantic import BaseModel, Field

from service.api.schema_types import Count, EulerCharacteristic, Vector

_MOST_PLACES = 16


class Place(BaseModel):
    """A ball, in the caller's coordinates."""

    centre: Vector = Field(description="Its centre.")
    radius: float = Field(description="Its radius.")


class Proof(BaseModel):
    """What has been proved of the zero set of exactly these coefficients within the bounds, with all rounding."""

    within: float = Field(
        description="If it holds, every zero has a point of yours within this distance, caller's unit."
    )
    holds: bool = Field(
        description="Whether it is proved that no zero lies away from the points: all are near a point, within the "
        "support radius, or the gap radius of the points if that is more (as far as gaps in a random sample reach), "
        "or, where points are sparse, 2.5 times the spacing there."
    )
    regular: bool = Field(description="Whether it is proved that the zero set is smooth: ∇f does not vanish on it.")
    components: Count | None = Field(description="The number of its components; null if not proved.")
    euler: EulerCharacteristic | None = Field(
        description="Its Euler characteristic: 0 in the plane, in space the sum of 2 − 2 genus over the components; "
        "null if not proved."
    )
    boxes: Count = Field(description="How many boxes were looked at.")
    seconds: float = Field(description="Wall-clock seconds.")
    uncleared: list[Place] = Field(
        max_length=_MOST_PLACES,
        description="Where zeros away from the points could not be excluded; or, if it holds, where the zero set could "
        "not be shown to be smooth. Of many places the largest.",
    )
