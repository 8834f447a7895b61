"""A Gymnasium environment: hold and turn the simulated quadrotor by its four motors.

The observation is what the vehicle truly does, not what its sensors say: roll, pitch and yaw less the wanted angles
(rad), the body's rates (rad/s), and the commands in force. The action is a command for each motor, 0..1. Wanted roll
and pitch change as in the thesis' test sequence. The reward is minus the squared error of the angles (rad^2) times the
step's length, less a small price for rates and for commands that jump; it ends, with a penalty, beyond 60 degrees.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from . import Model, Plant

STEP_S = 0.01
SEGMENT_S = 1.75
DURATION_S = 29.75
FALLEN_RAD = np.deg2rad(60.0)
LARGEST_WANTED_RAD = np.deg2rad(30.0)
RATE_PRICE = 1e-3
JUMP_PRICE = 1e-2
FALLEN_PENALTY = 10.0


class AttitudeEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """One vehicle; a step is 10 ms, an episode the 29.75 s of the test sequence."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, model: Model | None = None) -> None:
        self.model = model or Model.nominal("free")
        bounds = np.array([np.pi] * 3 + [100.0] * 3 + [1.0] * 4, dtype=np.float32)
        self.observation_space = spaces.Box(-bounds, bounds, dtype=np.float32)
        self.action_space = spaces.Box(0.0, 1.0, (4,), np.float32)
        self._plant = Plant(self.model)
        self._commands = np.full(4, self.model.base_command)
        self._steps = 0
        self._wanted_rad = np.zeros((0, 3))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict]:
        super().reset(seed=seed)
        self._plant = Plant(self.model)
        self._commands = np.full(4, self.model.base_command)
        self._steps = 0
        segments = round(DURATION_S / SEGMENT_S)
        drawn = self.np_random.uniform(-LARGEST_WANTED_RAD, LARGEST_WANTED_RAD, (segments, 3))
        # level between positions, and the heading stays
        drawn[::2] = 0.0
        drawn[:, 2] = 0.0
        self._wanted_rad = drawn
        return self._observation(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        commands = np.clip(np.asarray(action, dtype=float), 0.0, 1.0)
        jump = float(np.square(commands - self._commands).sum())
        self._commands = commands
        self._plant.set_commands(commands)
        self._plant.advance(STEP_S)
        self._steps += 1
        observation = self._observation()
        angles, rates = observation[:3].astype(float), observation[3:6].astype(float)
        reward = -STEP_S * float(np.square(angles).sum() + RATE_PRICE * np.square(rates).sum()) - JUMP_PRICE * jump
        has_fallen = bool(np.abs(self._plant.truth()["angle_rad"][:2]).max() > FALLEN_RAD)
        if has_fallen:
            reward -= FALLEN_PENALTY
        is_over = self._steps * STEP_S >= DURATION_S - STEP_S / 2
        return observation, reward, has_fallen, is_over, {}

    def _observation(self) -> np.ndarray:
        truth = self._plant.truth()
        segment = min(int(self._steps * STEP_S / SEGMENT_S), len(self._wanted_rad) - 1)
        error = np.asarray(truth["angle_rad"]) - self._wanted_rad[segment]
        error = (error + np.pi) % (2.0 * np.pi) - np.pi
        whole = np.concatenate([error, truth["rate_body_rad_s"], self._commands]).astype(np.float32)
        return np.clip(whole, self.observation_space.low, self.observation_space.high)
