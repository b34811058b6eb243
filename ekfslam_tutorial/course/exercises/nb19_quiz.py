"""The self-test of notebook 19."""

from ..quiz import Quiz

self_test = Quiz(
    "19.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question: the truck, the two gates, upkeep, GPS, cost.",
        "What moves sideways? What is a detection in between? Who was looked for? Is GPS the truth? What has n^2 "
        "numbers?",
        "The laser swings around the axle; in between is used for nothing; only in view counts; P has n^2 numbers.",
    ),
)
self_test.ask(
    "mount",
    "b",
    "the truck turns left on the spot of its rear axle; the laser, 3.8 m ahead, moves  a: not  b: left  c: forward",
    "w times the arm, turned by 90 degrees to the left: the arm points forward.",
    {
        "a": "Only the axle stays. Stretch out your arm and turn: what does your hand do?",
        "c": "The arm is forward; its velocity is at a right angle to it.",
    },
)
self_test.ask(
    "between",
    "c",
    "a detection is too far to be a known tree and too near to be a new one:  a: take the tree  b: new tree  c: no use",
    "What does a wrong match cost, what a double tree, and what a detection that is not used?",
    {
        "a": "A wrong match bends the map for good (notebook 07).",
        "b": "A second copy of a tree steals the detections of the first.",
    },
)
self_test.ask(
    "deletion",
    "a",
    "a tree is behind the truck for 500 scans. Its count of searches grows by  a: 0  b: 500  c: till it is deleted",
    "Was it looked for?",
    {
        "b": "Then every tree would be deleted as soon as the truck has passed it.",
        "c": "It is not looked for while it is out of view: nothing is counted.",
    },
)
self_test.ask(
    "gps",
    "b",
    "path and GPS are 3 m apart. Whose error is it?  a: the path's  b: GPS alone cannot tell  c: that of GPS",
    "Trees stand beside a receiver, too.",
    {
        "a": "GPS under trees is off by metres, sometimes by a hundred.",
        "c": "It may be; or the path is off. A fix has an error of its own.",
    },
)
self_test.ask(
    "cost",
    4,
    "a large map gets twice as large: a correction with one tree takes how many times as long?",
    "Which matrix does a correction read and write, and how many numbers does it have?",
    {
        2: "P has (3 + 2 n)^2 numbers, and all of them change.",
        8: "That is for inverting a full matrix; Z is 2 x 2 here. P - W W' touches each number of P once.",
        1: "All of P changes: even trees that are out of view.",
    },
)
