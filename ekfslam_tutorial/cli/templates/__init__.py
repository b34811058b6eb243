"""Starting points of `ekfslam new`. The models are real ones and run as they are."""
