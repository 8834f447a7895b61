"""What a step costs from Python: medians of one run, microseconds a step of 2.5 ms. `python python/tests/speed.py`, with the wheel installed"""

import statistics
import time

import numpy as np

import sil_host as sil

STEPS = 4000
STEP_S = 0.0025


def median_us(steps):
    times = []
    for _ in range(7):
        start = time.perf_counter()
        steps()
        times.append((time.perf_counter() - start) / STEPS * 1e6)
    return statistics.median(times)


def main():
    model = sil.Model.nominal("free")
    commands = np.full((STEPS, 4), model.base_command)

    def alone():
        sil.Plant(model).advance(STEPS * STEP_S)

    def batch():
        sil.Plant(model).run(commands, STEP_S)

    def single():
        plant = sil.Plant(model)
        for row in commands:
            plant.set_commands(row)
            plant.advance(STEP_S)
            plant.truth()

    print(f"Rust alone, one call      {median_us(alone):8.2f}")
    print(f"a batch of {STEPS} steps     {median_us(batch):8.2f}")
    print(f"one call after another    {median_us(single):8.2f}")


if __name__ == "__main__":
    main()
