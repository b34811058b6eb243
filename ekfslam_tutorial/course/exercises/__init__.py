"""The exercises: per notebook the modules ``nbNN_topic.py`` and the self-tests ``nbNN_quiz.toml``, found by name."""
