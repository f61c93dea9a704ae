import threading

from selfmotion.viewer.latest import Latest


def test_only_the_latest_request_is_answered_while_one_is_at_work():
    answered, begin, go_on = [], threading.Event(), threading.Event()

    def work(request: int) -> None:
        begin.set()
        go_on.wait(10.0)
        answered.append(request)

    worker = Latest(work, lambda error: None)
    worker.ask(0)
    assert begin.wait(10.0)
    for request in range(1, 50):
        worker.ask(request)
    go_on.set()
    assert worker.wait(10.0)
    assert answered == [0, 49]
    worker.stop()


def test_an_error_is_told_and_the_next_request_is_answered():
    errors, answered = [], []

    def work(request: int) -> None:
        if request < 0:
            raise ValueError("negative")
        answered.append(request)

    worker = Latest(work, errors.append)
    worker.ask(-1)
    assert worker.wait(10.0)
    worker.ask(1)
    assert worker.wait(10.0)
    assert answered == [1] and [str(e) for e in errors] == ["negative"]
    assert worker.done == 2
    worker.stop()
