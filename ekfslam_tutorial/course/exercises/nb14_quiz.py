"""Exercise 14.3 and the self-test of notebook 14: what each structure of the manual is for."""

from ..quiz import Quiz

quiz = Quiz(
    "14.3",
    "Whose number is it?",
    hints=(
        "A robot only carries sensors. A sensor measures. A landmark is what is measured. Obs joins the two.",
        "What the filter believes is in Map, and nowhere else. The others hold the range, where it is.",
        "What changes with every frame and belongs to one sensor and one landmark is in Obs.",
    ),
)
_ROB, _OBS = "Rob holds the motion model and its control.", "That belongs to one sensor *and* one landmark: Obs."
quiz.ask("mean", "d", "the mean and the covariance of a robot's pose?  a: Rob  b: Sen  c: Obs  d: Map",
         "Where is what the filter believes?",
         {"a": "Rob holds the range `r`: where in the map to look. The numbers are in Map."})  # fmt: skip
quiz.ask("noise", "b", "the noise of a camera, in pixels?  a: Rob  b: Sen  c: Lmk  d: Obs",
         "It is the same for all landmarks that this camera sees.",
         {"a": "A robot may carry two cameras with different noise: it belongs to Sen."})  # fmt: skip
quiz.ask("control", "a", "the control of this frame and its covariance U?  a: Rob  b: Sen  c: Tim  d: Map", _ROB,
         {"c": "Tim says how long a step is. What the robot did in it is in Rob."})  # fmt: skip
quiz.ask("innovation", "c", "an innovation z and its covariance Z?  a: Sen  b: Lmk  c: Obs  d: Map", _OBS,
         {"b": "A landmark may be seen by several sensors in one frame: there is an Obs for each pair."})  # fmt: skip
quiz.ask("prior", "b", "the prior n, N of what was not measured at the birth?  a: Sen  b: Lmk  c: Obs  d: Tim",
         "It belongs to the landmark for the whole of its life.",
         {"c": "An Obs is made anew in each frame; the prior was used once, and stays with the landmark."})  # fmt: skip
quiz.ask("dt", "d", "the duration of a step?  a: Rob  b: Map  c: Obs  d: Tim", "It is the same for all robots.",
         {"a": "All robots share one clock: Tim."})  # fmt: skip

self_test = Quiz(
    "14.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each question has its section: structures, one frame, the map, the builder.",
        "A range of None means: this state is known, the filter leaves it alone.",
        "Simulation structures stand for the world; the estimator never reads them.",
    ),
)
self_test.ask("none", "b", "rob.r is None:  a: the robot is lost  b: its pose is known  c: it has no sensor",
              "What is not in the map is known.",
              {"a": "A lost robot has a large covariance, in the map."})  # fmt: skip
self_test.ask("order", "a", "the order in a frame:  a: move, correct known, start new  b: start new, correct, move",
              "A measurement that starts a landmark must not correct it, too.",
              {"b": "Then a new landmark would be corrected by the measurement that has made it."})  # fmt: skip
self_test.ask("two_indices", "c", "Obs has two indices because  a: it has two numbers  b: of time  "
              "c: it joins a sensor and a landmark", "Obs(sen, lmk) in the manual.",
              {"a": "A depth camera has three numbers, and still two indices.",
               "b": "An Obs is of the present frame only."})  # fmt: skip
self_test.ask("sim", "b", "with a real log, the structures SimRob, SimSen, SimLmk are  a: filled from the log  "
              "b: not needed", "What are they for?",
              {"a": "They are the true world, and nobody knows it. Only SimObs has one: the raw data."})  # fmt: skip
self_test.ask("sensor", "a", "a second camera on a robot adds to the map:  a: nothing if its mounting is known  "
              "b: 7 numbers always  c: a robot", "What is not in the map is known.",
              {"b": "Only with frame_in_map: then its own frame is estimated, 7 numbers.",
               "c": "Both cameras ride on the same robot."})  # fmt: skip
