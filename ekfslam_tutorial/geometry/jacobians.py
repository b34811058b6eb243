"""The second view of every Jacobian: central differences.

Public, because students check their own derivatives with it.
"""

import numpy as np

STEP = 1e-6  # near the cube root of the machine precision: rounding and truncation error balance


def _vector(value):
    """The numbers of a value: an array as it is, a frame by its state vector."""
    return np.asarray(getattr(value, "x", value), dtype=float)


def _like(arg, x):
    """A value of the kind of `arg` that holds the numbers `x`."""
    return type(arg)(x) if hasattr(arg, "x") else x.reshape(np.shape(arg))


def numerical_jacobian(f, x, step=STEP):
    """Jacobian of `f` at `x` by central differences.

    Parameters
    ----------
    f : callable
        Function of one vector (or one frame). Its value is an array or a frame.
    x : array_like or Frame2 or Frame3
        Where to differentiate; a vector of n numbers.
    step : float
        Half width of the difference, in the units of `x`. Scaled up with large entries.

    Returns
    -------
    ndarray, shape (*shape of f(x), n)
        `J[..., j] = (f(x + h e_j) - f(x - h e_j)) / 2 h`, with an error of order h^2.

    See Also
    --------
    check_jacobians : Compares those of a model with these.

    Examples
    --------
    >>> numerical_jacobian(lambda x: x**2, np.array([1.0, 3.0])).round(6)
    array([[2., 0.],
           [0., 6.]])
    """
    x0 = _vector(x).ravel()
    columns = []
    for j, xj in enumerate(x0):
        h = np.zeros_like(x0)
        h[j] = step * max(1.0, abs(xj))
        columns.append((_vector(f(_like(x, x0 + h))) - _vector(f(_like(x, x0 - h)))) / (2 * h[j]))
    return np.stack(columns, axis=-1) if columns else np.zeros((*_vector(f(x)).shape, 0))


def check_jacobians(f, *args, rtol=1e-6, atol=1e-6, step=STEP):
    """Compare the Jacobians that a model function returns with central differences.

    A model function returns `value, J_arg1, J_arg2, ...`: one Jacobian per argument, in argument order.

    Parameters
    ----------
    f : callable
        The function to check. Fix an argument that has no Jacobian with a lambda.
    *args : array_like or Frame2 or Frame3
        Where to check. Vectors and frames, not stacks of them.
    rtol, atol : float
        Tolerances of `numpy.isclose`, relative to the largest entry of each Jacobian. The default leaves room
        for the error of the differences, about 1e-9.
    step : float
        See `numerical_jacobian`.

    Raises
    ------
    AssertionError
        Naming the argument, the entry, and the two values that differ most.

    See Also
    --------
    numerical_jacobian : What they are compared with.

    Examples
    --------
    >>> check_jacobians(lambda x: (x**2, 2 * np.diag(x)), np.array([1.0, 3.0]))
    """
    out = f(*args)
    assert isinstance(out, tuple), f"the function must return a tuple: value, Jacobian, ...; got {type(out).__name__}"
    _, *jacobians = out
    assert len(jacobians) == len(args), f"got {len(jacobians)} Jacobians for {len(args)} arguments; one each is needed"

    for i, (arg, J) in enumerate(zip(args, jacobians, strict=True)):

        def along(x, i=i):
            return f(*args[:i], x, *args[i + 1 :])[0]

        N = numerical_jacobian(along, arg, step)
        J = np.asarray(J)
        assert J.shape == N.shape, f"Jacobian of argument {i + 1} has shape {J.shape}; it must be {N.shape}"

        if N.size:
            error = np.abs(J - N)
            error[~np.isfinite(error)] = np.inf
            worst = tuple(np.argwhere(error >= (1 - 1e-6) * error.max())[0])  # the first of those that are equal
            assert error[worst] <= atol + rtol * np.abs(N).max(), (
                f"Jacobian of argument {i + 1} differs at entry {[int(k) for k in worst]}: "
                f"got {J[worst]:.6g}, central differences give {N[worst]:.6g}"
            )
