"""Angles of a quaternion as the clients' tests compare them."""

import math


def roll_pitch_rad(quaternion):
    """Roll and pitch (Euler Z-Y-X), rad, of w, x, y, z from body to world."""
    w, x, y, z = quaternion
    # rounding may carry the sine beyond one
    sin_pitch = max(-1.0, min(1.0, 2 * (w * y - z * x)))
    return math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), math.asin(sin_pitch)
