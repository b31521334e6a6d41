"""The picture: scenes of plain numbers drawn by a batched projection and a painter's algorithm on a pygame surface.

``Renderer("rgb_array").render(demo_scene())`` gives an array. Needs pygame-ce: ``pip install "ssmash_gym[render]"``.
"""

from ssmash_gym.envs.rendering.demo import demo_scene
from ssmash_gym.envs.rendering.pose import airframe_for, helicopter_pose
from ssmash_gym.envs.rendering.renderer import Renderer
from ssmash_gym.envs.rendering.scene import Airframe, History, Limits, Scene, Track, Wheels, rotation

__all__ = [
    "Airframe",
    "History",
    "Limits",
    "Renderer",
    "Scene",
    "Track",
    "Wheels",
    "airframe_for",
    "demo_scene",
    "helicopter_pose",
    "rotation",
]
