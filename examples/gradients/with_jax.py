"""Gradients of a march in JAX: system identification, and optimal control of a push.

    pip install vademecum jax scipy
    python with_jax.py

`march` is a function of JAX like any other: `jax.grad`, `jax.jit` and `jax.value_and_grad` go through it.
"""

import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import minimize

import beam

jax.config.update("jax_enable_x64", True)


def differentiable(file, names, loads, steps, held=False):
    """Probes after each step, as a function of the values of parameters and of the amplitudes of the loads."""
    probes = len(file.body().probe_names)

    def keep(values, amplitudes):
        parameters = {name: float(value) for name, value in zip(names, values)}
        return file.vjp(loads, np.asarray(amplitudes), parameters=parameters, held=held)

    def forwards(values, amplitudes):
        return keep(values, amplitudes).values

    def backwards(values, amplitudes, cotangents):
        gradient = keep(values, amplitudes).gradient(np.asarray(cotangents))
        return np.array([gradient.parameters[name] for name in names]), gradient.amplitudes

    @jax.custom_vjp
    def march(values, amplitudes):
        shape = jax.ShapeDtypeStruct((steps, probes), jnp.float64)
        return jax.pure_callback(forwards, shape, values, amplitudes)

    def march_back(inputs, cotangents):
        shapes = [jax.ShapeDtypeStruct(x.shape, jnp.float64) for x in inputs]
        return jax.pure_callback(backwards, tuple(shapes), *inputs, cotangents)

    march.defvjp(lambda *inputs: (march(*inputs), inputs), march_back)
    return march


def identify(file):
    """Fits stiffness and damping to measured probes, from the middle of their ranges."""
    march = differentiable(file, beam.NAMES, beam.LOADS, beam.STEPS)
    tap, (measured, deviation) = beam.tap(), beam.measured(file)

    lower, upper = jnp.array(beam.LOWER), jnp.array(beam.UPPER)

    def values(x):
        # Any number is a value of the range, whose logarithm is what counts.
        return lower * (upper / lower) ** jax.nn.sigmoid(x)

    @jax.jit
    def misfit(x):
        return 0.5 * jnp.mean(((march(values(x), tap) - measured) / deviation) ** 2)

    found = minimize(jax.value_and_grad(misfit), np.zeros(3), jac=True, method="BFGS")
    beam.report(f"identified in {found.nfev} gradients", np.asarray(values(found.x)))


def control(file):
    """Finds the push of each step that brings the tip to a place and leaves it there at rest."""
    march = differentiable(file, beam.NAMES, beam.LOADS, beam.STEPS, held=True)
    target, values = beam.moved(file), jnp.array(beam.TRUE)
    counts = np.zeros((beam.STEPS, 1))
    counts[2 * beam.STEPS // 3 :] = 1.0

    @jax.jit
    def cost(push):
        tip = march(values, push.reshape(-1, 1))[:, :1]
        return jnp.mean(counts * ((tip - target[:, :1]) / 1e-5) ** 2) + 1e-6 * jnp.mean(push**2)

    rest = np.zeros(beam.STEPS)
    found = minimize(jax.value_and_grad(cost), rest, jac=True, method="L-BFGS-B", options={"maxiter": 400})
    beam.reached(f"controlled in {found.nfev} gradients", np.asarray(march(values, found.x.reshape(-1, 1))))


if __name__ == "__main__":
    body = beam.build()
    identify(body)
    control(body)
