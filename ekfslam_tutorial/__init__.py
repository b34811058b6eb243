"""EKF mapping and EKF-SLAM: a course and a toolbox in Python.

The folders are the floors of a house. Each one builds only on those above it:

``geometry``, ``models``, ``ekf``, ``slam``
    The core, written to be read: numpy and scipy only.
``fast``
    The wing: the same steps, quicker. Nothing in the core imports it.
``simulation``, ``toolbox``, ``datasets``, ``analysis``, ``graphics``
    Worlds, whole SLAM runs, real logs, measures of error, figures.
``course``, ``cli``
    What the notebooks and the command line ``ekfslam`` need.

Import the parts by name, for example ``from ekfslam_tutorial.ekf import Map``. This file imports nothing,
so that using the core never starts the plotting libraries.
"""

__version__ = "0.1.0"
