"""The domain: fits, their transitions, the use cases, and the ports to everything outside. It knows no framework."""
