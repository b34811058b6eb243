"""The name under which the kernel looks for `install` and leaves its settings."""

SENTENCE = "The course in a browser has its packages built in and fetches no other; %pip works where it is installed."


async def install(*_packages, **_options):
    """Say that there is nothing to fetch."""
    raise ValueError(SENTENCE)
