"""Built-in meshes in closed form: closed, manifold, outward faces, no download."""

from meshfair.shapes.jet import jet, jet_labels, jet_parts
from meshfair.shapes.primitives import box, icosphere, knot, torus

__all__ = ["box", "icosphere", "jet", "jet_labels", "jet_parts", "knot", "torus"]
