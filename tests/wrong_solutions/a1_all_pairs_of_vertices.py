# task: mean_edge_length
# points: 0
# hint: between all vertices
from scipy.spatial.distance import pdist


def mean_edge_length(V, F):
    return pdist(V).mean()
