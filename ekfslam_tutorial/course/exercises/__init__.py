"""The exercises: one module ``nbNN.py`` per notebook (or several, ``nbNN_topic.py``), found by name."""
