"""Array aliases. They say what an array holds; its shape stands in the docstring that uses it."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
ExtendedArray = NDArray[np.longdouble]
BoolArray = NDArray[np.bool_]
