"""docs/rosetta.md is complete and true: every name of the manual stands in it, every name of this package exists."""

import dataclasses
import importlib
import json
import re
from pathlib import Path

import numpy as np
import pytest

import ekfslam_tutorial
from ekfslam_tutorial.models.landmarks import IdpPnt
from ekfslam_tutorial.models.motion import Odometry3
from ekfslam_tutorial.models.sensors import PinHole
from ekfslam_tutorial.toolbox import Landmark, Robot, Sensor, Time, UserData, World, universal_slam

PACKAGE = Path(ekfslam_tutorial.__file__).parent
PAGE = (Path(__file__).parents[2] / "docs" / "rosetta.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| (`.*`) \| (none|`.*`) \| (.*) \|$")


def rows(text=PAGE):
    """Rows of the tables: names of the manual, names here (none of them where there is no counterpart), remark."""
    found = [ROW.match(line) for line in text.splitlines() if line.startswith("| `")]
    assert all(found), "a row of the table is not | `manual` | `folder:name` or none | remark |"
    return [(re.findall(r"`([^`]+)`", m[1]), re.findall(r"`([^`]+)`", m[2]), m[3].strip()) for m in found]


# --- the manual's names ----------------------------------------------------------------------------------------------

FRAME = "x t q R Rt it iq Pi Pc"
MANUAL = {
    "table 1": "Rob Sen Lmk Obs Map Tim SimRob SimSen SimLmk SimObs MapFig SenFig",
    "figure 4": "Rob: rob id name type sensors motion con con.u con.U frame vel vel.x vel.P vel.r "
    "state state.x state.P state.size state.r",
    "figure 4, frame": f"Rob.frame: P r {FRAME}",
    "figure 5": "Sen: sen id name type robot frame par par.k par.d par.c par.imSize "
    "state state.x state.P state.size state.r",
    "figure 5, frame": f"Sen.frame: P r {FRAME}",
    "figure 6": "Lmk: lmk id type used state state.x state.P state.size state.r nom nom.n nom.N par",
    "figure 7": "Map: used x P size",
    "figure 8": "Tim: firstFrame lastFrame dt",
    "figure 9": "Obs: sen lmk sid lid meas meas.y meas.R nom nom.n nom.N exp exp.e exp.E inn inn.z inn.Z inn.iZ "
    "inn.MD2 app app.pred app.curr app.sc vis measured matched updated Jac Jac.E_r Jac.E_s Jac.E_l",
    "figure 10": "SimRob: rob id name type motion sensors frame vel vel.x",
    "figure 10, frame": f"SimRob.frame: {FRAME}",
    "figure 11": "SimSen: sen id name type robot frame par par.k par.d par.c par.imSize",
    "figure 11, frame": f"SimSen.frame: {FRAME}",
    "figure 12": "SimLmk: ids points lims lims.xMin lims.xMax lims.yMin lims.yMax lims.zMin lims.zMax "
    "dims dims.l dims.w dims.h center center.xMean center.yMean center.zMean",
    "figure 13": "SimObs: sen ids points",
    "figure 15": "MapFig: fig axes ground simRob simSen simLmk estRob estSen estLmk "
    "estLmk.mean estLmk.ellipse estLmk.label",
    "figure 17": "SenFig: fig axes raw measure ellipse label",
    "figure 18": f"frame: {FRAME}",
    "section 1": "universalSLAM userData frame fromFrame q2R pinHole",
    "section 3.4": "frame updateFrame quaternion q2R q2qc q2Pi pi2pc",
    "section 4.1": "universalSLAM userData createSLAMstructures createSimStructures createGraphicsStructures "
    "Robot Sensor Landmark Time World FigureOptions currentFrame drawnow",
    "section 4.2": "SimObservation SimMotion obsKnownLmks initNewLmks motion drawMapFig drawSenFig "
    "simObservation simMotion correctKnownLmks initNewLmk",
    "figure 19": "SimMotion constVel odometry odo3 updateFrame",
    "section 4.3": "HighLevel/ InterfaceLevel/ DataManagement/ DetectionMatching/ EKF/ FrameTransforms/ rotations/ "
    "Graphics/ Kinematics/ Math/ Observations/ Simulation/ Slam/",
    "section 5.1": "observationModel toFrame projectToSensor projEucPntIntoPinHoleOnRob pinHole project distort "
    "pixellise invPinHole pinHoleIdp splitFrame Rf Sf Sp Spk Spd l e u s U_r U_s U_k U_d U_l",
    "section 5.2": "invObsModel retroProjectFromSensor retroProjIdpPntFromPinHoleOnRob invPinHoleIdp fromFrameIdp n Sk "
    "Sc IDP_rf IDP_sf IDP_sk IDP_sd IDP_k IDP_c IDP_sc IDP_u IDP_n",
}
LATER = {"simObservation", "simMotion", "correctKnownLmks", "initNewLmk"}  # stand in the remark of the older name


def manual_names():
    for names in MANUAL.values():
        owner, colon, fields = names.rpartition(": ")
        yield from (f"{owner}.{name}" if colon else name for name in fields.split())


def test_every_name_of_the_manual_stands_in_the_table():
    table = {name for names, _, _ in rows() for name in names}
    remarks = " ".join(remark for _, _, remark in rows())
    missing = [n for n in manual_names() if n not in table and not (n in LATER and f"`{n}`" in remarks)]
    assert missing == []


@pytest.mark.parametrize("file", ["rotations", "frames", "motion", "camera", "points"])
def test_every_recorded_function_stands_in_the_table(file, golden_dir):
    records = json.loads((golden_dir / "functions" / f"{file}.json").read_text(encoding="utf-8"))
    table = {name for names, _, _ in rows() for name in names}
    assert {r["fn"] for r in records if not r["fn"].startswith("golden_")} - table == set()


def test_no_counterpart_has_a_reason():
    assert [names for names, here, remark in rows() if not here and len(remark) < 5] == []


# --- the names here --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def live():
    """One object of each kind from a running scenario: what an `__init__` sets can be seen on these only."""
    import matplotlib.pyplot as plt

    from ekfslam_tutorial.graphics import MapFig, SenFig

    data = UserData(
        robots=[Robot(motion=Odometry3(), control={"dx": [0.1, 0, 0]}, control_std={"dx": 0.01, "da_deg": 0.1})],
        sensors=[Sensor(model=PinHole(), orientation_deg=[-90, 0, -90])],
        landmark=Landmark(model=IdpPnt()),
        world=World.of(np.array([[4.0, 1, 0.5], [5, -1, 1], [6, 0, -0.5]])),
        time=Time(last=2),
    )
    *_, now = universal_slam(data, engine="plain")  # its records are those of `slam`
    figures = [MapFig(now), SenFig(now)]
    objects = [now, now.map, *now.robs, *now.sens, *now.lmks.values(), *now.obs.values(), now.raw[1], *figures]
    objects += [*now.sim_robs, *now.sim_sens, now.sim_lmk, now.robs[0].frame(now.map), now.sens[0].model, data]
    yield {type(obj): obj for obj in objects}
    plt.close("all")


def resolve(name, live):
    """The thing that a name in the middle column means; AttributeError or ImportError if there is none."""
    if name.endswith("/"):
        return importlib.import_module(f"{PACKAGE.name}.{name[:-1].replace('/', '.')}")
    module, _, attributes = name.partition(":")
    found = importlib.import_module(f"{PACKAGE.name}.{module}")
    for attribute in attributes.split("."):
        found = live.get(found, found) if isinstance(found, type) else found
        fields = [f.name for f in dataclasses.fields(found)] if dataclasses.is_dataclass(found) else []
        found = None if attribute in fields and not hasattr(found, attribute) else getattr(found, attribute)
    return found


def test_every_name_here_exists(live):
    bad = []
    for names, here, _ in rows():
        for name in here:
            try:
                resolve(name, live)
            except (AttributeError, ImportError) as error:
                bad.append(f"{names[0]}: {name}: {error}")
    assert bad == []


def test_the_checks_themselves_see_what_is_wrong(live):
    for wrong in ("slam:Rob.colour", "slam:Robb", "slamm:Rob", "graphics:MapFig.est_lmk.colour", "nowhere/"):
        with pytest.raises((AttributeError, ImportError)):
            resolve(wrong, live)
    assert resolve("graphics:MapFig.est_lmk.mean", live) is not None
    with pytest.raises(AssertionError):
        rows("| `Rob.rob` | somewhere | a remark |")
