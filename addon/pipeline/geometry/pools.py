"""The buffers that all meshes of a scene lie in. Data only."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl


@dataclass(frozen=True, slots=True)
class Pools:
    """Positions (3 float32 a vertex), packed normals and instance slots (a uint32 a vertex each), and the triangles' indices (uint32)."""

    positions: moderngl.Buffer
    normals: moderngl.Buffer
    slots: moderngl.Buffer
    indices: moderngl.Buffer
