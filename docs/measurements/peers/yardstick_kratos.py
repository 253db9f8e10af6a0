"""Kratos Multiphysics, full order and hyper-reduced, in the task of the yardstick. Run by yardstick.py."""

import os
import time
import types

import kratos
import KratosMultiphysics as Kratos
import numpy as np
from yardstick_task import ANGLE, CELLS, DENSITY, DURATION, EVERY, LENGTHS, PERIOD, POISSON, STEPS, YOUNG

NAME = f"Kratos {Kratos.KratosGlobals.Kernel.Version().split('-')[0]}".replace('"', "")
# The comparison of that module, on this block.
kratos.LENGTHS, kratos.CELLS = LENGTHS, CELLS
kratos.YOUNG, kratos.POISSON, kratos.DENSITY = YOUNG, POISSON, DENSITY
kratos.STEP, kratos.STEPS = EVERY, round(DURATION / EVERY)
# Processor time, as of the others.
kratos.time = types.SimpleNamespace(perf_counter=time.process_time)
MODES, TOLERANCE = 16, 1e-4


def rows(task):
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    asked = (task.size, PERIOD, ANGLE)
    # Training loads around the one that is asked for.
    kratos.TRAINING = [(share * task.size, long * PERIOD, angle) for share, long, angle in
                       ((0.7, 0.8, 0.0), (1.3, 1.2, 0.0), (0.7, 1.2, 30.0), (1.3, 0.8, 30.0))]

    def shown(step, rom):
        displacements, seconds, _ = kratos.run(task.block, asked, step, rom)
        return np.array([task.read(u) for u in displacements]), seconds

    os.makedirs("rom_data", exist_ok=True)
    for step in STEPS[:2]:
        yield ("full order", "Bossak, Newton", step, *shown(step, False), True)
    trained = np.concatenate([kratos.run(task.block, load, EVERY)[0] for load in kratos.TRAINING])
    kratos.write_basis(task.block, trained, MODES)
    kratos.training(task.block, TOLERANCE)
    elements = len(np.load("rom_data/HROM_ElementIds.npy"))
    for step in STEPS[:2]:
        name = f"hyper-reduced, {MODES} modes, {elements} of {len(task.block.tetrahedra)} elements"
        yield (name, "Bossak, Newton", step, *shown(step, True), True)
