"""Connections: what a peer may send and how fast, decided before a request reaches the application."""
