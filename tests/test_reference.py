"""libigl's matrices in the package's conventions, against answers by hand."""

import numpy as np

from meshes import RIGHT_TRIANGLE, fan
from meshfair import mesh, reference


def test_right_triangle_by_hand():
    V, F = RIGHT_TRIANGLE
    V = np.concatenate([V, [[5.0, 5, 5]]])  # without faces: all matrices keep its row
    expected = np.zeros((4, 4))
    expected[:3, :3] = [[0, 1, 1], [1, 0, 1], [1, 1, 0]]
    np.testing.assert_array_equal(reference.adjacency(F, 4).toarray(), expected)
    expected[:3, :3] = [[0, 0.5, 0.5], [0.5, 0, 0], [0.5, 0, 0]]
    np.testing.assert_allclose(reference.cotangent(V, F).toarray(), expected, atol=1e-15)
    np.testing.assert_allclose(
        reference.mass(V, F).diagonal(), [1 / 6, 1 / 6, 1 / 6, 0], atol=1e-15
    )


def test_a_duplicate_face_counts_twice_there():
    V, F = fan(2)
    once, twice = (reference.cotangent(V, X) for X in (F, np.concatenate([F, F])))
    np.testing.assert_allclose(twice.toarray(), 2 * once.toarray(), atol=1e-14)
    assert len(mesh.unique_faces(np.concatenate([F, F]))) == len(F)
