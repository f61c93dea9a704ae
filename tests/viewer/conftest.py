"""One studio for all tests of a file: starting one takes seconds."""

import socket
from collections.abc import Iterator

import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture(scope="module")
def studio() -> Iterator:
    pytest.importorskip("viser", reason="needs the extra: pip install 'selfmotion[viewer]'")
    from selfmotion.viewer.studio import Address, Studio

    made = Studio(load_musculoskeletal_arm(), Address(port=free_port()))
    told: list[str] = []
    complain = made.complain

    def listen(error: Exception) -> None:
        told.append(repr(error))
        complain(error)

    made.complain = listen
    made.posture.worker._failed = made.reach.worker._failed = listen
    assert made.settle()
    yield made
    made.close()
    assert not [text for text in told if not text.startswith(("RangeError", "UnknownName"))]
