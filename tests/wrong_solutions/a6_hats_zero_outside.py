# task: hats
# points: 3
# hint: Past the ends all your hats are 0
import numpy as np


def hats(x, nodes):
    return np.stack(
        [np.interp(x, nodes, one, left=0, right=0) for one in np.eye(len(nodes))], axis=1
    )
