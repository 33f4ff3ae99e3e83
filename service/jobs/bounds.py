"""The widest limits that a server can have: settings stay within them, and the OpenAPI document promises them."""

# 32 bits hold every count of points and bytes, which is what most languages call an integer.
LARGEST_POINT_SET = 2**31 - 1
MOST_BODY_BYTES = 2**31 - 1
MOST_RESOLUTION = 2**15
LONGEST_ROOT_PATH = 1000
# Bytes of a request's head: no header and no query is longer.
HEAD_BYTES = 64 * 1024
# Coefficients of degree 20 in 3D, the most that any fit has: degree 40 in 2D has half as many.
MOST_COEFFICIENTS = 1771
