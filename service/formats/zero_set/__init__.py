"""Zero sets out: a module for each format of meshes and curves, named like the format, with a function `write`.

Faces are counter-clockwise seen from outside.

| format | coordinates | normals | loses |
| --- | --- | --- | --- |
| GLB | float32 about the middle, which stands in the node's matrix | of vertices | digits below 1e-7 of the size |
| PLY | float64 | of vertices | nothing |
| STL | float32 | of faces | digits below 1e-7 of the distance from the origin, and which faces share a vertex |
| OBJ | decimal, 17 digits | of vertices | nothing |

The unit of length and the axes are those of the data in all of them, though glTF would have metres and y up.
"""
