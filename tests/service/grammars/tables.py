"""Text tables that nobody means."""

from tests.service.grammars.draws import NAMES, Generator

NUMBERS = [
    "0",
    "1",
    "-1",
    "0.5",
    "1e3",
    "1e308",
    "-1e400",
    "5e-324",
    "nan",
    "inf",
    "",
    " ",
    "-",
    "NA",
    "1,5",
    "x",
    "1_0",
    "½",
]


def table_body(r: Generator) -> bytes:
    delimiter = r.choice([",", ",", ";", "\t", " ", "  ", ", ", "|"])
    width = r.choice([1, 2, 2, 3, 3, 4, 6, 7])
    wild = r.choice([0.0, 0.0, 0.0, 0.01, 0.5])

    def cell() -> str:
        if r.random() < wild:
            return r.choice([*NUMBERS, '"', '"1"', '"a' + delimiter + 'b"', "\x00", "#", "x" * r.randrange(200)])
        return repr(r.uniform(-2, 2)).replace(".", "," if delimiter == ";" else ".")

    before = ["# c", "# c", "", "//X Y Z", "% x" + delimiter + "y", "", "20", "0", "99999999999999999999", "#"]
    lines = [r.choice(before) for _ in range(r.choice([0, 0, 1, 2]))]
    if r.random() < 0.5:
        names = (
            [r.choice(NAMES) for _ in range(width)] if r.random() < 0.5 else ["x", "y", "z", "q", "r", "s", "t"][:width]
        )
        lines.append(delimiter.join(names))
    for i in range(r.choice([0, 1, 5, 20, 20, 301])):
        cells = [cell() for _ in range(width)]
        lines.append(
            delimiter.join(cells if r.random() > wild / 5 else [str(i), *cells])
            + r.choice(["", "", "", delimiter if wild else ""])
        )
        if r.random() < wild / 5:
            lines.append(r.choice(["", "# c", "20", delimiter * 5]))
    text = r.choice(["\n", "\n", "\r\n", "\r"]).join(lines)
    return text.encode(r.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-be"]))
