# SPDX-License-Identifier: Apache-2.0
"""The command ``studio``: a gripper in the browser, under one's hands."""

from __future__ import annotations

import time
import webbrowser

import click


@click.command()
@click.argument("gripper", default="paper_design_70")
@click.option("--host", default="127.0.0.1", show_default=True, help="0.0.0.0 shows it to others.")
@click.option("--port", type=click.IntRange(1, 65535), default=8080, show_default=True)
@click.option("--browser/--no-browser", default=True, help="Open the page at once.")
def studio(gripper: str, host: str, port: int, browser: bool) -> None:
    """Show GRIPPER in the browser, with its pressure, object and mount under one's hands.

    GRIPPER is the name of a shipped gripper or the path of a description file. Ctrl-C ends it.
    """
    import viser

    from spiral_gripper.files.description import load_description
    from spiral_gripper.studio.page import Page

    load_description(gripper)  # what is wrong with it is said before anything is served
    server = viser.ViserServer(host=host, port=port, label="spiral gripper studio", verbose=False)
    page = Page(server, gripper)
    address = f"http://{'localhost' if host == '127.0.0.1' else host}:{server.get_port()}"
    click.echo(f"studio of {gripper}: {address}  (Ctrl-C ends it)")
    if browser:
        webbrowser.open(address)
    try:
        while True:
            time.sleep(1.0)
    except KeyboardInterrupt:
        click.echo("ended")
    finally:
        page.close()
        server.stop()
