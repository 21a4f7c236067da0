"""Texts of scenes that are drawn at random: one vehicle at a steady speed, objects, and a rough bed."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats

SCENE = """seed = {seed}
duration_s = {seconds}

[vehicle]
position_ned = [0.0, 0.0, {down_m}]
velocity_ned = [{speed:.2f}, 0.0, 0.0]
pitch = {{ amplitude_deg = {pitch_deg:.1f}, period_s = 7.0 }}
yaw = {{ amplitude_deg = {yaw_deg:.1f}, period_s = 15.0 }}
{objects}
[sea_bed]
depth_m = {depth_m:.2f}
slope_deg = {rises_deg:.1f}
slope_heading_deg = 180.0
rough = {{ rms_height_m = {rms_height_m:.3f}, correlation_m = {correlation_m:.2f} }}
surface = {{ cd = {cd:.2f}, cs = {cs:.2f}, sigma_deg = 20.0 }}

[image]
range_correlation = {range_correlation:.2f}
beam_gain_rms_db = 1.0
"""

OBJECT = """
[[objects]]
shape = "{shape}"
name = "{name}"
position_ned = [{place[0]:.1f}, {place[1]:.1f}, {down:.2f}]
{rows}
surface = {{ cd = {cd:.3f}, cs = {cs:.3f}, sigma_deg = {sigma_deg:.0f} }}
"""


class Drawn(NamedTuple):
    """What differs from scene to scene."""

    seed: int
    speed: float
    """North, m/s."""
    pitch_deg: float
    yaw_deg: float
    """Amplitudes."""
    depth_m: float
    """Of the bed, below the surface; it rises ahead by"""
    rises_deg: float
    rms_height_m: float
    correlation_m: float
    cd: float
    cs: float
    range_correlation: float


class Surface(NamedTuple):
    """An object's, as in a scene's file."""

    cd: float
    cs: float
    sigma_deg: float


def new_seed(rng: np.random.Generator) -> int:
    """Draw a scene's seed."""
    return int(rng.integers(1 << 30))


def scene_text(drawn: Drawn, objects: str, *, seconds: float, down_m: float) -> str:
    """Return a scene; down_m: of the vehicle."""
    return SCENE.format(objects=objects, seconds=seconds, down_m=down_m, **drawn._asdict())


def object_text(shape: str, name: str, place: Floats, down: float, rows: str, surface: Surface) -> str:
    """Return an object; place: north and east, m; rows: of its size, and its velocity if it moves."""
    return OBJECT.format(shape=shape, name=name, place=place, down=down, rows=rows, **surface._asdict())
