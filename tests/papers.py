"""The filters once more, as slow loops written from the papers: nothing but definitions.

Defaults and constants are written out again; ``tests/test_filters.py`` holds the filters to them.
Keys are those of report/references.bib.
"""

import numpy as np


def unit(x):
    """At length one; None where there is no direction."""
    length = np.linalg.norm(x)
    return x / length if length > 0 else None


def faces_at(F, n):
    """The faces of each vertex."""
    return [[f for f, face in enumerate(F.tolist()) if i in face] for i in range(n)]


def shapes_of(V, F):
    """Normals, areas and centroids."""
    cross = [np.cross(V[b] - V[a], V[c] - V[a]) for a, b, c in F]
    centroids = [(V[a] + V[b] + V[c]) / 3 for a, b, c in F]
    lengths = [np.linalg.norm(x) for x in cross]
    normals = [x / length for x, length in zip(cross, lengths, strict=True)]
    return np.array(normals), np.array(lengths) / 2, np.array(centroids)


def ring(F, i, shared=1):
    """The faces that have this many vertices in common with face i, or more."""
    return [j for j in range(len(F)) if len({*F[i]} & {*F[j]}) >= shared]


def adjacent(F):
    """Pairs of faces with two vertices in common."""
    pairs = ((f, g) for f in range(len(F)) for g in ring(F, f, shared=2) if f < g)
    return [(f, g) for f, g in pairs if len({*F[f]} & {*F[g]}) == 2]


def mean_of_adjacent(C, F):
    return np.mean([np.linalg.norm(C[f] - C[g]) for f, g in adjacent(F)])


def edges(F):
    return sorted({tuple(sorted((f[k], f[k - 1]))) for f in F.tolist() for k in range(3)})


def boundary(F):
    sides = [{f[k], f[k - 1]} for f in F.tolist() for k in range(3)]
    return {i for side in sides if sides.count(side) == 1 for i in side}


def grown(P, neighbours, i, radius):
    """Points reached from point i through points nearer to it than the radius."""
    near, new = {i}, {i}
    while new:
        new = {k for j in new for k in neighbours[j] if np.linalg.norm(P[k] - P[i]) < radius} - near
        near |= new
    return sorted(near)


def bilateral(V, F, iterations=5, radius=2.0):
    """[FDCo03]."""
    neighbours = [[sum(e) - i for e in edges(F) if i in e] for i in range(len(V))]
    for _ in range(iterations):
        normals, _, _ = shapes_of(V, F)
        moved = V.copy()
        for i, faces in enumerate(faces_at(F, len(V))):
            if not faces:
                continue
            n = unit(sum(normals[f] for f in faces))
            sigma_c = min(np.linalg.norm(V[i] - V[j]) for j in neighbours[i])
            around = grown(V, neighbours, i, radius * sigma_c)
            h = [(V[q] - V[i]) @ n for q in around]
            sigma_s = max(np.std(np.abs(h)), 1e-6 * sigma_c)
            w = [
                np.exp(-(np.linalg.norm(V[q] - V[i]) ** 2) / (2 * sigma_c**2))
                * np.exp(-(height**2) / (2 * sigma_s**2))
                for q, height in zip(around, h, strict=True)
            ]
            moved[i] = V[i] + n * np.dot(w, h) / sum(w)
        V = moved
    return V


def sun_normals(F, N, threshold):
    """[Sun07]: weights of the faces around, the face itself among them."""
    return np.array([
        unit(sum(max(0, N[i] @ N[j] - threshold) ** 2 * N[j] for j in ring(F, i)))
        for i in range(len(F))
    ])  # fmt: skip


def moved_vertices(V, F, N, iterations, fixed):
    """[Sun07]: v += 1/|F_v| sum n <n, c - v>."""
    for _ in range(iterations):
        C = [(V[a] + V[b] + V[c]) / 3 for a, b, c in F]
        V = np.array([
            v if i in fixed or not faces
            else v + sum(N[f] * (N[f] @ (C[f] - v)) for f in faces) / len(faces)
            for i, (v, faces) in enumerate(zip(V, faces_at(F, len(V)), strict=True))
        ])  # fmt: skip
    return V


def sun(V, F, threshold=0.5, normal_iterations=20, vertex_iterations=50, fixed=None):
    """[Sun07]; the boundary keeps its place."""
    N, _, _ = shapes_of(V, F)
    for _ in range(normal_iterations):
        N = sun_normals(F, N, threshold)
    return moved_vertices(V, F, N, vertex_iterations, boundary(F) if fixed is None else fixed)


def joint_bilateral(N, G, area, C, around, sigma_c, sigma_s):
    """Of [Zheng11], [Zhang15], [LLL19]."""

    def weight(i, j):
        space = np.exp(-np.sum((C[i] - C[j]) ** 2) / (2 * sigma_c**2))
        return area[j] * space * np.exp(-np.sum((G[i] - G[j]) ** 2) / (2 * sigma_s**2))

    return np.array([unit(sum(weight(i, j) * N[j] for j in js)) for i, js in enumerate(around)])


def bilateral_normal(V, F):
    """[Zheng11], the local scheme: without the face itself; the boundary keeps its place."""
    N, area, C = shapes_of(V, F)
    around = [[j for j in ring(F, i) if j != i] for i in range(len(F))]
    sigma_c = mean_of_adjacent(C, F)
    for _ in range(20):
        N = joint_bilateral(N, N, area, C, around, sigma_c, 0.35)
    return moved_vertices(V, F, N, 10, boundary(F))


def guidance(F, N, area):
    """[Zhang15]: of the patches with the face, the normal of the most consistent one."""
    patches, pairs = [ring(F, i) for i in range(len(F))], adjacent(F)
    inconsistency, mean = [], []
    for patch in patches:
        differences = [np.linalg.norm(N[f] - N[g]) for f, g in pairs if {f, g} <= {*patch}]
        widest = max(np.linalg.norm(N[j] - N[k]) for j in patch for k in patch)
        strongest = max(differences, default=0)
        inconsistency.append(widest * strongest / (1e-9 + sum(differences)))
        mean.append(unit(sum(area[j] * N[j] for j in patch)))
    return np.array([mean[min(patch, key=inconsistency.__getitem__)] for patch in patches])


def guided_normal(V, F, iterations=20):
    """[Zhang15]; the radius is that of the noisy mesh."""
    _, _, C = shapes_of(V, F)
    rings = [ring(F, i) for i in range(len(F))]
    radius = 2 * mean_of_adjacent(C, F)
    around = [grown(C, rings, i, radius) for i in range(len(F))]
    for _ in range(iterations):
        N, area, C = shapes_of(V, F)
        G = guidance(F, N, area)
        N = joint_bilateral(N, G, area, C, around, mean_of_adjacent(C, F), 0.35)
        V = moved_vertices(V, F, N, 10, ())
    return V


def crease_guidance(pairs, N, area, C):
    """[LLL19]: the mean over at most 12 faces, the nearest first, and never across a crease."""
    beside = [{int(f) + int(g) - i for f, g in pairs if i in (f, g)} for i in range(len(N))]
    G = []
    for i in range(len(N)):
        patch = [i]
        while len(patch) < 12:
            candidates = sorted({j for f in patch for j in beside[f]} - {*patch})
            if not candidates:
                break
            patch.append(min(candidates, key=lambda j: np.linalg.norm(C[j] - C[i])))
        G.append(unit(sum(area[j] * N[j] for j in patch)))
    return np.array(G)


def averaging_matrix(F, n):
    W = np.zeros((n, n))
    for i, j in edges(F):
        W[i, j] = W[j, i] = 1
    d = W.sum(axis=1)
    return np.array(
        [w / s if s else np.eye(n)[i] for i, (w, s) in enumerate(zip(W, d, strict=True))]
    )


def taubin(V, F, lam=0.5, mu=-0.53, iterations=10):
    """[Taubin95], with combinatorial weights."""
    A = averaging_matrix(F, len(V))
    for _ in range(iterations):
        V = V + lam * (A @ V - V)
        V = V + mu * (A @ V - V)
    return V


def mean_squared_edge(V, F):
    return np.mean([np.sum((V[i] - V[j]) ** 2) for i, j in edges(F)])


def feature_convinced(V, F, noise, creases, fixed=()):
    """[LLL19], for a level of noise from .1 to .25; and how many moves were too far.

    ``creases(V)`` gives the pairs of faces with no crease between them, for a smooth copy.
    """
    assert 0.1 <= noise < 0.25
    rejected = 0
    for _ in range(4):
        copy = taubin(V, F, 0.6, -0.636, 1)
        copy = sun(copy, F, 0.4, 8, 4, fixed=())
        N, area, C = shapes_of(V, F)
        G = crease_guidance(creases(copy, 0.85), N, area, C)
        longest = np.sqrt(mean_squared_edge(V, F))
        around = [ring(F, i) for i in range(len(F))]
        for _ in range(4):
            N = joint_bilateral(N, G, area, C, around, longest, 0.35)
        for _ in range(2):
            moved = moved_vertices(V, F, N, 1, fixed)
            far = np.linalg.norm(moved - V, axis=1) > longest
            rejected += far.sum()
            V = np.array([v if stays else w for v, w, stays in zip(V, moved, far, strict=True)])
    return V, rejected


def corners_at_edges(F):
    """p1, p2, p3, p4 of each edge with two faces: the edge from p1 to p3, opposite p2 and p4."""
    for i, k in edges(F):
        tips = [sum(f) - i - k for f in F.tolist() if {i, k} <= {*f}]
        if len(tips) == 2:
            yield i, tips[0], k, tips[1]


def flat_vector(p1, p2, p3, p4):
    """[HS13], section 3.2: the coefficients of p1 to p4 in the area-based edge operator."""
    e = p3 - p1

    def area(p):
        return np.linalg.norm(np.cross(p - p1, e)) / 2

    total = np.sum(e**2) * (area(p2) + area(p4))
    return np.array([
        (area(p2) * ((p4 - p3) @ e) + area(p4) * ((p2 - p3) @ e)) / total,
        area(p4) / (area(p2) + area(p4)),
        (area(p2) * ((p1 - p4) @ e) + area(p4) * ((p1 - p2) @ e)) / total,
        area(p2) / (area(p2) + area(p4)),
    ])  # fmt: skip


def bend(p1, p2, p3, p4):
    """The angle between the normals of p1 p3 p2 and p3 p1 p4."""
    n, m = np.cross(p3 - p1, p2 - p1), np.cross(p1 - p3, p4 - p3)
    return np.arccos(np.clip(unit(n) @ unit(m), -1, 1))


def l0(V, F, lam=0.2, regularity=0.1, beta=1e-3, beta_factor=1.414, beta_max=1e3):
    """[HS13], with the mean of absolute dihedral angles."""
    corners, n = list(corners_at_edges(F)), len(V)
    angle = np.mean([bend(*V[list(c)]) for c in corners])
    length = np.mean([np.linalg.norm(V[i] - V[j]) for i, j in edges(F)])
    lam, alpha = lam * length**2 * angle, regularity * angle
    R = np.zeros((len(corners), n))
    for e, c in enumerate(corners):
        R[e, list(c)] = [1, -1, 1, -1]
    P = V
    while beta < beta_max:
        D = np.zeros((len(corners), n))
        for e, c in enumerate(corners):
            D[e, list(c)] = flat_vector(*P[list(c)])
        d = D @ P
        for e in range(len(d)):
            if d[e] @ d[e] <= lam / beta:
                d[e] = 0
        P = np.linalg.solve(np.eye(n) + beta * D.T @ D + alpha * R.T @ R, V + beta * D.T @ d)
        beta, alpha = beta * beta_factor, alpha * 0.5
    return P
