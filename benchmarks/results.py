"""The results of one run: a plain dictionary that is also the file results.json, and ways to ask it."""

import json
from dataclasses import dataclass, field

SCHEMA = 1


@dataclass
class Results:
    """Everything that was measured, as README.md describes it. `data` is what results.json holds."""

    data: dict = field(default_factory=lambda: {"schema": SCHEMA})

    @classmethod
    def load(cls, path):
        """From a file.

        Raises
        ------
        ValueError
            If it was written by another version of this benchmark.
        """
        data = json.loads(path.read_text(encoding="utf-8"))
        if data.get("schema") != SCHEMA:
            raise ValueError(f"{path.name} has schema {data.get('schema')}; this program reads schema {SCHEMA}")
        return cls(data)

    def save(self, path):
        """To a file, one row a line: a difference between two runs can be read."""
        parts = []
        for key, value in self.data.items():
            if isinstance(value, list) and value:
                rows = ",\n  ".join(json.dumps(rounded(row), ensure_ascii=False) for row in value)
                parts.append(f' "{key}": [\n  {rows}\n ]')
            else:
                parts.append(f' "{key}": {json.dumps(rounded(value), ensure_ascii=False)}')
        path.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")

    def rows(self, section, **where):
        """Rows of a section in which these entries have these values."""
        return [row for row in self.data.get(section, []) if all(row.get(k) == v for k, v in where.items())]

    def us(self, n_lmks, m, variant, which="median", clock="cpu_us"):
        """Microseconds of a cell of the grid; None if it was not measured."""
        for row in self.rows("grid", n_lmks=n_lmks, m=m, variant=variant):
            return row.get(clock, {}).get(which)
        return None

    def limit(self, n_lmks, m, way="joint"):
        """Microseconds of the physical limit."""
        return self.us(n_lmks, m, f"limit, {way}")

    def total(self, n_lmks, variant):
        """Seconds of a circuit; None if it was not measured."""
        for row in self.rows("circuit", n_lmks=n_lmks, variant=variant):
            return row.get("total_s")
        return None

    def variants(self, section, **where):
        """Names in the order in which they were measured."""
        return list(dict.fromkeys(row["variant"] for row in self.rows(section, **where)))

    def sizes(self, section, **where):
        """The values of N."""
        return sorted({row["n_lmks"] for row in self.rows(section, **where)})


def rounded(value):
    """Floats to five digits: more than a timing has."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    return value


def ratio(a, b):
    """a / b; None where one of them is missing."""
    return a / b if a and b else None


def least(*values):
    """The smallest that is there; None if none is."""
    return min((v for v in values if v), default=None)
