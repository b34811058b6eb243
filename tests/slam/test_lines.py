"""Lines in the filter: honest in their four degrees of freedom, in one map with points, and remembered as far as seen.

The statistics are those of single lines: a robot whose steps are noisy sees one edge from a few places. The noise is
small, so what is tested is every derivative on the way, births included, and not how a linear filter copes with a lens.
"""

import numpy as np
import pytest

from ekfslam_tutorial.analysis.factors import graph_of
from ekfslam_tutorial.cli.files import scenarios
from ekfslam_tutorial.ekf import Map, chi_square, transform, update
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models import observe, retro_project
from ekfslam_tutorial.models.landmarks import AhmLin, AplLin, EucPnt, HmgLin, IdpLin, PlkLin
from ekfslam_tutorial.models.landmarks.lines import offsets
from ekfslam_tutorial.models.motion import Odometry3
from ekfslam_tutorial.models.observation import check_fit
from ekfslam_tutorial.models.sensors import PinHole, SegmentCam
from ekfslam_tutorial.simulation import SimLmk, SimRob, SimSen, sim_observation, worlds
from ekfslam_tutorial.slam import Lmk, Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, new_map, place
from ekfslam_tutorial.slam.upkeep import tidy_line
from ekfslam_tutorial.toolbox import UserData, universal_slam
from ekfslam_tutorial.toolbox.run_state import run_state

TYPES = [PlkLin(), AplLin(), IdpLin(), HmgLin(), AhmLin()]
NAMES = [type(kind).__name__ for kind in TYPES]
LENSES = {"no lens": (), "lens": (-0.3, 0.1)}
RUNS, FRAMES = 100, 3
EDGE = np.array([6.0, -1.0, 0.4, 7.0, 1.5, 1.2])
SIDE = np.array([0.0, 0.0, 0.5, 0.5, -0.5, 0.5, -0.5])  # a camera that looks forward
START = Frame3(np.eye(7)[3])
STEP = np.array([0.1, 0.3, 0.1, 0.02, -0.03, 0.01])
U = np.diag([2e-3, 2e-3, 2e-3, 5e-4, 5e-4, 5e-4]) ** 2
each_type = pytest.mark.parametrize("kind", TYPES, ids=NAMES)


def true_prior(kind, camera):
    """The prior's numbers of the true edge, seen from the first place: those with which its birth is right."""
    start = Frame3(np.eye(7)[3])
    p = Frame3(SIDE).to_frame(EDGE.reshape(2, 3))[0]
    if not isinstance(kind, PlkLin | AplLin):
        return 1 / np.linalg.norm(p, axis=1)
    y = camera.segments(p.reshape(6))[0]
    basis = retro_project(start, Frame3(SIDE), camera, PlkLin(), y, np.zeros(2))[4][3:]  # e1, e2 in the world
    l, *_ = retro_project(start, Frame3(SIDE), camera, PlkLin(), y, np.array([1.0, 0.0]))
    way = EDGE[3:] - EDGE[:3]
    moment = np.cross(EDGE[:3] - SIDE[:3], way)
    return basis.T @ way / (moment @ (l[:3] - np.cross(SIDE[:3], l[3:])))


def seen_from_a_few_places(kind, camera, seed, n_true, std=0.01, frames=FRAMES, **options):
    """Map, robot and landmark after some frames of one run, and its true pose; the prior is right, too."""
    rng = np.random.default_rng(seed)
    map, lmks, obs = new_map(), {}, {}
    true = SimRob(1, "", Odometry3(), np.eye(7)[3], STEP)
    rob, sen = Rob(1, Odometry3(), U=U), Sen(1, 1, camera, Frame3, x=SIDE)
    place(map, rob, true.x, np.zeros((7, 7)))
    world = SimLmk(np.zeros(0, int), np.zeros((0, 3)), np.array([1]), EDGE[None])
    n = n_true + std * rng.normal(size=2)
    opt = Options(lmk_type=kind, n=n, N=std**2 * np.eye(2), **options)
    for k in range(frames):
        if k:
            true.x = true.motion.move(true.x, STEP, 1.0)[0]
            rob.u = STEP + rng.multivariate_normal(np.zeros(6), U)
            move(map, rob, 1.0)
        raw = sim_observation(true, SimSen(1, "", 1, Frame3(SIDE), camera), world, rng)
        _, new = correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        init_new_lmks(map, rob, sen, lmks, raw, new, opt)
    return map, lmks[1], obs


@each_type
@pytest.mark.parametrize("lens", LENSES)
def test_the_four_degrees_of_freedom_are_honest(kind, lens):
    """The mean NEES of 100 runs is chi-square with 400 degrees of freedom over 100: inside its 99 % band."""
    camera = SegmentCam(d=LENSES[lens], pixel_std=0.1)
    n, nees = true_prior(kind, camera), []
    for seed in range(RUNS):
        map, lmk, _ = seen_from_a_few_places(kind, camera, seed, n)
        e, E_l = offsets(kind, lmk.state(map), EDGE[:3], EDGE[3:])
        nees.append(e @ np.linalg.solve(E_l @ map.block(lmk.r) @ E_l.T, e))
    low, high = (chi_square.quantile(p, 4 * RUNS) / RUNS for p in (0.005, 0.995))
    assert low < np.mean(nees) < high


def mean_nees(kind, std, runs=40):
    """Mean of 40 NEES in four degrees of freedom, of lines seen from ten places with a pixel of noise."""
    camera, nees = SegmentCam(pixel_std=1.0), []
    n = true_prior(kind, camera)
    for seed in range(runs):
        map, lmk, _ = seen_from_a_few_places(kind, camera, seed, n, std=std, frames=10)
        e, E_l = offsets(kind, lmk.state(map), EDGE[:3], EDGE[3:])
        nees.append(e @ np.linalg.solve(E_l @ map.block(lmk.r) @ E_l.T, e))
    return np.mean(nees)


@pytest.mark.parametrize("kind, std", [(IdpLin(), 0.05), (AplLin(), 0.1)], ids=["idp_lin", "apl_lin"])
def test_anchored_lines_hold_a_wide_prior(kind, std):
    """The mean is 0.16 1/m: inside the 99 % band of 40 runs. `far_lines` in `analysis/notes.py` warns of `plk_lin`."""
    low, high = (chi_square.quantile(p, 4 * 40) / 40 for p in (0.005, 0.995))
    assert low < mean_nees(kind, std) < high


@each_type
def test_a_line_is_known_across_and_not_along(kind):
    """Its state may have more numbers than four; the ends are parameters, and no state depends on them."""
    camera = SegmentCam(pixel_std=0.1)
    map, lmk, obs = seen_from_a_few_places(kind, camera, 1, true_prior(kind, camera))
    P = map.block(lmk.r)
    assert len(lmk.par) == 2 and lmk.par[0] < lmk.par[1] and P.shape == (kind.size, kind.size)
    o = obs[1, 1]
    assert o.updated and o.z.shape == (2,) and o.E.shape == o.R.shape == (2, 2) and o.e.shape == (3,)
    p, spread = lmk.ends(map)
    np.testing.assert_allclose(p, EDGE.reshape(2, 3), atol=0.5)
    assert spread.shape == (2, 3, 3) and (np.linalg.eigvalsh(spread) > -1e-12).all()


@pytest.mark.parametrize("kind", TYPES[:2], ids=NAMES[:2])
def test_a_plucker_line_keeps_its_condition(kind):
    """A correction does not know that n' v = 0; the normal form brings it back, and P knows it, too."""
    camera = SegmentCam(pixel_std=2.0)
    map, lmk, _ = seen_from_a_few_places(kind, camera, 3, true_prior(kind, camera), std=0.1)
    l, P = lmk.state(map), map.block(lmk.r)
    n, v = l[-6:-3], l[-3:]
    assert abs(n @ v) < 1e-12
    across = np.concatenate([np.zeros(kind.size - 6), v, n])
    assert across @ P @ across < 1e-12 * np.trace(P)


def test_an_anchored_pluecker_line_is_honest_with_a_wide_prior():
    """Edges with depths from 2 m to 20 m, known poses, a prior that is worth nothing: the mean NEES in its 99.9 % band.

    It is not, by far, if n gives way to n' v = 0, as it does in a line without an anchor.
    """
    rng, camera, nees = np.random.default_rng(1), SegmentCam(pixel_std=1.0), {AplLin(): [], PlkLin(): []}
    eyes = [Frame3(np.array([s, 0.6 * s, 0, 1, 0, 0, 0])) for s in np.linspace(0, 1, 5)]
    while len(nees[AplLin()]) < 60:
        u = np.append(rng.uniform([-0.6, -0.45], [0.6, 0.45], (2, 2)), np.ones((2, 1)), 1)
        edge = u / np.linalg.norm(u, axis=1)[:, None] * np.exp(rng.uniform(np.log(2), np.log(20), (2, 1)))
        y, seen = zip(*[camera.segments((edge - S.t).reshape(6)) for S in eyes], strict=True)
        if np.linalg.norm(u[0] - u[1]) < 0.3 or not all(seen):
            continue
        y = y + rng.normal(size=(5, 4))
        for kind, found in nees.items():
            map, n = Map(), np.array([0.25, 0.0])
            l, _, _, L_y, L_n = retro_project(eyes[0], START, camera, kind, y[0], n)
            r = map.add(l, L_y @ camera.R @ L_y.T + 0.25**2 * L_n @ L_n.T)
            for S, y_k in zip(eyes[1:], y[1:], strict=True):
                e, _, _, E_l = observe(S, START, camera, kind, map.x[r])
                z, Z_y, Z_e = camera.innovation(y_k, e)
                update(map, [(r, -Z_e @ E_l)], z, Z_y @ camera.R @ Z_y.T)
                transform(map, r, *kind.normalized(map.x[r]))
            d, D = offsets(kind, map.x[r], *edge)
            found.append(d @ np.linalg.solve(D @ map.block(r) @ D.T, d))
    low, high = (chi_square.quantile(p, 4 * 60) / 60 for p in (0.0005, 0.9995))
    assert low < np.mean(nees[AplLin()]) < high
    assert np.median(nees[PlkLin()]) > high


@pytest.mark.parametrize("ends", ["extend", "keep"])
def test_the_ends_grow_by_what_is_seen(ends):
    """A camera that turns along an edge sees it in parts: in the end all of it is remembered, or the first part."""
    camera, edge = SegmentCam(pixel_std=0.1), np.array([4.0, -6.0, 1.0, 4.0, 6.0, 1.0])
    map, lmks, rng = new_map(), {}, np.random.default_rng(0)
    rob, sen, opt = Rob(1, Odometry3(), U=1e-8 * np.eye(6)), Sen(1, 1, camera, Frame3, x=SIDE), None
    true = SimRob(1, "", Odometry3(), np.eye(7)[3], None)
    place(map, rob, true.x, np.zeros((7, 7)))
    world = SimLmk(np.zeros(0, int), np.zeros((0, 3)), np.array([1]), edge[None])
    opt = Options(lmk_type=IdpLin(), n=[0.2], N=[[0.01]], ends=ends)
    lengths = []
    for turn in [0.0, 0.1, 0.2, 0.3, -0.2, -0.4, -0.4]:
        rob.u = np.array([0.05, 0.3 * np.sign(turn), 0.2, 0, 0, turn])
        true.x = true.motion.move(true.x, rob.u, 1.0)[0]
        move(map, rob, 1.0)
        raw = sim_observation(true, SimSen(1, "", 1, Frame3(SIDE), camera), world, rng)
        _, new = correct_known_lmks(map, rob, sen, lmks, {}, raw, opt)
        init_new_lmks(map, rob, sen, lmks, raw, new, opt)
        lengths.append(np.ptp(lmks[1].ends(map)[0][:, 1]))
    if ends == "extend":
        assert lengths[-1] > 1.3 * lengths[0]
    else:
        assert np.ptp(lmks[1].par - [0, 1]) < 1e-9


def test_points_and_lines_are_each_for_their_own_sensor():
    camera, lines = PinHole(), SegmentCam()
    with pytest.raises(TypeError, match="PlkLin cannot be started by PinHole"):
        check_fit(camera, PlkLin(), "from_ray")
    with pytest.raises(TypeError, match="EucPnt cannot be observed by SegmentCam: it has no method normal"):
        check_fit(lines, EucPnt())


def test_false_segments_are_edges_that_are_not_there(rng):
    ids, points, segment_ids, segments = worlds.house()
    world = SimLmk(ids, points, segment_ids, segments)
    rob = SimRob(1, "", Odometry3(), np.array([-6.0, 0, 1, 1, 0, 0, 0]), None)
    raw = sim_observation(rob, SimSen(1, "", 1, Frame3(SIDE), SegmentCam(), clutter=5.0), world, rng, rng)
    false = raw.y[raw.ids == -1]
    assert len(false) and false.shape[1] == 4 and set(raw.ids[raw.ids > 0]) <= set(segment_ids)
    assert world.lims.shape == (3, 2) and world.center[0] == 0


def test_worlds_of_edges_number_them_behind_their_points():
    ids, points, segment_ids, segments = worlds.house(corners=True)
    assert len(points) == len(ids) and segments.shape == (23, 6) and segment_ids[0] == ids[-1] + 1
    assert all((points == end).all(1).any() for end in segments.reshape(-1, 3))
    ids, points, segment_ids, segments = worlds.columns()
    assert len(segments) == 36 and (segments[:, :2] == segments[:, 3:5]).all() and len(points) == 72


# --- in scenarios ----------------------------------------------------------------------------------------------------


def house(**overrides):
    few = {"time.last": 3} | {key.replace("__", "."): value for key, value in overrides.items()}
    return UserData.from_toml(scenarios()["house_idp"], few)


def test_what_lines_cannot_do_is_one_sentence():
    with pytest.raises(ValueError, match="sensor 1: lines are told apart by their ids only, known_ids, got Jcbb"):
        house(options__association="jcbb")
    with pytest.raises(ValueError, match="sensor 1 measures lines; the smoother knows points only"):
        graph_of(house())
    with pytest.raises(TypeError, match="sensor 1: IdpPnt landmarks cannot be started by a SegmentCam"):
        house(landmark__type="idp_pnt")


def test_a_run_of_lines_goes_on_where_it_stopped():
    """The ends are no states; but they are kept with the rest."""
    *_, whole = universal_slam(house())
    run = universal_slam(house())
    next(run)
    kept = run_state(next(run), house())
    *_, resumed = universal_slam(house(), resume=kept)
    assert (resumed.map.x == whole.map.x).all()
    assert all((resumed.lmks[id].par == lmk.par).all() for id, lmk in whole.lmks.items())


# --- the ends that are remembered ---


def one_line(P=None, **options):
    """A camera at the origin that looks forward, and a line along y, 5 m ahead: its first point is at y = -1."""
    map, kind = new_map(), HmgLin()
    rob, sen = Rob(1, Odometry3(), x=np.eye(7)[3]), Sen(1, 1, SegmentCam(), Frame3, x=SIDE)
    l = np.array([5.0, -1.0, 0.0, 1.0, 5.0, 0.0, 0.0, 1.0])  # support: p0 + t [0, 1, 0]
    lmk = Lmk(1, kind, x=l) if P is None else Lmk(1, kind, r=map.add(l, P))
    look = lambda y1, y2: tidy_line(map, rob, sen, lmk, seen(y1, y2), Options(lmk_type=kind, **options))
    seen = lambda y1, y2: SegmentCam().segments(
        Frame3(SIDE).to_frame(np.array([[5.0, y1, 0], [5.0, y2, 0]]))[0].reshape(6)
    )[0]
    return map, lmk, look


def test_of_a_line_that_is_well_known_the_outermost_ends_are_kept():
    """Whichever end comes first in the image; abscissas are metres from y = -1 here."""
    _, lmk, look = one_line()
    for (y1, y2), kept in (
        ((0.0, 1.0), (1, 2)),
        ((0.2, 0.8), (1, 2)),
        ((1.5, 0.5), (1, 2.5)),
        ((-0.5, 0.1), (0.5, 2.5)),
    ):
        look(y1, y2)
        assert np.allclose(lmk.par, kept, atol=1e-9)
    _, lmk, look = one_line(ends="keep")
    look(0.0, 1.0), look(-1.0, 2.0)
    assert np.allclose(lmk.par, (1, 2), atol=1e-9)


@pytest.mark.parametrize("factor, kept", [(0.99, (1, 2)), (1.01, (1.2, 1.8))], ids=["known", "vague"])
def test_the_ends_of_a_vague_line_are_forgotten(factor, kept):
    """Vague is an end that is more than 5 % of the length uncertain, in all: here of 1 m; the second is worse."""
    P = np.zeros((8, 8))
    P[4, 4], P[6, 6] = 0.6**2, 0.8**2
    p, spread = HmgLin().support(np.array([5.0, -1.0, 0.0, 1.0, 5.0, 0.0, 0.0, 1.0]))[1::2]
    assert np.allclose(p, [0, 1, 0]) and spread.shape == (3, 8)
    map, lmk, look = one_line((factor * 0.05 / 2) ** 2 * P)  # the end at t = 2 moves twice as far as the second point
    look(0.0, 1.0)
    look(0.2, 0.8)
    assert np.allclose(lmk.par, kept, atol=1e-9)
