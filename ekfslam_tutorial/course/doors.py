"""Where a notebook opens with nothing installed: links for its first page, the README and the course site.

`make contents` writes them; the address of the repository stands in ``pyproject.toml`` and nowhere else.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit


@dataclass(frozen=True)
class Doors:
    """Addresses made from that of a repository on GitHub, whose pages have the course site and, below it, `lite/`.

    Parameters
    ----------
    repository : str
        ``https://github.com/OWNER/NAME``.
    """

    repository: str

    @classmethod
    def of(cls, root: Path) -> Doors:
        """Read the address from ``pyproject.toml`` in the folder `root`."""
        project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        return cls(project["urls"]["Repository"])

    @property
    def owner_and_name(self) -> tuple[str, str]:
        """The last two words of the address."""
        owner, name = urlsplit(self.repository).path.strip("/").split("/")
        return owner, name

    def browser(self, file: str) -> str:
        """Return where a notebook opens with Python in the browser itself."""
        owner, name = self.owner_and_name
        return f"https://{owner}.github.io/{name}/lite/lab/index.html?path={file}"

    def binder(self, file: str) -> str:
        """Return where a notebook opens in Binder."""
        owner, name = self.owner_and_name
        return f"https://mybinder.org/v2/gh/{owner}/{name}/main?urlpath=lab/tree/notebooks/{file}"

    def colab(self, file: str) -> str:
        """Return where a notebook opens in Colab."""
        owner, name = self.owner_and_name
        return f"https://colab.research.google.com/github/{owner}/{name}/blob/main/notebooks/{file}"

    def short(self, file: str) -> str:
        """Return the three links for a table."""
        return f"[browser]({self.browser(file)}) · [Binder]({self.binder(file)}) · [Colab]({self.colab(file)})"

    def long(self, file: str) -> str:
        """Return the text below the title of a notebook."""
        return (
            f"[Open in the browser]({self.browser(file)}) · [Open in Binder]({self.binder(file)}) · "
            f"[Open in Colab]({self.colab(file)})\n\n"
            "Nothing to install; in Colab alone, run this in a cell of its own first: "
            f"`%pip install git+{self.repository}`"
        )
