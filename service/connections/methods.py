"""The methods of HTTP that a request may have."""

import re

# Those of HTTP and of its registered extensions that the parser knows. The application answers those that a path does
# not have with 405. Others are answered with 501 (RFC 9110, 9.1); so is CONNECT, whose target is no path.
KNOWN_METHODS = frozenset(
    b"GET HEAD POST PUT PATCH DELETE OPTIONS TRACE QUERY PROPFIND PROPPATCH MKCOL COPY MOVE LOCK UNLOCK SEARCH BIND "
    b"REBIND UNBIND ACL REPORT MKACTIVITY CHECKOUT MERGE M-SEARCH NOTIFY SUBSCRIBE UNSUBSCRIBE PURGE MKCALENDAR LINK "
    b"UNLINK SOURCE".split()
)
_REQUEST_LINE = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]{1,64}) \S")


def unknown_method(data: bytes) -> bytes | None:
    """Return the method with which a request begins, if it is none of `KNOWN_METHODS`; else, and for no request, None.

    >>> unknown_method(b"BREW / HTTP/1.1"), unknown_method(b"GET / HTTP/1.1"), unknown_method(b"no request")
    (b'BREW', None, b'no')
    """
    line = _REQUEST_LINE.match(data.lstrip(b"\r\n"))
    return line.group(1) if line is not None and line.group(1) not in KNOWN_METHODS else None
