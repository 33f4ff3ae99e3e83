"""The GeoJSON of a curve (RFC 7946), for the OpenAPI document; `service.formats.zero_set.geojson` writes it."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from service.api.schema_types import LARGEST_COUNT, Count, Text


class CurveGeometry(BaseModel):
    """Polygons if all lines are closed, else lines, with the inside on their left."""

    type: Literal["Polygon", "MultiPolygon", "MultiLineString"] = Field(description="How coordinates are nested.")
    coordinates: list[Any] = Field(max_length=LARGEST_COUNT, description="Positions [x, y] in the caller's frame.")


class CurveProperties(BaseModel):
    """What is known of a curve."""

    coordinates: Text = Field(description="Whose the coordinates are: not longitude and latitude.")
    components: Count | None = Field(description="Connected components.")
    stray: float | None = Field(description="Share of the length that lies away from all points.")


class CurveFeature(BaseModel):
    """A curve as a GeoJSON Feature."""

    type: Literal["Feature"] = Field(description="What it is for GeoJSON.")
    geometry: CurveGeometry | None = Field(description="The lines; null if there are none.")
    properties: CurveProperties = Field(description="What is known of it.")
    bbox: Annotated[list[float], Field(min_length=4, max_length=4)] | None = Field(
        None, description="The lower and the upper corner; not there without lines."
    )
