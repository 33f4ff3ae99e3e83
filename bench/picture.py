"""Make the picture at the top of the README: `python bench/picture.py`."""

from pathlib import Path

import ipcore
from ipcore import shapes
from service.formats import picture
from service.formats.picture_surface import View

points, normals = shapes.genus_two().sample(3000)
result = ipcore.fit(points, normals)
target = Path(__file__).parent / "readme.svg"
target.write_bytes(picture.plot(result, points, View("z", 20, 35)))
print(f"{target.name}: degree {result.degree}, {target.stat().st_size} bytes")
