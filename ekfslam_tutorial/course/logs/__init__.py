"""The logs of the notebooks: the real one where its files are, and its simulated twin everywhere."""
