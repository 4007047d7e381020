"""The network of one stage, in torch: `meshfair.filters.face_network` says what it computes."""

import numpy as np
import torch
from kernels import Edges, Invariants, Messages, Mixed, Sums
from torch import nn
from torch.nn.functional import hardswish, normalize

from meshfair.checks import Floats
from meshfair.filters.face_network import (
    BANK,
    CHANNELS,
    HIDDEN,
    LAYERS,
    SCALARS,
    Rings,
    invariants,
)

C, H, K = SCALARS, HIDDEN, CHANNELS


class Layer(nn.Module):
    """One exchange of messages between the faces of each ring."""

    def __init__(self) -> None:
        super().__init__()
        self.own = nn.Linear(C + K, H)
        self.other = nn.Linear(C + K, H, bias=False)
        self.edge = nn.Linear(5 * K + 2, H, bias=False)
        self.along = nn.Linear(H, K)
        self.first = nn.Linear(C + H + 2 * K, H)
        self.second = nn.Linear(H, C + 2 * K * K)
        self.norm = nn.LayerNorm(C)

    def forward(
        self, h: torch.Tensor, v: torch.Tensor, edges: Edges
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Scalars h (m, C) and vectors v (m, 3, K) after it."""
        flat = v.reshape(-1, 3 * K)
        q = torch.cat([h, (v * v).sum(1)], 1)
        y = self.edge(Invariants.apply(flat, edges))
        z = Messages.apply(self.own(q), self.other(q), y, edges)
        s, u = Sums.apply(z, self.along(z), flat, edges)
        u = u.view(-1, 3, K)
        w = self.second(hardswish(self.first(torch.cat([q, s, (u * u).sum(1)], 1))))
        mix = w[:, C:].reshape(-1, 2 * K, K)
        v = v + u + 0.1 * (Mixed.apply(torch.cat([v, u], 2), mix))
        v = v / torch.sqrt(0.01 + (v * v).sum(1, keepdim=True).mean(2, keepdim=True))
        return self.norm(h + w[:, :C]), v


class Stage(nn.Module):
    """From a bank of normals to one normal a face."""

    def __init__(self) -> None:
        super().__init__()
        self.first = nn.Linear(BANK * (BANK - 1) // 2 + 2, 2 * H)
        self.second = nn.Linear(2 * H, C)
        self.all = nn.Linear(C, C)
        self.mix = nn.Linear(C, BANK * K)
        self.layers = nn.ModuleList(Layer() for _ in range(LAYERS))
        self.third = nn.Linear(C + K, H)
        self.out = nn.Linear(H, K + BANK)
        with torch.no_grad():  # at first about the mean of the bank
            self.out.weight *= 0.1
            self.out.bias *= 0.0

    def forward(self, x: torch.Tensor, G: torch.Tensor, edges: Edges) -> torch.Tensor:
        """Unit normals from invariants x (m, .), the bank G (m, 3, BANK) and the edges."""
        h = self.second(hardswish(self.first(x)))
        h = h + self.all(h.mean(0, keepdim=True))
        v = Mixed.apply(G, self.mix(h).view(-1, BANK, K))
        for layer in self.layers:
            h, v = layer(h, v, edges)
        w = self.out(hardswish(self.third(torch.cat([h, (v * v).sum(1)], 1))))
        w = torch.cat([w[:, :K], torch.softmax(w[:, K:], 1)], 1)
        n = (torch.cat([v, G], 2) * w[:, None]).sum(2)
        return normalize(n, dim=1, eps=1e-12)


def tensors(G: Floats, rings: Rings) -> tuple[torch.Tensor, torch.Tensor, Edges]:
    """What `Stage` is given, from the bank (m, BANK, 3) and the rings."""
    R = rings.R
    arrays = [np.ascontiguousarray(a, np.float32) for a in (*rings.ways, rings.share)]
    edges = Edges(R.indptr.astype(np.int64), R.indices.astype(np.int64), *arrays)
    x, G = invariants(G, rings.scalars), G.transpose(0, 2, 1)
    return (
        torch.from_numpy(np.float32(x)),
        torch.from_numpy(np.ascontiguousarray(G, np.float32)),
        edges,
    )
