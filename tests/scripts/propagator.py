#!/usr/bin/env python3
"""Makes fixtures/reference/propagator.csv: the exact step of one mode in 60-digit arithmetic.

Each row holds the arguments as the program gets them (binary64, Δt = 1) and the eight
numbers of the step, rounded to 25 digits: d (2 x 2, row by row), held, rising. Nothing here knows the closed
forms of the program: e^A of the 4 x 4 matrix of the oscillator with a load that is linear in time is found by
scaling, a Taylor series and squaring.
"""

import math
import sys
from decimal import Decimal, getcontext

getcontext().prec = 60


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def exponential(a):
    size = max(sum(abs(x) for x in row) for row in a)
    # Squaring loses a digit or two for every four squarings of a decaying motion; 60 digits are plenty.
    halvings = max(0, int(size.log10() / Decimal(2).log10()) + 6)
    scale = Decimal(2) ** halvings
    a = [[x / scale for x in row] for row in a]
    n = len(a)
    unit = [[Decimal(int(i == j)) for j in range(n)] for i in range(n)]
    total, term = [row[:] for row in unit], unit
    for k in range(1, 40):
        term = [[x / k for x in row] for row in product(term, a)]
        total = [[x + y for x, y in zip(p, q)] for p, q in zip(total, term)]
    for _ in range(halvings):
        total = product(total, total)
    return total


def step(lam, sigma):
    one, zero = Decimal(1), Decimal(0)
    # (q, q', f, f'): q'' = f - 2 sigma q' - lambda q, f grows by f' per step.
    a = [
        [zero, one, zero, zero],
        [-lam, -2 * sigma, one, zero],
        [zero, zero, zero, one],
        [zero, zero, zero, zero],
    ]
    e = exponential(a)
    d = [e[0][0] - 1, e[0][1], e[1][0], e[1][1] - 1]
    return d + [e[0][2], e[1][2], e[0][3], e[1][3]]


def main():
    with open(sys.argv[1], "w", newline="\n", encoding="utf-8") as out:
        out.write("lambda,sigma,d11,d12,d21,d22,held1,held2,rising1,rising2\n")
        frequencies = [10.0 ** (0.5 * k) for k in range(-16, 7)] + [0.3, 0.9, 0.99, 1.01, 1.7, 3.1, 40.0]
        ratios = [0.0, 1e-6, 1e-3, 0.02, 0.3, 0.9, 0.999, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.001, 1.1, 2.0, 10.0, 1e3]
        for frequency in frequencies:
            for ratio in ratios:
                lam = frequency * frequency
                # Critical damping to the last bit: the decay is the root of what lambda was rounded to.
                sigma = math.sqrt(lam) if ratio == 1.0 else ratio * frequency
                values = step(Decimal(lam), Decimal(sigma))
                row = [repr(lam), repr(sigma)] + [f"{value:.24e}" for value in values]
                out.write(",".join(row) + "\n")


main()
