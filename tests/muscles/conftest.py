import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm


@pytest.fixture(scope="session")
def muscle_arm():
    return load_musculoskeletal_arm()
