"""How far a mesh is from the ground truth: SNR, normals, surface, volume, area.

`compare` measures all that fits two meshes, and says why the rest does not;
``rowwise`` compares vertex by vertex and face by face, ``surfaces`` measures the distance
of two surfaces, ``sizes`` the change of volume and area, and ``matching`` finds
which vertices of two meshes are the same.
"""

from meshfair.metrics.comparison import compare
from meshfair.metrics.matching import matched
from meshfair.metrics.measure import Measure
from meshfair.metrics.rowwise import normal_angle, normal_angles, snr, snr_of_distances
from meshfair.metrics.sizes import area_change, volume_change
from meshfair.metrics.surfaces import distances, hausdorff, surface_distance, vertex_distance

__all__ = [
    "Measure",
    "area_change",
    "compare",
    "distances",
    "hausdorff",
    "matched",
    "normal_angle",
    "normal_angles",
    "snr",
    "snr_of_distances",
    "surface_distance",
    "vertex_distance",
    "volume_change",
]
