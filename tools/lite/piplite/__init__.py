"""What `%pip` and the kernel of JupyterLite ask for packages: here they are built in, and no other can be fetched.

It stands in the place of JupyterLite's own `piplite`, whose import takes half a second of every start.
"""

from .piplite import install

__all__ = ["install"]
