"""The same steps as `slam`, quicker."""
