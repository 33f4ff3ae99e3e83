"""The JSON of callbacks: as a member of a fit, and as the message that is sent."""

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from service.api.schema_types import Count, FitIdText, PathText, Text, Time
from service.choices import OneOf
from service.jobs.callback import CallbackState


class CallbackResource(BaseModel):
    """The callback of a fit, and how far its delivery is."""

    url: Text = Field(description="Where to, without the query.")
    state: Annotated[str, OneOf(CallbackState)] = Field(
        description="`pending` until it is `delivered`, which is when the receiver has answered with a status from 200 "
        "to 299, or has `failed` for good."
    )
    tries: Count = Field(description="How often it was tried.")
    last_error: Text | None = Field(description="Why the last try failed.")


class FitEndedData(BaseModel):
    """The fit that has ended."""

    id: FitIdText = Field(description="Its id.")
    status: Literal["successful", "failed", "dismissed"] = Field(description="How it ended.")
    path: PathText = Field(description="Its path on this server, where everything else about it is.")


class FitEnded(BaseModel):
    """The message that is sent to the callback of a fit."""

    type: Literal["fit.ended"] = Field(description="`fit.ended`.")
    timestamp: Time = Field(description="When it ended, UTC.")
    data: FitEndedData = Field(description="Which fit, and how.")
