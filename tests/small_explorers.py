"""One small explorer of each kind, for what all of them have to do."""

from meshfair import explorers, shapes

V, F = shapes.knot(30, 5)
MESHES = {"box": shapes.box(segments=2), "knot": (V, F)}
MADE = {
    explorers.AveragingExplorer: lambda kind: kind(V, F, iterations=3),
    explorers.ComparisonExplorer: lambda kind: kind(V, F, iterations=3),
    explorers.DenoisingExplorer: lambda kind: kind(V, F, iterations=3),
    explorers.EigenmodeExplorer: lambda kind: kind(V, F),
    explorers.FilterExplorer: lambda kind: kind(MESHES),
    explorers.HeatExplorer: lambda kind: kind(V, F, iterations=3),
    explorers.IterationExplorer: lambda kind: kind([V, V / 2], F, ground_truth=V),
    explorers.JetExplorer: lambda kind: kind(detail=0.5, iterations=2),
    explorers.KernelExplorer: lambda kind: kind(MESHES),
    explorers.LowPassExplorer: lambda kind: kind(V, F),
    explorers.NeighbourhoodExplorer: lambda kind: kind(V, F),
    explorers.NoiseExplorer: lambda kind: kind(V, F),
    explorers.StabilityExplorer: lambda kind: kind(V, F, iterations=3),
}
KINDS = {kind.__name__: kind for kind in MADE}


def small(name):
    """A new explorer by the name of its class."""
    return MADE[KINDS[name]](KINDS[name])
