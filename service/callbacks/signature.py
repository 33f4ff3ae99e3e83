"""Signatures of callbacks, by the Standard Webhooks specification (standardwebhooks.com)."""

import base64
import hashlib
import hmac
from dataclasses import dataclass

PREFIX = "whsec_"


@dataclass(frozen=True, repr=False)
class Signer:
    """Signs messages, with every key: receivers accept any, so that keys can be exchanged one after the other.

    Attributes
    ----------
    keys
        The keys.

    """

    keys: tuple[bytes, ...]

    @classmethod
    def of(cls, secrets: str) -> "Signer":
        """Return a signer with the keys of these secrets, `whsec_…` in base64 with spaces between."""
        return cls(tuple(base64.b64decode(one.removeprefix(PREFIX)) for one in secrets.split()))

    def headers(self, message_id: str, seconds: int, body: bytes) -> dict[str, str]:
        """Return the headers of a message that is sent at this time, in seconds since 1970."""
        signed = f"{message_id}.{seconds}.".encode() + body
        made = (base64.b64encode(hmac.digest(key, signed, hashlib.sha256)).decode() for key in self.keys)
        return {
            "webhook-id": message_id,
            "webhook-timestamp": str(seconds),
            "webhook-signature": " ".join(f"v1,{one}" for one in made),
        }
