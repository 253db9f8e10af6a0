"""Gradients of a march in PyTorch: system identification, and optimal control of a push.

    pip install vademecum torch
    python with_torch.py

Debian's `python3-torch` does as well. `march` is an operation of PyTorch like any other: `backward` goes through it.
"""

import numpy as np
import torch

import beam


class March(torch.autograd.Function):
    """Probes after each step, from the values of parameters and from the amplitudes of the loads."""

    @staticmethod
    def forward(ctx, values, amplitudes, file, names, loads, held):
        parameters = dict(zip(names, values.tolist()))
        ctx.names = names
        ctx.kept = file.vjp(loads, amplitudes.detach().numpy(), parameters=parameters, held=held)
        return torch.from_numpy(ctx.kept.values)

    @staticmethod
    def backward(ctx, cotangents):
        gradient = ctx.kept.gradient(np.ascontiguousarray(cotangents.numpy()))
        of_values = torch.tensor([gradient.parameters[name] for name in ctx.names], dtype=torch.float64)
        return of_values, torch.from_numpy(gradient.amplitudes), None, None, None, None


def march(file, values, amplitudes, held=False):
    return March.apply(values, amplitudes, file, beam.NAMES, beam.LOADS, held)


def least(cost, start, iterations):
    """The least of a cost from a start, by L-BFGS."""
    x = torch.tensor(start, dtype=torch.float64, requires_grad=True)
    search = torch.optim.LBFGS(
        [x], max_iter=iterations, history_size=20, line_search_fn="strong_wolfe", tolerance_grad=1e-9,
        tolerance_change=1e-14,
    )

    def closure():
        search.zero_grad()
        value = cost(x)
        value.backward()
        return value

    search.step(closure)
    return x.detach()


def identify(file):
    """Fits stiffness and damping to measured probes, from the middle of their ranges."""
    measured, deviation = (torch.from_numpy(part) for part in beam.measured(file))
    tap = torch.from_numpy(beam.tap())
    lower, upper = torch.tensor(beam.LOWER, dtype=torch.float64), torch.tensor(beam.UPPER, dtype=torch.float64)

    def values(x):
        # Any number is a value of the range, whose logarithm is what counts.
        return lower * (upper / lower) ** torch.sigmoid(x)

    def misfit(x):
        return 0.5 * (((march(file, values(x), tap) - measured) / deviation) ** 2).mean()

    beam.report("identified", values(least(misfit, np.zeros(3), 100)).tolist())


def control(file):
    """Finds the push of each step that brings the tip to a place and leaves it there at rest."""
    target = torch.from_numpy(beam.moved(file))
    values = torch.tensor(beam.TRUE, dtype=torch.float64)
    counts = torch.zeros(beam.STEPS, 1, dtype=torch.float64)
    counts[2 * beam.STEPS // 3 :] = 1.0

    def cost(push):
        tip = march(file, values, push.reshape(-1, 1), held=True)[:, :1]
        return (counts * ((tip - target[:, :1]) / 1e-5) ** 2).mean() + 1e-6 * (push**2).mean()

    push = least(cost, np.zeros(beam.STEPS), 400)
    beam.reached("controlled", march(file, values, push.reshape(-1, 1), held=True).numpy())


if __name__ == "__main__":
    body = beam.build()
    identify(body)
    control(body)
