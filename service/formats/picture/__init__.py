"""A picture of a fit, as SVG."""
