"""Sending callbacks over HTTP: where they may go, how they are signed, and one request with its answer."""
