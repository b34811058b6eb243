"""What a line with `%pip` becomes."""

from .piplite import SENTENCE


async def get_transformed_code(_words):
    """Return a cell that says why nothing is installed."""
    return f"print({SENTENCE!r})"
