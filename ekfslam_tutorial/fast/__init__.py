"""The steps of `slam` once more, quicker.

Lives here: what exists to be quick; the tracer that makes a program of a model. It computes what the core computes.
May not: be imported by the core.
"""
