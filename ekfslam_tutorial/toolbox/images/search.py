"""Active search as an association: it measures on demand, in the image, where the filter expects a landmark."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...slam import Matches
from ...slam.association import fresh_id
from ..points import points_of
from .appearance import HALF, affine_maps, warped
from .consensus import Consensus
from .matching import corners, find_patch
from .picture import App, Picture

FEW = 3
"""So many matches agree with each other too easily: nothing is refused among them."""
GATE = 5.99
"""Of the second look, squared Mahalanobis distance: 95 % of two numbers."""


@dataclass(frozen=True)
class ActiveSearch:
    """Active search in images: A. J. Davison, "Active search for real-time vision", ICCV 2005.

    1. The patch of each visible landmark is warped to how it should look from here, and looked for inside the ellipse
       where the filter expects it, by normalised cross-correlation.
    2. Matches that do not agree with the largest set that one of them explains (1-point RANSAC) are refused.
    3. A second look at these: once the others have corrected the map, the ellipse is smaller. What lies in it was
       right, or is found now. Each landmark counts as looked for once.
    4. Where the image shows fewer landmarks than wanted, corners are proposed for new ones.

    Parameters
    ----------
    score : float
        Least normalised cross-correlation of a match.
    sigma : float
        Size of the ellipse that is looked at.
    most : int
        Pixels to each side of the expectation, at most.
    agree : float
        Pixels within which matches agree, step 2.
    wanted : int
        Landmarks that should be found in each frame.
    births : int
        New ones in a frame at most, if there are others.
    apart : int
        Pixels between a new landmark and all others.
    quality : float
        Of a corner, as a share of the best one in the image.
    """

    score: float = 0.9
    sigma: float = 3.0
    most: int = 25
    agree: float = 1.4
    wanted: int = 30
    births: int = 8
    apart: int = 14
    quality: float = 0.03

    by_id: ClassVar[bool] = False

    def __post_init__(self):
        for name in ("sigma", "most", "agree", "apart", "quality"):
            if not getattr(self, name) > 0:
                raise ValueError(f"ActiveSearch: {name} must be positive, got {getattr(self, name)!r}")
        if not -1 < self.score < 1:
            raise ValueError(f"ActiveSearch: score must be between -1 and 1, got {self.score!r}")
        for name in ("wanted", "births"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"ActiveSearch: {name} must be 0 or more, got {getattr(self, name)!r}")

    def __call__(self, map, obs, raw, sensor):
        """Look for all visible landmarks in the image; write what was found into `raw`. Returns Matches."""
        if not isinstance(raw, Picture):
            raise ValueError(
                f"the association active_search looks for landmarks in images, but sensor {raw.sen} has none: "
                "take known_ids or nearest_neighbour"
            )
        visible = [o for o in obs if o.visible]
        found = self._search(map, visible, raw, sensor)
        refused = self._refuse(map, found, raw, sensor) if len(found) > FEW else set()
        n = self.wanted - len(found)
        taken = np.array([o.e for o in visible] + [*(raw.given.pixels if raw.given else [])]).reshape(-1, 2)
        new = self._corners(raw, sensor, taken, min(n, self.births) if visible else n)
        pixels = np.array([raw.app[o.lmk].y for o in found]).reshape(-1, 2)
        raw.y = np.concatenate([pixels, new])
        raw.ids = np.array([o.lmk for o in found] + [-1] * len(new), int)
        return Matches({o.lmk: i for i, o in enumerate(found)}, list(range(len(found), len(raw.y))), refused)

    def birth_id(self, raw, i, lmks):
        """Id for a landmark started by measurement i: the first ones are for what is given with the picture."""
        id = max(fresh_id(lmks), 1 + (len(raw.given.pixels) if raw.given else 0))
        raw.born[id] = i
        return id

    def _search(self, map, visible, raw, sensor):
        """Step 1: the observations of the landmarks that are found."""
        rob, sen, lmks = raw.scene
        known = [o for o in visible if lmks[o.lmk].appearance is not None]
        if not known:
            return []
        camera, looks = rob.frame(map).compose(sen.frame(map))[0], [lmks[o.lmk].appearance for o in known]
        points, _ = points_of(map, [lmks[o.lmk] for o in known])
        with np.errstate(all="ignore"):  # a patch that cannot be seen from here has no image
            maps, found = affine_maps(sensor, looks, points, camera), []
        for o, look, A in zip(known, looks, maps, strict=True):
            patch = warped(look, A)
            if patch is None:
                continue
            y, score = find_patch(raw.image, patch, o.e, o.E + sensor.R, self.sigma, self.most)
            seen = y is not None and score >= self.score
            raw.app[o.lmk] = App(patch, score, raw.image, y if seen else None)
            found += [o] * seen
        return found

    def _refuse(self, map, found, raw, sensor):
        """Steps 2 and 3: the ids of the landmarks whose match does not agree with the others."""
        apps = [raw.app[o.lmk] for o in found]
        z = np.array([sensor.residual(app.y, o.e) for app, o in zip(apps, found, strict=True)])
        consensus = Consensus(map, found, z, sensor.R)
        good = consensus.agreeing(self.agree)
        if good.all():
            return set()
        refused, fits = set(), lambda z, Z: z @ np.linalg.solve(Z, z) < GATE
        others = [(app, o.lmk) for app, o, agrees in zip(apps, found, good, strict=True) if not agrees]
        for (app, id), z, Z in zip(others, *consensus.given(good), strict=True):
            if fits(z, Z):
                continue
            y, score = find_patch(raw.image, app.pred, app.y - z, Z, self.sigma, self.most)
            if score >= self.score and fits(y - (app.y - z), Z):
                app.y, app.sc = y, score
            else:
                refused.add(id)
        return refused

    def _corners(self, raw, sensor, taken, n):
        """Step 4: pixels of corners, shape (m, 2)."""
        if n <= 0:
            return np.zeros((0, 2))
        border = max(int(np.ceil(sensor.margin)), HALF) + 5
        return corners(raw.image, taken, n, self.apart, self.quality, border)
