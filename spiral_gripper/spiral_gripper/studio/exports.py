# SPDX-License-Identifier: Apache-2.0
"""Exports of the studio: shapes as tables, meshes and robot models, and the description file."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import trimesh

from spiral_core.errors import SpiralError
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array
from spiral_gripper.files.description_text import description_text
from spiral_gripper.reports.meshes import tube_mesh
from spiral_gripper.reports.robot_model import RobotModel, model_as_urdf, model_as_yaml, model_of
from spiral_gripper.studio.session import Session
from spiral_gripper.studio.settings import description_of


def shape_csv(state: RodState) -> bytes:
    """Return a free shape as CSV, one row for each node, units in the header."""
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


def shape_mesh(positions: Array, outer_radius: float, kind: str) -> bytes:
    """Return a tube's surface in meters as ``"stl"`` or ``"glb"``; its nodes are (n, 3) [m]."""
    mesh = tube_mesh(positions, outer_radius)
    data = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type=kind)
    return data if isinstance(data, bytes) else str(data).encode()


def png(picture: np.ndarray) -> bytes:
    """Return a picture (height, width, 3 or 4) of bytes as PNG."""
    from matplotlib.image import imsave

    content = io.BytesIO()
    imsave(content, picture, format="png")
    return content.getvalue()


def _mesh(session: Session, kind: str) -> bytes:
    """Return the surface that is shown: in contact where that is solved."""
    return shape_mesh(session.shown().positions, session.gripper.tube.outer_radius, kind)


def _model(session: Session, write: Callable[[RobotModel], str]) -> bytes:
    """Return the gripper on its object for a robot's description.

    Raises:
        SpiralError: the object is not held, or not known to be.
    """
    known = session.known
    if known is None or known.grip is None:
        refusal = "" if known is None else known.refusal
        raise SpiralError(refusal or "the grip is still being computed")
    return write(model_of(known.grip, known.settings.object_radius)).encode()


# Name on the page -> suffix of the file, and what writes it.
EXPORTS: Mapping[str, tuple[str, Callable[[Session], bytes]]] = MappingProxyType(
    {
        "csv": ("csv", lambda session: shape_csv(session.shape())),
        "stl": ("stl", lambda session: _mesh(session, "stl")),
        "glb": ("glb", lambda session: _mesh(session, "glb")),
        "urdf": ("urdf", lambda session: _model(session, model_as_urdf)),
        "spheres": ("model.yaml", lambda session: _model(session, model_as_yaml)),
        "gripper file": (
            "yaml",
            lambda session: description_text(
                description_of(session.description, session.settings)
            ).encode(),
        ),
    }
)
