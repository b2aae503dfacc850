"""The command that opens a window in the browser: `live`."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, Threads, app, limit_threads, print_object
from magicsim.errors import ConfigError

LOWEST_PORT, HIGHEST_PORT = 1024, 65000


@app.command
def live(
    subject: str, *, object: Annotated[str | None, Parameter(name="--object", help="KIND:key=value,...")] = None,
    quality: Annotated[str, Parameter(help="control, or full: slower and finer.")] = "control",
    out: Annotated[Path, Parameter(name="--out", help="Where recordings go.")] = Path("magicsim-live"),
    port: Annotated[int, Parameter(help="Where to listen, on 127.0.0.1 alone.")] = 8321,
    browser: Annotated[bool, Parameter(negative="--no-browser", help="Open the page.")] = True,
    settings: Settings = None, seed: Seed = None, threads: Threads = None, json: Json = False,
) -> None:  # fmt: skip
    """Open a window on a scene or a design: drag and press the object, see frame, lattice, force and verdicts."""
    from magicsim.live.subject import find_subject

    if not LOWEST_PORT <= port <= HIGHEST_PORT:
        raise ConfigError(f"port = {port} is not allowed: must be {LOWEST_PORT} to {HIGHEST_PORT}")
    scene = find_subject(subject, settings or [], seed=seed, object=object)
    limit_threads(threads)
    from magicsim.live.window import LiveWindow

    def told(line: str) -> None:
        sys.stderr.write(f"{subject}: {line}\n")

    with LiveWindow(scene, folder=out, port=port, quality=quality, told=told) as window:
        if json:
            print_object({"address": window.address}, on_one_line=True)
            sys.stdout.flush()
        else:
            sys.stdout.write(f"{window.address} (Ctrl-C ends it; recordings go to {out})\n")
            sys.stdout.flush()
        if browser:
            import webbrowser

            webbrowser.open(window.address)
        window.wait()
