# SPDX-License-Identifier: Apache-2.0
"""The command ``studio``: a gripper in the browser, from its file or from a running node."""

from __future__ import annotations

import time
import webbrowser
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from typing import TYPE_CHECKING, NoReturn

import click

from spiral_gripper.cli.ros.running import node_option
from spiral_gripper.cli.ros.side import load_ros_side
from spiral_gripper.cli.ros.simulate import DEFAULT_GRIPPER
from spiral_gripper.cli.types import flag, option, units_option

if TYPE_CHECKING:
    import viser

# Between two looks at a running node [s].
LOOK_PERIOD = 0.1


@click.command()
@click.argument("gripper", required=False)
@flag("--ros", "Show a running node in place of a file.")
@node_option
@option(
    "--host",
    str,
    "Address to serve; 0.0.0.0 lets other computers open the page.",
    shown="127.0.0.1",
)
@option("--port", click.IntRange(1, 65535), "Port of the page.", shown=8080)
@click.option("--browser/--no-browser", default=True, help="Open the page in a browser.")
@units_option
def studio(
    gripper: str | None, ros: bool, namespace: str, host: str, port: int, browser: bool
) -> None:
    """Show GRIPPER in the browser, with sliders for its pressure, object and mount.

    GRIPPER is the name of a shipped gripper or the path of a description file. Ctrl-C ends it.
    With --ros the page follows the node in --namespace: pressure, object, shape and grip.
    """
    if ros and gripper is not None:
        raise click.UsageError("--ros shows a running node: it takes no GRIPPER")
    if namespace != "/" and not ros:
        raise click.UsageError("--namespace needs --ros")
    with suppress(KeyboardInterrupt):
        if ros:
            _follow(namespace, host, port, browser)
        _design(gripper or DEFAULT_GRIPPER, host, port, browser)
    click.echo("ended")


def _follow(namespace: str, host: str, port: int, browser: bool) -> NoReturn:
    """Show a running node until Ctrl-C."""
    side = load_ros_side("tools.studio")
    from spiral_gripper.studio.live import LivePage

    with _served(f"the node in {namespace}", host, port, browser) as server:
        live = LivePage(server)
        with closing(side.StudioListener(namespace)) as listener:
            while True:
                listener.spin(LOOK_PERIOD)
                live.show(listener.heard())


def _design(gripper: str, host: str, port: int, browser: bool) -> NoReturn:
    """Show a gripper under its sliders until Ctrl-C."""
    from spiral_gripper.files.description import load_description
    from spiral_gripper.studio.page import Page

    load_description(gripper)  # what is wrong with it is said before anything is served
    with _served(gripper, host, port, browser) as server:
        page = Page(server, gripper)
        try:
            while True:
                time.sleep(1.0)
                page.tick()
        finally:
            page.close()


@contextmanager
def _served(what: str, host: str, port: int, browser: bool) -> Iterator[viser.ViserServer]:
    """Serve a page while the block runs."""
    import viser

    server = viser.ViserServer(host=host, port=port, label="spiral gripper studio", verbose=False)
    address = f"http://{'localhost' if host == '127.0.0.1' else host}:{server.get_port()}"
    click.echo(f"studio of {what}: {address}  (Ctrl-C ends it)")
    if browser:
        webbrowser.open(address)
    try:
        yield server
    finally:
        server.stop()
