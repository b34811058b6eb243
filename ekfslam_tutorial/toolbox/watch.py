"""What the corrections do to the poses of the robots: each pose before and after, for `analysis.corrections`."""


class Watch:
    """Context manager around a correction, `with watch.by(rob):`, it notes the poses of all robots before and after.

    One correction moves every robot that is correlated with the one that looks.

    Parameters
    ----------
    map : Map
    robs : list of Rob
        Those with a known pose are passed over.
    opt : Options
        With its `error` "invariant" the covariance after a correction refers to the world as it is believed to lie
        then: it has been turned.

    Attributes
    ----------
    seen : list of tuple
        One entry (rob.id, by, x0, P0, x1, P1, turned) for each robot and correction: id of the robot that looked, mean
        and covariance of the pose, as the state vector has them, before and after; and whether P1 has been turned.
    """

    def __init__(self, map, robs, opt):
        self._map, self.seen, self._by = map, [], None
        self._turned = getattr(opt, "error", "additive") == "invariant"
        self._ranges = {rob.id: pose_range(rob) for rob in robs if rob.r is not None}

    def by(self, rob):
        """Return itself, for a correction by what this robot has measured."""
        self._by = rob.id
        return self

    def __enter__(self):
        self._before = self._poses()
        return self

    def __exit__(self, *_):
        for (id, x0, P0), (_, x1, P1) in zip(self._before, self._poses(), strict=True):
            if (x1 != x0).any():
                self.seen.append((id, self._by, x0, P0, x1, P1, self._turned))

    def _poses(self):
        map = self._map
        return [(id, map.state(r), map.block(r)) for id, r in self._ranges.items()]


def pose_range(rob):
    """Range of the pose in the map: the head of the robot's state."""
    return slice(rob.r.start, rob.r.start + rob.motion.frame.size)
