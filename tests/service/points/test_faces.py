import numpy as np

from service.formats.points import faces


def test_normals_of_faces_with_the_largest_coordinates_are_those_of_the_same_faces_elsewhere() -> None:
    corners = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -1.0, -1.0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    near = faces.vertex_normals(corners, triangles)
    far = faces.vertex_normals(1e300 * corners, triangles)
    assert near is not None
    assert far is not None
    np.testing.assert_allclose(far, near)
