"""Project 24: active search in images, by a filter of one's own."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...geometry import Frame3
from ...models.landmarks import EucPnt, IdpPnt
from ...models.motion import ConstantVelocity
from ...models.observation import observe
from .. import asks
from ..exercises.nb13_new import new_idp
from ..exercises.nb24_agree import agreeing
from ..exercises.nb24_corner import corner_score
from ..exercises.nb24_inside import inside
from ..exercises.nb24_ncc import ncc
from ..exercises.nb24_patch import patch_of
from ..logs.nb24 import CAMERA, FPS, FRAMES, film, given
from ..project import Project, Symptom, scores
from ..trial import Trial, run_trial

WRONG = 3.0  # px from where a landmark is: such a match is wrong
WRONG_MOST = 0.04  # of all matches: in the first images that show the book moving, its corners still agree

SCENARIO = f"""
name = "from pixels to a map"
seed = 1
time = {{dt = {1 / FPS:.10f}, last = {FRAMES}}}

[[robot]]
motion = "constant_velocity"
vel_std = 0.2
ang_vel_std_deg = 23.0
dv_std = 0.267
dw_std_deg = 23.0

[[sensor]]
type = "davison_cam"
k = [80.0, 60.0, 97.5, 97.5]
k1 = 3.6e-5
image_size = [160.0, 120.0]
margin = 6.0
pixel_std = 0.5

[landmark]
type = "idp_pnt"
non_obs_mean = 1.0
non_obs_std = 0.5
"""

START = SCENARIO.replace(
    "dv_std = 0.267\ndw_std_deg = 23.0\n",
    "# Here: dv_std (m/s) and dw_std_deg, the impulses that the hand may give in one frame of 1/15 s. The hand\n"
    "# accelerates by about 4 m/s^2 and 6 rad/s^2.\n",
).replace(
    'pixel_std = 0.5\n\n[landmark]\ntype = "idp_pnt"\nnon_obs_mean = 1.0\nnon_obs_std = 0.5\n',
    "# Here: pixel_std, and below it the landmarks: six numbers, most things on a desk are 0.5 m to 2 m away.\n",
)

H = 5  # a patch has 2 H + 1 pixels to each side
KINDS = {6: IdpPnt(), 3: EucPnt(3)}
MOUNT = Frame3(np.array([0.0, 0, 0, 1, 0, 0, 0]))  # the camera is the robot


def predict(x, P, u, U, dt):
    """The camera moves: its 13 numbers are [t, q, v, w], its control an impulse that is not known."""
    x, P = x.copy(), P.copy()
    x[:13], X_x, X_u = ConstantVelocity().move(x[:13], u, dt)
    P[:13] = X_x @ P[:13]
    P[:, :13] = P[:, :13] @ X_x.T
    P[:13, :13] += X_u @ U @ X_u.T
    return x, P


def expected(x, r, camera):
    """Where the landmark in the range r should be seen: pixel, its Jacobian H (2, n) by the map; is it in view?"""
    F, kind = Frame3(x[:7]), KINDS[r.stop - r.start]
    e, E_r, _, E_l = observe(F, MOUNT, camera, kind, x[r])
    H_x = np.zeros((2, len(x)))
    H_x[:, :7], H_x[:, r] = E_r, E_l
    return e, H_x, bool(camera.visible(e, F.to_frame(kind.point(x[r])[0])[0]))


def find(image, patch, e, S):
    """Where the patch fits best inside the 3-sigma ellipse, and how well; -1 if no pixel of the image is in it."""
    reach, size = 3 * np.sqrt(np.diag(S)), np.array(image.shape[::-1])
    low = np.maximum(np.ceil(e - reach), H).astype(int)
    high = np.minimum(np.floor(e + reach), size - 1 - H).astype(int)
    u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    pixels = pixels[np.asarray(inside(pixels, e, S, 3), bool)]
    if not len(pixels):
        return e, -1.0
    views = sliding_window_view(image, (2 * H + 1, 2 * H + 1))[pixels[:, 1] - H, pixels[:, 0] - H]
    score = ncc(patch, views)
    return pixels[np.argmax(score)].astype(float), np.max(score)


def best_corners(image, taken, n):
    """At most n corners of the image (px), the best first; 10 px or more from each other, and from what is taken."""
    v, u = (a.ravel() for a in np.mgrid[8 : image.shape[0] - 8 : 2, 8 : image.shape[1] - 8 : 2])
    score = corner_score(sliding_window_view(image.astype(float), (7, 7))[v - 3, u - 3])
    new = []
    for i in np.argsort(-score):
        y = np.array([u[i], v[i]], float)
        if len(new) >= n or score[i] < 0.03 * score.max():
            break
        if all(np.linalg.norm(y - other) >= 10 for other in [*taken, *new]):
            new.append(y)
    return new


def correct(x, P, z, H_x, R):
    """One joint correction with K matches: z (K, 2), H_x (K, 2, n); the quaternion is brought back to length 1."""
    H_x, R = H_x.reshape(-1, len(x)), np.kron(np.eye(len(z)), R)
    Z = H_x @ P @ H_x.T + R
    K = np.linalg.solve(Z, H_x @ P).T
    x, P = x + K @ z.ravel(), P - K @ Z @ K.T
    F, F_x = Frame3(x[:7]).normalized()
    x[:7], P[:7] = F.x, F_x @ P[:7]
    P[:, :7] = P[:, :7] @ F_x.T
    return x, (P + P.T) / 2


def born(x, P, camera, y, n, N):
    """A landmark of six numbers from one pixel, at the end of the map, by exercise 13.2."""
    F, prior = Frame3(x[:7]), (camera, y, camera.R, n, N)
    l, P_ll, _ = new_idp(F, P[:7, :7], *prior)
    P_lx = new_idp(F, np.eye(7), *prior)[2] @ P[:7]  # with P_F = I it returns L_F
    return np.append(x, l), np.block([[P, P_lx.T], [P_lx, P_ll]]), slice(len(x), len(x) + 6)


def without(x, P, lmks, id):
    """The map without one landmark."""
    r = lmks[id]
    n, keep = r.stop - r.start, np.delete(np.arange(len(x)), r)
    behind = lambda s: slice(s.start - n, s.stop - n) if s.start > r.start else s
    return x[keep], P[np.ix_(keep, keep)], {i: behind(s) for i, s in lmks.items() if i != id}


def known_corners(x, P, corners, camera, image):
    """Put corners whose places are known to 2 mm into the map, ids 1, 2, ...: x, P, their ranges, their patches."""
    lmks, looks = {}, {}
    for id, corner in enumerate(corners, 1):
        n = len(x)
        lmks[id], x = slice(n, n + 3), np.append(x, corner)
        P = np.block([[P, np.zeros((n, 3))], [np.zeros((3, n)), 0.002**2 * np.eye(3)]])
        looks[id] = patch_of(image, camera.project(corner)[0], H)[0]
    return x, P, lmks, looks


def loop(world):
    """Active search: from images to a map. Yield it after each frame.

    world.x, shape (13,), and world.P, shape (13, 13), are the camera [t, q, v, w] before the first frame, and
    `known_corners` puts the four corners of world.given into the map, with the first image. `for now in world` goes
    through the frames: now.image[1] is the image, now.u[1], now.U[1] and now.dt are for `predict`, and now.k counts
    from 1. world.sens[0].model is the camera, world.options.n and world.options.N are the prior of 1/distance.
    now.seen[1] is an empty list: append a pair (id, pixel) for each match that you correct with, and for each landmark
    that you start. Somebody will push a book across the desk. Keep 12 landmarks found in each frame; delete those that
    were looked for 6 times or more and used in less than half of them.
    Yield x, P, lmks after each frame: the whole map, the camera first, and a dictionary id: slice.
    """
    camera, n, N = world.sens[0].model, world.options.n, world.options.N
    x, P, lmks, tried, used, next_id = world.x, world.P, None, {}, {}, 5
    for now in world:
        image, taken, matches = now.image[1], [], []
        x, P = predict(x, P, now.u[1], now.U[1], now.dt)
        if lmks is None:
            x, P, lmks, looks = known_corners(x, P, world.given, camera, image)
        for id, r in lmks.items():
            e, H_l, there = expected(x, r, camera)
            if there:
                taken.append(e)
                tried[id] = tried.get(id, 0) + 1
                y, score = find(image, looks[id], e, H_l @ P @ H_l.T + camera.R)
                if score > 0.8:
                    matches.append((id, y, y - e, H_l))
        good = 0
        if matches:
            ids, ys, z, H_x = (np.array(a) for a in zip(*matches, strict=True))
            J = np.concatenate(H_x)
            E = (J @ P @ J.T).reshape(len(z), 2, len(z), 2)
            keep = np.asarray(agreeing(z, E, camera.R, 1.5), bool)
            x, P = correct(x, P, z[keep], H_x[keep], camera.R)
            now.seen[1] += list(zip(ids[keep].tolist(), ys[keep], strict=True))
            used |= {id: used.get(id, 0) + 1 for id in ids[keep].tolist()}
            good = int(keep.sum())
        for id in [id for id in lmks if tried.get(id, 0) >= 6 and used.get(id, 0) < 0.5 * tried[id]]:
            x, P, lmks = without(x, P, lmks, id)
        for y in best_corners(image, taken, 12 - good if now.k == 1 else min(12 - good, 3)):
            x, P, lmks[next_id] = born(x, P, camera, y, n, N)
            looks[next_id] = patch_of(image, y, H)[0]
            now.seen[1].append((next_id, y))
            next_id += 1
        yield x, P, lmks


# ---- the run, measured ----------------------------------------------------------------------------------------------


@dataclass
class FilmTrial(Trial):
    """One run on a film: besides errors and NEES, which matches are right, and where the landmarks truly are."""

    log: Any = None
    points: dict = field(default_factory=dict)  # by id: where it truly is, and whether it stays there
    matches: list = field(default_factory=list)  # by frame: (right, wrong, in view)
    before: set = field(default_factory=set)  # ids in the frame before

    def add(self, world, estimate, reckoning):
        """Measure one frame; what the loop says that it has found goes into the picture, for the figures."""
        picture, k, camera = world._now.raw[1], world.k - 1, Frame3(world._now.truth[1])
        said = [(int(id), np.asarray(y, float).reshape(2)) for id, y in world.view.seen[1]]
        picture.ids = np.array([id for id, _ in said], int)
        picture.y = np.array([y for _, y in said]).reshape(-1, 2)
        new = set(estimate.lmks) - self.before
        for id, y in said:
            if id in new and id > 4:
                p, stays = self.log.truths(k, y)
                self.points[id] = p[0], bool(stays[0])
        if k == 0:
            self.points |= {id: (p, True) for id, p in enumerate(self.log.corners, 1)}
        off = [(id, self.offset(camera, id, y)) for id, y in said if id in self.points and id in self.before]
        right = sum(d < WRONG for _, d in off)
        views = [self.seen_from(camera, self.points[id][0]) for id in self.before if id in self.points]
        self.matches.append((right, len(off) - right, sum(views)))
        self.before = set(estimate.lmks)
        super().add(world, estimate, reckoning)

    @staticmethod
    def seen_from(camera, p):
        """Return True if the point is in view."""
        p = camera.to_frame(p)[0]
        return bool(np.isfinite(p).all() and p[2] > 0 and CAMERA.visible(CAMERA.project(p)[0], p))

    def offset(self, camera, id, y):
        """How far a match is from where the landmark is, if that has stayed where it was (px)."""
        p = camera.to_frame(self.points[id][0])[0]
        return float(np.linalg.norm(CAMERA.project(p)[0] - y)) if p[2] > 0 else np.inf

    def finish(self, world, estimate):
        """Measure the map at the end, but for what is on the book."""
        self.known = set(estimate.lmks)
        for id, r in estimate.lmks.items():
            p, stays = self.points.get(id, (np.full(3, np.nan), False))
            if stays and np.isfinite(p).all():
                place, P_l = KINDS[r.stop - r.start].point(estimate.x[r])
                P, e = P_l @ estimate.P[r, r] @ P_l.T, place - p
                if np.isfinite(P).all():
                    far = np.linalg.norm(p - estimate.x[:3])
                    self.landmarks.append(
                        (np.linalg.norm(e), np.sqrt(np.trace(P)), float(e @ np.linalg.pinv(P) @ e) / 3, far)
                    )


class FromPixels(Project):
    """A project on films: what is judged is rendered for each seed, and its truth is known."""

    beside_reference = False

    def trial(self, run, seed, watch=None):
        """Run the loop on the film of this seed."""
        log = film(seed)
        return run_trial(run.data, run.loop, seed, self.limit, log, watch, FilmTrial(seed, log=log), given(log, seed))

    def measured(self, trials, reference=None):
        """What the sentences of the verdict are about."""
        return _Measured(trials)

    def summary(self, trials):
        """One line on some runs."""
        if any(t is None or t.failed or not t.errors for t in trials):
            return "no result"
        s = _Measured(trials)
        runs = f"{len(trials)} films of {s.frames} images" if len(trials) > 1 else f"{s.frames} images"
        return (
            f"{runs}: mean NEES {s.nees:.1f} (honest 6, band {self.band[0]:g} to {self.band[1]:g}), camera off by "
            f"{1000 * s.error:.0f} mm at the end, {s.found:.0f} landmarks found in an image, {100 * s.share:.0f} % of "
            f"those in view, {100 * s.wrong:.1f} % of the matches wrong, median error of a landmark "
            f"{1000 * s.landmark_error:.0f} mm"
        )


class _Measured:
    """Numbers of some runs."""

    def __init__(self, trials):
        s = scores(trials)
        self.nees, self.first, self.last, self.frames = s.nees, s.first, s.last, s.frames
        self.error, self.sigma, self.dead_error, self.dead_sigma = s.error, s.sigma, s.dead_error, s.dead_sigma
        self.landmark_error, self.landmark_nees, self.seconds, self.size = (
            s.landmark_error, s.landmark_nees, s.seconds, s.size,
        )  # fmt: skip
        rows = np.array([t.matches for t in trials], float)  # (trials, frames, 3)
        third = max(rows.shape[1] // 3, 1)
        right, wrong, views = rows.sum((0, 1))
        self.said = right + wrong
        self.wrong = wrong / max(self.said, 1)
        self.share = right / max(views, 1)
        self.found = float(rows[:, -third:, 0].mean())
        self.percent, self.percent_wrong, self.mm = 100 * self.share, 100 * self.wrong, 1000 * self.error


SYMPTOMS = (
    Symptom(
        "the matches",
        lambda s, p: s.said == 0,
        "now.seen[1] has no match in any frame",
        "Append (id, pixel) to now.seen[1] for each match that you correct with, and for each landmark that you start: "
        "`now.seen[1].append((id, y))`. If you do: does the search ever find a patch? S is H P H' + R, in px^2.",
    ),
    Symptom(
        "on its way",
        lambda s, p: s.share < 0.15,
        "the camera is off by {s.error:.1f} m at the end, and {s.percent:.0f} % of the landmarks in view are found",
        "It is lost after few frames. z = y - e, found minus expected? Does each match keep its own landmark: z, H_x "
        "and id in the same order? Does each landmark keep its own patch, and its range in `lmks`?",
    ),
    Symptom(
        "the noise of the motion",
        lambda s, p: np.isinf(s.nees),
        "P of the camera is singular in most frames: a part of its pose is claimed to be known exactly",
        "`predict` in every frame, with now.U[1]: the hand accelerates in between.",
    ),
    Symptom(
        "the share found",
        lambda s, p: s.share < 0.5,
        "only {s.percent:.0f} % of the landmarks in view are found and used",
        "Is the ellipse large enough: S = H P H' + R, with now.U[1] in P? A threshold near 0.9 refuses patches that "
        "are seen from the side; `agreeing` with a limit below 1 px refuses good matches.",
    ),
    Symptom(
        "the map",
        lambda s, p: s.found < 7,
        "{s.found:.1f} landmarks are found in an image in the last third of the film, 12 are wanted",
        "The camera turns away from its first landmarks. Are new ones started in every frame in which fewer than 12 "
        "are found, at most 3 in a frame? Does each get its patch, its range in `lmks`, and an id that nobody had?",
    ),
    Symptom(
        "wrong matches",
        lambda s, p: s.wrong > WRONG_MOST,
        "{s.percent_wrong:.0f} % of the matches that you corrected with are more than 3 px from where the landmark is",
        "A book is pushed across the desk: its corners look right and are not. Does `agreeing` see the innovations of "
        "*all* matches of a frame and their joint E, and do you correct with those only that it keeps? The limit is "
        "1.5 px, 3 sigma of a pixel.",
    ),
    Symptom(
        "corrections",
        lambda s, p: s.sigma > 0.5 * s.dead_sigma,
        "the camera claims {s.sigma:.2f} m; without any image it would be {s.dead_sigma:.2f} m",
        "Landmarks are found, and P does not know it: P - K Z K' belongs to every correction.",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees > p.band[1],
        "the mean NEES is {s.nees:.1f} (band {p.band[0]:g} to {p.band[1]:g}, honest 6): {s.first:.1f} in the first "
        "third, {s.last:.1f} in the last",
        "Too sure. The impulses of the hand in one frame (4 m/s^2 and 6 rad/s^2, for 1/15 s each)? A pixel that is "
        "rounded has an error of 0.3 px, a patch seen from the side more: pixel_std 0.5. A prior of 1/distance that "
        "excludes what is near? A landmark that is started and corrected in the same frame?",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees < p.band[0],
        "the mean NEES is {s.nees:.2f} (band {p.band[0]:g} to {p.band[1]:g}, honest 6)",
        "Too cautious: a pixel_std of more than a pixel, or impulses of the hand that are far too large?",
    ),
    Symptom(
        "the error",
        lambda s, p: s.error > 0.06,
        "the camera is off by {s.mm:.0f} mm in the last third; 60 mm at most is asked for",
        "Honest, but it learns little: 12 landmarks found in every frame? All of them corrected with at once?",
    ),
    Symptom(
        "the landmarks",
        lambda s, p: s.landmark_nees > 5,
        "the camera is right, the landmarks are not: their NEES over 3 is {s.landmark_nees:.1f} in the median (at most 5)",
        "Look at the birth: does it use the pixel of the corner, P of the camera, and the prior n and N?",
    ),
)

project = FromPixels(
    "24.project",
    "From pixels to a map",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "A frame has six parts: predict; look for every landmark in view (`expected`, `find`, a correlation above 0.8); "
        "throw out what does not agree (`agreeing`, with E = H P H' of all matches at once); `correct` with the rest; "
        "delete what is hardly ever found; start new ones with `best_corners`, `born` and `patch_of`.",
        "rows = H_x.reshape(-1, len(x)) of all K matches; E = (rows @ P @ rows.T).reshape(K, 2, K, 2); keep = "
        "agreeing(z, E, camera.R, 1.5); x, P = correct(x, P, z[keep], H_x[keep], camera.R). In the first image 12 are "
        "started, later at most 3; `best_corners` must stay away from the pixels e of all landmarks in view. In the "
        "scenario: dv_std = 4 / 15, dw_std_deg = 6 / 15 rad in degrees, pixel_std = 0.5, an inverse distance of 1 +- 0.5.",
    ),
    asks=(
        asks.robots("constant_velocity"),
        asks.sensors("davison_cam"),
        asks.landmarks("idp_pnt"),
        asks.frames(FRAMES, FRAMES),
        asks.estimated(),
    ),
    band=(1.0, 12.0),
    symptoms=SYMPTOMS,
    seeds=(101, 102, 103),
    seconds=60.0,
)
