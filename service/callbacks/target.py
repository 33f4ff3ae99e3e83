"""The URL of a callback, taken apart."""

import re
from dataclasses import dataclass
from ipaddress import ip_address
from typing import Self
from urllib.parse import urlsplit

LONGEST_URL = 2000  # characters
PORTS = {"https": 443, "http": 80}
# The characters of a URL (RFC 3986), without the # of a fragment, which is not sent.
_URL = re.compile(r"[A-Za-z0-9._~:/?\[\]@!$&'()*+,;=%-]+")
# A host and perhaps a port. Python 3.11 takes [::1].hooks.example for ::1.
_AUTHORITY = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[^\[\]:]+)(:\d*)?")
_NAME = re.compile(r"(?=.{1,253}$)([a-z0-9_]([a-z0-9_-]{0,61}[a-z0-9_])?\.)*[a-z0-9_]([a-z0-9_-]{0,61}[a-z0-9_])?")
# Resolvers take a last label such as these for a number of an IPv4 address: 127.1, 0x7f000001.
_NUMBER = re.compile(r"(.*\.)?(\d+|0x[0-9a-f]*)")


@dataclass(frozen=True)
class Target:
    """Where a callback is sent.

    Attributes
    ----------
    scheme, host, port
        `http` or `https`, a name or an address, in lower case, and the port.
    path
        The path and the query, as they stand in the request line.

    """

    scheme: str
    host: str
    port: int
    path: str

    @classmethod
    def of(cls, url: str, *, allow_http: bool) -> Self:
        """Take a URL apart.

        Raises
        ------
        ValueError
            If callbacks cannot be sent there; the message says why.

        >>> Target.of("https://Hooks.example/a?b=c", allow_http=False)
        Target(scheme='https', host='hooks.example', port=443, path='/a?b=c')
        """
        if len(url) > LONGEST_URL or not _URL.fullmatch(url):
            raise ValueError(f"it must be a URL of at most {LONGEST_URL} ASCII characters, without a fragment")
        try:
            parts = urlsplit(url)
            port = parts.port
        except ValueError:
            raise ValueError("it must be a URL; its host or its port cannot be read") from None
        schemes = ("https", "http") if allow_http else ("https",)
        if parts.scheme not in schemes or not url.partition(":")[2].startswith("//"):
            raise ValueError(f"it must begin with {' or '.join(f'{one}://' for one in schemes)}")
        if "@" in parts.netloc:
            raise ValueError("it must not have a user name or a password; the signature says who sends")
        host = parts.hostname or ""
        named = is_address(host) or (_NAME.fullmatch(host) and not _NUMBER.fullmatch(host))
        if port == 0 or not named or not _AUTHORITY.fullmatch(parts.netloc):
            raise ValueError("its host must be a name or an address, and its port from 1 to 65535")
        path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        return cls(parts.scheme, host, port or PORTS[parts.scheme], path)

    @property
    def authority(self) -> str:
        """Return the host and, unless it is that of the scheme, the port, as in the header Host.

        >>> Target("https", "::1", 8443, "/").authority
        '[::1]:8443'
        """
        host = f"[{self.host}]" if ":" in self.host else self.host
        return host if self.port == PORTS[self.scheme] else f"{host}:{self.port}"


def is_address(host: str) -> bool:
    """Return whether a host is an address, and not a name."""
    try:
        ip_address(host)
    except ValueError:
        return False
    return "%" not in host  # no zones: fe80::1%eth0
