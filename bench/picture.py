"""Make the picture at the top of the README: `python bench/page.py`."""

from pathlib import Path

import ipcore
from ipcore import shapes
from service.formats.picture import page
from service.formats.picture.view import View

points, normals = shapes.genus_two().sample(3000)
result = ipcore.fit(points, normals)
target = Path(__file__).parent / "readme.svg"
target.write_bytes(page.plot(result, points, View("z", 20, 35)))
print(f"{target.name}: degree {result.degree}, {target.stat().st_size} bytes")
