"""Compressing answers for those who can read them compressed."""

import gzip

import zstandard

# Fast levels: an answer is made while its caller waits.
GZIP_LEVEL, ZSTD_LEVEL = 4, 3
# The encodings of HTTP that are known here; of several that a caller likes equally, the first is taken.
ENCODINGS = ("zstd", "gzip")
# Bytes below which compression saves nothing worth its time.
WORTH_IT = 4096


def compressed(content: bytes, encoding: str | None) -> tuple[bytes, str | None]:
    """Return content in an encoding of HTTP, `gzip` or `zstd`, and the encoding; as it is, and None, if it is small.

    >>> [(len(data) < 100, name) for data, name in (compressed(bytes(10_000), "zstd"), compressed(b"a", "gzip"))]
    [(True, 'zstd'), (True, None)]
    """
    if encoding is None or len(content) < WORTH_IT:
        return content, None
    if encoding == "gzip":
        return gzip.compress(content, GZIP_LEVEL, mtime=0), encoding
    return zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress(content), encoding
