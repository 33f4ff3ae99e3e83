"""The ipfit service: fits over HTTP. The mathematics lives in `ipcore`."""
