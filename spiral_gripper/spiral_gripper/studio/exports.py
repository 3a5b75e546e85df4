# SPDX-License-Identifier: Apache-2.0
"""What the studio hands out: the shape as a table and as surfaces for other programs."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import trimesh

from spiral_core.rod.types import RodState
from spiral_gripper.studio.meshes import tube_mesh


def shape_csv(state: RodState, outer_radius: float) -> bytes:
    """Return a shape as CSV, one row for each node, units in the header."""
    del outer_radius  # a table of the centerline
    columns = np.column_stack(
        (state.arc_lengths, state.positions, state.orientations, state.strains)
    )
    header = (
        "arc_length [m],x [m],y [m],z [m],qx,qy,qz,qw,"
        "twist [rad/m],curvature_y [rad/m],curvature_z [rad/m]"
    )
    text = io.StringIO()
    np.savetxt(text, columns, fmt="%.9g", delimiter=",", header=header, comments="")
    return text.getvalue().encode()


def shape_stl(state: RodState, outer_radius: float) -> bytes:
    """Return the tube's surface as binary STL, in meters."""
    return _exported(state, outer_radius, "stl")


def shape_glb(state: RodState, outer_radius: float) -> bytes:
    """Return the tube's surface as binary glTF, in meters."""
    return _exported(state, outer_radius, "glb")


def _exported(state: RodState, outer_radius: float, kind: str) -> bytes:
    """Return the tube's surface in a format that trimesh writes."""
    mesh = tube_mesh(state, outer_radius)
    data = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type=kind)
    return data if isinstance(data, bytes) else str(data).encode()


# Suffix -> what writes it.
FORMATS: Mapping[str, Callable[[RodState, float], bytes]] = MappingProxyType(
    {"csv": shape_csv, "stl": shape_stl, "glb": shape_glb}
)
