"""Starting points of `ekfslam new`. They are real models: the package's own tests run them as they are."""
