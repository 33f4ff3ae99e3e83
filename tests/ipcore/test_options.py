from typing import Any

import pytest

from ipcore.errors import InvalidOptionsError
from ipcore.options import FitOptions


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_degree", 0),
        ("max_degree", 41),
        ("max_degree", 4.0),
        ("max_degree", True),
        ("layer_distance", 0.0),
        ("layer_distance", 0.31),
        ("layer_distance", float("nan")),
        ("t1", -1e-9),
        ("t1", "0.01"),
        ("t2", 1.01),
        ("collinear_tol", -1.0),
        ("neighbours", 2),
        ("basis", "legendre"),
    ],
)
def test_a_wrong_value_is_refused_by_name(name: str, value: Any) -> None:  # noqa: ANN401 - wrong on purpose
    with pytest.raises(InvalidOptionsError, match=name) as caught:
        FitOptions(**{name: value})
    assert caught.value.at == (name,)


def test_degree_cap_depends_on_the_dimension() -> None:
    assert FitOptions().degree_cap(2) == 20
    assert FitOptions().degree_cap(3) == 16
    assert FitOptions(max_degree=30).degree_cap(2) == 30
    with pytest.raises(InvalidOptionsError, match="at most 20 for 3D points, not 21"):
        FitOptions(max_degree=21).degree_cap(3)
