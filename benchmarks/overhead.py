"""What one step consists of where the arithmetic is nothing: N = 10."""


def run(budget):
    """Rows."""
    return []
