"""`selfmotion view`: the studio in the browser."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.options import Json
from selfmotion.cli.output import Contract, Document, Number, finish
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.provenance import Provenance, hash_file

if TYPE_CHECKING:
    from selfmotion.viewer.studio import Studio


class ViewDocument(Document, frozen=True, tag="selfmotion/view/1", kw_only=True):
    """What the studio shows when it opens, and the files written."""

    url: str | None
    files: list[str]
    coordinates: list[str]
    q: list[Number]
    swivel: Number
    effort: Number
    status: str


CONTRACT = Contract(ViewDocument, ("view", "--export", "build/scene.html", "--json"))


def view(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FILE",
            help="A recording of joint angles to play, a saved state (.json), or both.",
        ),
    ] = None,
    model: Annotated[
        str, typer.Option(metavar="myoarm|FILE", help="Arm with muscles: myoarm, .osim or .xml.")
    ] = "myoarm",
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS", help="Address to listen on; 0.0.0.0 lets others on the network in."
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(metavar="N", help="Port; the next free one, if it is taken.")
    ] = 8080,
    export: Annotated[
        Path | None,
        typer.Option(metavar="FILE.html", help="Write the scene as one page and end."),
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE.json", help="Write the state and end.")
    ] = None,
    json: Json = False,
) -> int:
    """Open the studio: drag the hand, set joint ranges, play a recording."""
    for path in files or []:
        if not path.is_file():
            raise FileFormatError(f"{path}: no such file")
    if not 1 <= port <= 65535:
        raise RangeError(f"--port {port}: allowed is 1 to 65535")
    from selfmotion.arms.with_muscles import load_musculoskeletal_arm
    from selfmotion.viewer.state import load_state, save_state
    from selfmotion.viewer.studio import Address, Studio, require_viewer

    require_viewer()
    named = files or []
    states = [load_state(path) for path in named if path.suffix.lower() == ".json"]
    chosen = states[0].model if states and model == "myoarm" else model
    studio = Studio(load_musculoskeletal_arm(chosen), Address(host, port))
    try:
        for state in states:
            studio.restore(state)
        for path in named:
            if path.suffix.lower() != ".json":
                studio.playback.open(path)
        studio.settle()
        written = []
        if export is not None:
            written.append(str(studio.export(export)))
        if save is not None:
            written.append(str(save_state(save, studio.state())))
        serving = not written
        document = document_of(studio, named, written, serving)
        if serving and not json:
            typer.echo(f"The studio: {studio.url}   (end with Ctrl-C)")
        code = 0 if serving and not json else finish(document, as_text(document), json=json)
        if serving:
            wait_for_interrupt()
        return code
    finally:
        studio.close()


def wait_for_interrupt() -> None:
    """Serve until Ctrl-C, which is how a person ends the studio."""
    import contextlib
    import threading

    with contextlib.suppress(KeyboardInterrupt):
        threading.Event().wait()


def document_of(
    studio: "Studio", named: list[Path], written: list[str], serving: bool
) -> ViewDocument:
    """Describe what the studio shows."""
    shown = studio.posture.shown
    return ViewDocument(
        provenance=Provenance(
            "view",
            inputs={str(p): hash_file(p) for p in named},
            choices={"model": studio.model_name},
        ),
        url=studio.url if serving else None,
        files=written,
        coordinates=list(studio.model.arm.joints),
        q=shown.q.tolist() if shown else [],
        swivel=shown.swivel if shown else None,
        effort=shown.effort if shown else None,
        status=str(shown.status) if shown else "nothing was computed",
    )


def as_text(document: ViewDocument) -> str:
    """Write it as a person reads it."""
    return "\n".join([document.status, *(f"wrote {name}" for name in document.files)])
