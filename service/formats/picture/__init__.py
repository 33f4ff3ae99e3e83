"""Pictures of fits, as SVG: the shape and the data on the left, the measures of every degree on the right."""
