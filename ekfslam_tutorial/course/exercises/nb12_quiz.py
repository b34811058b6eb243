"""The self-test of notebook 12."""

from ..quiz import Quiz

self_test = Quiz(
    "12.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each question has its section: three steps, the fold, the chain, the way back, calibration.",
        "The lens works on [x/z, y/z], before there are pixels. Its map has an inverse only up to the fold.",
        "A parameter is seen only where it moves pixels: look at the arrows of its column.",
    ),
)
self_test.ask(
    "order",
    "b",
    "the order of the steps:  a: project, pixellise, distort  b: project, distort, pixellise  c: distort, project",
    "Light goes through the lens before it meets the pixels.",
    {
        "a": "In pixels r^2 is about 100000: the lens would be thousands of times too strong.",
        "c": "The lens bends directions, and a direction is there only after the division by z.",
    },
)
self_test.ask(
    "behind",
    "a",
    "a point behind the camera:  a: has the pixel of -p, z must be tested  b: has a pixel outside the image  c: error",
    "Put -x, -y, -z into x/z and y/z.",
    {
        "b": "Both signs cancel in x/z: the pixel may be in the very middle.",
        "c": "Only z = 0 is a trouble for the formula.",
    },
)
self_test.ask(
    "jacobian",
    "c",
    "U_l, the derivative by a point of the world, is  a: U_ls  b: LR_l LS_lr U_ls  c: U_ls LS_lr LR_l",
    "The names chain from the output to the input: inner names are equal.",
    {
        "a": "That is by the point in the frame of the camera.",
        "b": "Shapes and names do not chain: 2 x 3 must stand in front.",
    },
)
self_test.ask(
    "back",
    "c",
    "the exact inverse of distort(up, d) is  a: distort(ud, -d)  b: ud / f(ud)  c: found by iteration",
    "Which of the curves in section 4 stays at zero?",
    {
        "a": "Off by tens of pixels at the border of the image: r is not the same on both ways.",
        "b": "That is one step of the iteration: f must be taken at up.",
    },
)
self_test.ask(
    "calibrate",
    "b",
    "all points near the middle of the image. One learns  a: k and d  b: k, but not d  c: d, but not k",
    "How far does d move a pixel near the middle? Look at the arrows.",
    {
        "a": "U_d grows with the third power of the radius: in the middle it is nearly zero.",
        "c": "d is felt at the border of the image, and only there.",
    },
)
