"""The projects of the course: a scenario, the loop of a filter, what the task asks for and what a run may show."""
