"""Zero sets and ids: bounds, resolutions, formats, and fits that are none."""

from urllib.parse import quote

from tests.service.hostile.cases import CURVE, REFUSED, SURFACE, TAKEN, Case, get

NUMBERS = ["nan", "inf", "-inf", "1e999", "", " ", "x", "٣", "1_0", "0x1", "1e", "9" * 5000, "%00", "1;2", "null"]
RESOLUTIONS = ["0", "-1", "3", "3.9", "257", "2049", "99999999999999999999", *NUMBERS]
BOUNDS = [
    *(f"{n},-1,1,1" for n in NUMBERS), "", ",", ",,,", "-1,-1,1", "-1,-1,1,1,1", "-1,-1,-1,1,1,1", "1,1,-1,-1",
    "0,0,0,0", "1,1,1,1", "-1e150,-1e150,1e150,1e150", "-1e308,-1e308,1e308,1e308", "0,0,5e-324,5e-324",
    "0,0,1e-300,1e300", "1e149,1e149,1.0000000001e149,1.0000000001e149", ",".join(["1"] * 20_000),
    "-1,-1,1,1&bounds=0,0,1,1", "-1%2C-1%2C1%2C1", "(-1,-1,1,1)", "-1 -1 1 1",
]  # fmt: skip
FORMATS = [
    "", "exe", "PLY", "ply,stl", "../ply", "%00", "svg%00", "é", "x" * 5000, "json", "npy", "glb", "ply", "stl",
    "obj", "svg", "geojson",
]  # fmt: skip
EXTENTS = ["", "DATA", "all", "data,bounds", "%00", "x" * 5000, "true"]
IDS = [
    "0" * 32, "f" * 32, "F" * 32, "0" * 31, "0" * 33, "0" * 5000, "%30" * 32, "-1", "1", "null", "None", "*", "%2a",
    ".", "%2e", "%2e%2e", "..%2f", "%00", "0" * 31 + "%00", "%ff", "%ed%a0%80", "%f0%9f%90%8e", "'", "%22",
    "%3cscript%3e", "%0a", "%0d%0aX:y", "a b".replace(" ", "%20"), "%252e", "{}", "[]", "$ne", "1%20OR%201=1",
    "'%20--", "{fit_id}", "%7bfit_id%7d", "\u0660" * 32, "mesh",
]  # fmt: skip
PATHS = ["", "/", "/mesh", "/mesh/", "/mesh/..", "/MESH", "/mesh%00", "//mesh", "/mesh/x", "/mesh;x"]


def zero_sets() -> list[Case]:
    """Return every parameter of a zero set with values that it may not have, of a curve and of a surface."""
    sent = [f"resolution={value}" for value in RESOLUTIONS] + [f"bounds={value}" for value in BOUNDS]
    sent += [f"extent={value}" for value in EXTENTS] + ["resolution=16&resolution=32", "x=1", "resolution", "&&", "=1"]
    sent += [f"format={kind}&resolution=16&bounds={box}" for kind in FORMATS for box in ("-1,-1,1,1", "-1,-1,-1,1,1,1")]
    sent += ["resolution=2048&bounds=-1e9,-1e9,1e9,1e9&extent=bounds", "resolution=4&bounds=100,100,101,101"]
    found = []
    for place, fit in (("curve", CURVE), ("surface", SURFACE)):
        for one in sent:
            query = quote(one, safe="%&=,;(){}/").encode()
            found.append(
                Case(
                    f"{place} {one[:50]} ({len(one)})", (get(b"/v1/fits/" + fit + b"/mesh?" + query),), REFUSED | TAKEN
                )
            )
    return found


def ids() -> list[Case]:
    """Return ids that no fit has, with every method, and paths behind one that a fit has."""
    found = [
        Case(
            f"{method} {fit[:30]} ({len(fit)}){path}",
            (get(f"/v1/fits/{quote(fit, safe='%')}{path}", b"", method.encode()),),
            REFUSED,
            bodiless=method == "HEAD",
        )
        for fit in IDS
        for method, path in (("GET", ""), ("HEAD", "/mesh"), ("DELETE", ""), ("GET", "/mesh"))
    ]
    found += [
        Case(f"behind a fit: {path}", (get(b"/v1/fits/" + CURVE + path.encode()),), REFUSED | TAKEN) for path in PATHS
    ]
    accepted = [b"*/*;q=0", b"model/ply", b"image/svg+xml", b"\xff", b"," * 5000]
    return found + [
        Case(
            f"Accept {value[:20]!r}",
            (get(b"/v1/fits/" + CURVE + b"/mesh?resolution=16", b"Accept: " + value + b"\r\n"),),
            REFUSED | TAKEN,
        )
        for value in accepted
    ]
