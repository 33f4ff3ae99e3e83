"""Make docs/horse.svg, the picture at the top of the README: `python bench/picture.py`.

The README's own commands make the same picture: the points are those of its first example.
"""

from pathlib import Path

import numpy as np
from skimage import data, measure

import ipcore
from service.formats.picture import page

contour = max(measure.find_contours(data.horse().astype(float), 0.5), key=len)
points = contour[::3, ::-1] * np.array([1.0, -1.0])  # (882, 2): x to the right, y up
result = ipcore.fit(points)
target = Path(__file__).parent.parent / "docs" / "horse.svg"
target.parent.mkdir(exist_ok=True)
target.write_bytes(page.plot(result, points))
print(f"{target.name}: degree {result.degree}, {target.stat().st_size} bytes")
