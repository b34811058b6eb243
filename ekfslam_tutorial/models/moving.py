"""A robot as a sensor sees it that measures velocities: its frame, and how it moves."""

import numpy as np

from ..geometry import hat, v2q


class Moving:
    """Frame of a robot and its velocity: a sensor asks for it by `asks_robot = "moving"`.

    The motion model says the velocity, `motion.velocity(x, u)`. Derivatives by the robot are by its whole state.

    Parameters
    ----------
    motion : MotionModel
    x : ndarray, shape (motion.size,)
    u : ndarray, shape (nu,) or (k, nu), optional
        Its control of now, or several one after the other; zeros if it has not moved yet.

    Raises
    ------
    TypeError
        If the motion model has no method `velocity`.

    See Also
    --------
    to_sensor : Where it is used.
    """

    def __init__(self, motion, x, u=None):
        if not hasattr(motion, "velocity"):
            raise TypeError(
                f"a sensor that measures velocities needs a motion model that has one among its states, and "
                f"{type(motion).__name__} has no method velocity: take constant_velocity, constant_turn or imu"
            )
        u = np.zeros(sum(motion.control_fields.values())) if u is None else np.atleast_2d(np.asarray(u, float))[-1]
        self.F, self.size = motion.frame(x[: motion.frame.size]), len(x)
        self.V, self.V_x = motion.velocity(x, u)

    def compose(self, S):
        """Frame of a sensor in the world: see `Frame2.compose`; F_r has a column for each state of the robot.

        What a sensor measures whose stamps come a time late, its parameter `delay`, it has seen from where the robot
        was: F = F_r * step(-delay V). F_s has the columns of its parameters then, too.
        """
        if getattr(S, "delay", None) is None:
            F, F_f, F_s = self.F.compose(S)
            return F, self._whole(F_f), F_s
        step, STEP_V = _step(self.F, -S.delay.item() * self.V)
        G, G_f, G_step = self.F.compose(step)
        F, F_g, F_s = G.compose(S)
        G_V = G_step @ STEP_V
        whole = np.concatenate([F_s, np.zeros((F.size, S.size - F.size))], 1)
        whole[:, S.delay_at] = -F_g @ G_V @ self.V
        return F, F_g @ (self._whole(G_f) - S.delay * G_V @ self.V_x), whole

    def _whole(self, J):
        """A derivative by the frame as one by the whole state."""
        return np.concatenate([J, np.zeros((len(J), self.size - J.shape[1]))], 1)

    def velocity(self, S):
        """Velocity of a sensor on the robot, in the sensor's own frame.

            v_s = R_s' (v + w x t_s),    w_s = R_s' w

        Parameters
        ----------
        S : Frame2 or Frame3
            Of the sensor on the robot.

        Returns
        -------
        V : ndarray, shape (dof,)
            [v_s; w_s], m/s and rad/s: 3 numbers in the plane, 6 in space.
        V_r, V_s : ndarray, shape (dof, size)
            With respect to the whole state of the robot and the frame of the sensor.

        See Also
        --------
        ConstantTurn.velocity : That of the robot itself.
        """
        d, (v, w) = S.dim, np.split(self.V, [S.dim])
        cross = np.array([[0.0, -w[0]], [w[0], 0.0]]) if d == 2 else hat(w)
        lever = np.array([[-S.t[1]], [S.t[0]]]) if d == 2 else -hat(S.t)  # derivative of w x t by w
        v_s, VS_s, VS_p = S.to_frame(v + cross @ S.t, 0.0)
        VS_s = VS_s + np.concatenate([VS_p @ cross, np.zeros((d, VS_s.shape[1] - d))], 1)
        w_s, WS_s, WS_w = (w, np.zeros((1, S.t.size + 1)), np.eye(1)) if d == 2 else S.to_frame(w, 0.0)
        V_v = np.concatenate([VS_p, np.zeros((len(w), d))])
        V_w = np.concatenate([VS_p @ lever, WS_w])
        return np.concatenate([v_s, w_s]), np.concatenate([V_v, V_w], 1) @ self.V_x, np.concatenate([VS_s, WS_s])


def _step(F, e):
    """The frame that a small motion e = [shift; turn] leads to, and its derivative."""
    if F.dim == 2:
        return type(F)(e), np.eye(3)
    q, Q_v = v2q(e[3:])
    J = np.zeros((7, 6))
    J[:3, :3], J[3:, 3:] = np.eye(3), Q_v
    return type(F)(np.concatenate([e[:3], q])), J
