"""Files of poses with covariances: every form is read as what it is, and a bad one gets one sentence."""

import json
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.analysis import md2
from ekfslam_tutorial.analysis.audit import audit
from ekfslam_tutorial.analysis.estimate_files import read_estimate, read_innovations, read_map, read_truth, with_truth
from ekfslam_tutorial.analysis.estimates import run_errors, tangent_error, to_mixed
from ekfslam_tutorial.analysis.g2o import read_g2o
from ekfslam_tutorial.geometry import Frame2, Frame3, v2q

N = 5


def poses(rng, d):
    if d == 2:
        return rng.normal(size=(N, 3))
    q = rng.normal(size=(N, 4))
    return np.column_stack([rng.normal(size=(N, 3)), q / np.linalg.norm(q, axis=1)[:, None]])


def covariances(rng, n):
    A = rng.normal(size=(N, n, n))
    return 1e-2 * (A @ np.swapaxes(A, 1, 2) + np.eye(n))


def tum(x):
    """State vectors as rows without stamps: the scalar of the quaternion last."""
    return x if x.shape[1] == 3 else np.column_stack([x[:, :3], x[:, 4:], x[:, 3]])


def write(path, *columns, head="", comma=False):
    rows = np.column_stack([np.arange(N) * 0.1, *columns])
    np.savetxt(path, rows, fmt="%.17g", delimiter="," if comma else " ", header=head, comments="")
    return path


def upper(P):
    i, j = np.triu_indices(P.shape[1])
    return P[:, i, j]


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("form", ["upper", "full", "csv", "openvins"])
def test_every_form_of_columns(tmp_path, rng, d, form):
    if form == "openvins" and d == 2:
        return
    x, P = poses(rng, d), covariances(rng, 3 if d == 2 else 6)
    n = P.shape[1]
    if form == "upper":
        path = write(tmp_path / "e.txt", tum(x), upper(P))
    elif form == "full":
        path = write(tmp_path / "e.txt", tum(x), P.reshape(N, -1), head="# a remark")
    elif form == "openvins":
        P[:, :3, 3:] = P[:, 3:, :3] = 0
        path = write(tmp_path / "e.txt", tum(x), upper(P[:, 3:, 3:]), upper(P[:, :3, :3]), head="# Pr11 ... Pt33")
    else:
        axes = ["x", "y", "theta"] if d == 2 else ["x", "y", "z", "rx", "ry", "rz"]
        state = axes if d == 2 else ["x", "y", "z", "qx", "qy", "qz", "qw"]
        i, j = np.triu_indices(n)
        names = ["t", *state, *(f"P_{axes[a]}{axes[b]}" for a, b in zip(i, j, strict=True))]
        order = rng.permutation(len(names))
        rows = np.column_stack([np.arange(N) * 0.1, tum(x), upper(P)])
        path = tmp_path / "e.csv"
        np.savetxt(
            path, rows[:, order], fmt="%.17g", delimiter=",", header=",".join(np.array(names)[order]), comments=""
        )
    found = read_estimate(path)
    np.testing.assert_allclose(found.x.x, x, atol=1e-15)
    np.testing.assert_allclose(found.P, P, atol=1e-15)
    np.testing.assert_allclose(found.t, np.arange(N) * 0.1)


def test_gtsam_has_the_rotation_first(tmp_path, rng):
    x, P = poses(rng, 3), covariances(rng, 6)
    order = np.r_[3:6, :3]
    path = write(tmp_path / "e.txt", tum(x), P[:, order][:, :, order].reshape(N, -1))
    found = read_estimate(path, "body", rotation_first=True)
    np.testing.assert_allclose(found.P, P, atol=1e-15)
    assert found.axes == "body"


@pytest.mark.parametrize("axes", ["mixed", "body", "map"])
@pytest.mark.parametrize("d", [2, 3])
def test_errors_in_all_axes_are_the_same_where_they_are_small(rng, d, axes):
    x = Frame2(poses(rng, 2)) if d == 2 else Frame3(poses(rng, 3))
    small = 1e-6 * rng.normal(size=(N, x.dof))
    q = v2q(small[:, 3:])[0] if d == 3 else None
    turned = x.x[:, 2:] + small[:, 2:] if d == 2 else x.compose(Frame3(np.column_stack([0 * small[:, :3], q])))[0].q
    truth = type(x)(np.column_stack([x.t + small[:, :d], turned]))
    np.testing.assert_allclose(
        (to_mixed(x, axes) @ tangent_error(x, truth, axes)[..., None])[..., 0], -small, atol=1e-11
    )


@pytest.mark.parametrize("d", [2, 3])
def test_the_error_of_the_body_is_the_logarithm(rng, d):
    """T Exp(e) is the truth: exp of the 3 x 3 or 4 x 4 matrix, by scipy."""
    from scipy.linalg import expm

    x = Frame2(poses(rng, 2)) if d == 2 else Frame3(poses(rng, 3))
    truth = Frame2(poses(rng, 2)) if d == 2 else Frame3(poses(rng, 3))
    for k, e in enumerate(-tangent_error(x, truth, "body")):
        hat = np.zeros((d + 1, d + 1))
        hat[:d, d] = e[:d]
        w = e[d:]
        hat[:d, :d] = [[0, -w[0]], [w[0], 0]] if d == 2 else np.cross(np.eye(3), w)
        T = [np.block([[F.R[k], F.t[k][:, None]], [np.zeros((1, d)), np.ones((1, 1))]]) for F in (x, truth)]
        np.testing.assert_allclose(T[0] @ expm(hat), T[1], atol=1e-9)


def test_agreement_with_smfeval(tmp_path):
    """NEES of the position and the interval of its mean, as smfeval has them: tools/compare_smfeval.py wrote them."""
    kept = json.loads((Path(__file__).parent / "smfeval.json").read_text(encoding="utf-8"))
    assert kept["version"] == "0.4.0"
    for name in ("estimate", "truth"):
        (tmp_path / name).write_text(kept[name], encoding="utf-8")
    s = with_truth(read_estimate(tmp_path / "estimate"), read_truth(tmp_path / "truth"))
    run = run_errors(s, "fixed")
    nees = md2(run.e[:, :3], run.P[:, :3, :3])
    np.testing.assert_allclose(nees, kept["position_nees"], rtol=1e-9)
    from ekfslam_tutorial.analysis import anees_band

    np.testing.assert_allclose(anees_band(3, len(nees)), [kept["low"], kept["high"]], rtol=1e-9)
    assert 3 * audit([run]).position.ratio == pytest.approx(kept["anees"], rel=1e-9)


def good(rng, d=2):
    x, P = poses(rng, d), covariances(rng, 3 if d == 2 else 6)
    return np.column_stack([np.arange(N) * 0.1, tum(x), P.reshape(N, -1)])


def bad_nan(a):
    a[2, 5] = np.nan


def bad_symmetry(a):
    a[1, 5] += 1.0


def bad_sign(a):
    a[3, 4] = -1.0


def bad_stamp(a):
    a[2, 0] = 0.05


BAD = {
    bad_nan: "line 3: nan in column p_xy; all must be finite",
    bad_symmetry: "P of row 2 is not symmetric",
    bad_sign: "P of row 4 is no covariance: it has a negative eigenvalue",
    bad_stamp: "stamps must rise, and that of pose 3 does not: 0.05 s after 0.1 s",
}


@pytest.mark.parametrize("spoil", BAD)
def test_bad_numbers_are_told_in_one_sentence(tmp_path, rng, spoil):
    a = good(rng)
    spoil(a)
    np.savetxt(tmp_path / "e.txt", a, fmt="%.17g")
    names = spoil is bad_nan
    with pytest.raises(ValueError, match=BAD[spoil].replace("p_xy", "6") if names else BAD[spoil]) as told:
        read_estimate(tmp_path / "e.txt")
    assert "\n" not in str(told.value) and "e.txt" in str(told.value)


def test_bad_files_are_told_in_one_sentence(tmp_path, rng):
    def refused(text, sentence, read=read_estimate):
        (tmp_path / "e.txt").write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=sentence) as told:
            read(tmp_path / "e.txt")
        assert "\n" not in str(told.value) and "e.txt" in str(told.value)

    refused("# nothing\n", "has no rows")
    refused("t,x,y\n0,0,0\n", "has no column theta; it has columns t x y")
    refused("t,x,y,theta,std_x\n0,0,0,0,1\n", "has no covariances: columns t x y theta std_x")
    refused("t,x,y,theta,P_xx,P_yy\n0,0,0,0,1,1\n", "has no column P_xy, P_xtheta")
    refused("t,x,x,theta\n0,0,0,0\n", "two columns of the same name: x")
    refused("0 1 2\n", "has 3 columns without names; known: 4, 8, 10")
    refused("0 0 0 0\n1 0 0\n", "line 2: 3 columns, and 4 before", read_truth)
    refused("0 0 0 0\n1 0 zero 0\n", "line 2: 'zero' is no number", read_truth)
    refused("0 0 0 0 0 0 0 2\n", "the quaternion of pose 1 has the length 2, not 1", read_truth)
    refused("0 1 2 3\n", "innovations have 3, 6, 10", read_innovations)
    refused("#%FORMAT SQUARE/0.3\n#%REPRESENTATION ensemble_se3\n0 0 0\n", "only gaussian_se3")
    (tmp_path / "e.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="is not text"):
        read_truth(tmp_path / "e.txt")


def test_stamps_must_meet(tmp_path, rng):
    np.savetxt(tmp_path / "e.txt", good(rng), fmt="%.17g")
    s = read_estimate(tmp_path / "e.txt")
    write(tmp_path / "t.txt", poses(rng, 2))
    truth = read_truth(tmp_path / "t.txt")
    assert len(with_truth(s, truth).t) == N
    late = type(truth)(truth.name, truth.x, truth.t + 10)
    with pytest.raises(ValueError, match=r"no stamp of e.txt \(0.000 to 0.400 s\) is within 0.01 s of one of t.txt"):
        with_truth(s, late)
    some = type(truth)(truth.name, Frame2(truth.x.x[[1, 3]]), truth.t[[1, 3]] + 0.004)
    met = with_truth(s, some)
    np.testing.assert_allclose(met.t, [0.1, 0.3])
    np.testing.assert_allclose(met.truth.x, truth.x.x[[1, 3]])
    space = read_truth(write(tmp_path / "s.txt", tum(poses(rng, 3))))
    with pytest.raises(ValueError, match="not both in the plane"):
        with_truth(s, space)


def test_maps_and_innovations(tmp_path, rng):
    head = "id,type,x,y,P_xx,P_xy,P_yy,true_x,true_y\n"
    (tmp_path / "m.csv").write_text(head + "7,EucPnt,1,2,1,0,1,1,2\n3,EucPnt,4,5,2,1,2,4,6\n9,EucPnt,0,0,1,0,1,,\n")
    ids, points, P, places = read_map(tmp_path / "m.csv")
    assert ids == [3, 7] and points.tolist() == [[4, 5], [1, 2]] and places.tolist() == [[4, 6], [1, 2]]
    assert P[0].tolist() == [[2, 1], [1, 2]]
    (tmp_path / "t.csv").write_text("id,x,y\n9,0.5,0\n")
    assert read_map(tmp_path / "m.csv", tmp_path / "t.csv")[0] == [9]
    (tmp_path / "t.csv").write_text("id,x,y\n1,0.5,0\n")
    with pytest.raises(ValueError, match="no landmark of .* has a true place in"):
        read_map(tmp_path / "m.csv", tmp_path / "t.csv")
    z, Z = rng.normal(size=(N, 2)), covariances(rng, 2)
    found, nis = read_innovations(write(tmp_path / "i.txt", z, upper(Z)))
    np.testing.assert_allclose(nis[:, 0], md2(z, Z))
    np.testing.assert_allclose((found**2).sum(1), nis[:, 0])


@pytest.mark.parametrize("d", [2, 3])
def test_marginals_of_a_chain_are_those_of_dead_reckoning(tmp_path, rng, d):
    """A graph without loops: each pose is the one before and its odometry, so P follows by compounding."""
    frame, dof = (Frame2, 3) if d == 2 else (Frame3, 6)
    step = poses(rng, d)
    x, lines = [frame(poses(rng, d)[0])], []
    Q = covariances(rng, dof)[0] * 1e-2
    P = [np.zeros((dof, dof))]
    for k in range(N):
        moved = frame(step[k])
        x.append(x[-1].compose(moved)[0].normalized()[0])
        shift = lambda e, F: frame(F.x + e) if d == 2 else _shifted3(F, e)
        h, at = 1e-6, x[-2]
        A = np.array(
            [shift(s, at).compose(moved)[0].minus(shift(-s, at).compose(moved)[0])[0] for s in h * np.eye(dof)]
        ).T
        B = np.eye(dof)
        B[:d, :d] = x[-1].R if d == 2 else x[-1].R
        P.append(A @ P[-1] @ A.T / (2 * h) ** 2 + B @ Q @ B.T)
    name, scale = ("SE2", np.ones(3)) if d == 2 else ("SE3:QUAT", np.r_[1, 1, 1, 2, 2, 2])
    Omega = np.linalg.inv(Q) * np.outer(scale, scale)  # g2o's error has the vector part of the quaternion
    numbers = lambda *a: " ".join(f"{v:.15g}" for part in a for v in np.ravel(part))
    lines = [f"VERTEX_{name} {k} {numbers(tum(F.x[None]))}" for k, F in enumerate(x)] + ["FIX 0"]
    lines += [f"EDGE_{name} {k} {k + 1} {numbers(tum(step[k : k + 1]), upper(Omega[None]))}" for k in range(N)]
    (tmp_path / "a.g2o").write_text("\n".join(lines), encoding="utf-8")
    found = read_g2o(tmp_path / "a.g2o")
    np.testing.assert_allclose(found.P, P, rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(read_g2o(tmp_path / "a.g2o", False).x.x, found.x.x)


def _shifted3(F, e):
    q = F.compose(Frame3(np.r_[0, 0, 0, v2q(e[3:])[0]]))[0].q
    return Frame3(np.r_[F.t + e[:3], q])


def test_landmarks_of_a_graph_and_what_it_lacks(tmp_path):
    """One pose, held, sees two points: their joint covariance is the inverse information, turned."""
    text = (
        "VERTEX_SE2 0 1 2 1.5707963267948966\nVERTEX_XY 5 1 5\nVERTEX_XY 6 0 2\nFIX 0\n"
        "EDGE_SE2_XY 0 5 3 0 4 0 16\nEDGE_SE2_XY 0 6 0 1 1 0 1\n"
    )
    (tmp_path / "a.g2o").write_text(text, encoding="utf-8")
    found = read_g2o(tmp_path / "a.g2o")
    assert found.ids == [5, 6] and found.points.tolist() == [[1, 5], [0, 2]]
    np.testing.assert_allclose(found.points_P, np.diag([1 / 16, 1 / 4, 1, 1]), atol=1e-9)
    for extra, sentence in (
        ("VERTEX_XY 7 0 0\n", "do not fix all vertices"),
        ("EDGE_SE2_XY 0 9 0 1 1 0 1\n", "edges to vertices that are not there: 9"),
        ("VERTEX_CAM 1\n", "line 7: VERTEX_CAM is not known; known: VERTEX_SE2"),
        ("EDGE_SE2 0 5 1\n", "line 7: EDGE_SE2 needs 3 numbers and 6 of its information"),
        ("VERTEX_XY 8 0 nan\n", "line 7: VERTEX_XY needs 2 finite numbers"),
    ):
        (tmp_path / "b.g2o").write_text(text + extra, encoding="utf-8")
        with pytest.raises(ValueError, match=sentence):
            read_g2o(tmp_path / "b.g2o")
