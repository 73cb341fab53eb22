"""Observations as packed rows and network inputs."""

from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from ltlc.agents.encoder import COUNTED, JOINT_LIMIT, ObservationEncoder, n_features, without_texts
from ltlc.errors import InvalidArgumentError

SPACES = [
    spaces.Discrete(7, start=-2),
    spaces.MultiDiscrete([3, 4], start=[1, 0]),
    spaces.MultiBinary(3),
    spaces.Box(np.array([-1.0, 0.0]), np.array([1.0, np.inf]), dtype=np.float64),
    spaces.Box(0, 255, (4, 4, 3), dtype=np.uint8),
    spaces.Dict({"a": spaces.Discrete(3), "b": spaces.Tuple([spaces.MultiBinary(2), spaces.Box(0.0, 1.0, (2,))])}),
]


def features(encoder: ObservationEncoder, batch: Any) -> np.ndarray:
    return encoder.features(torch.from_numpy(encoder.pack(batch))).numpy()


PICTURE = spaces.Box(0, 255, (4, 4, 3), dtype=np.uint8)


@pytest.mark.parametrize(
    ("space", "bytes_in_a_row"),
    [
        (PICTURE, 48),
        (spaces.Dict({"picture": PICTURE, "direction": spaces.Discrete(4)}), 48 + 8),
        (spaces.Tuple([spaces.Box(-1.0, 1.0, (3,)), PICTURE, spaces.MultiBinary(5)]), 12 + 48 + 5),
        (spaces.Box(-7, 7, (6,), dtype=np.int8), 6),
        (spaces.Box(-300, 300, (6,), dtype=np.int16), 12),
        (spaces.Box(-1.0, 1.0, (6,), dtype=np.float64), 24),
    ],
    ids=str,
)
def test_every_part_is_packed_as_its_own_kind(space: spaces.Space[Any], bytes_in_a_row: int) -> None:
    encoder = ObservationEncoder(space, "raw")
    assert encoder.width * np.dtype(encoder.dtype).itemsize == bytes_in_a_row
    batch = batch_space(space, 5)
    batch.seed(1)
    sample = batch.sample()
    parts = sample.values() if isinstance(sample, dict) else sample if isinstance(sample, tuple) else [sample]
    expected = np.concatenate([np.reshape(part, (5, -1)).astype(np.float32) for part in parts], axis=1)
    assert np.array_equal(features(encoder, sample), expected)
    one = encoder.features(torch.from_numpy(encoder.pack(sample))[3:4])  # a row that does not begin at an even address
    assert np.array_equal(one.numpy(), expected[3:4])


@pytest.mark.parametrize("space", SPACES, ids=str)
@pytest.mark.parametrize("mode", ["one-hot", "raw"])
def test_batches_of_every_space_are_encoded(space: spaces.Space[Any], mode: Any) -> None:
    batch = batch_space(space, 5)
    batch.seed(0)
    encoder = ObservationEncoder(space, mode)
    packed = encoder.pack(batch.sample())
    assert packed.shape == (5, encoder.width) and packed.dtype == encoder.dtype
    inputs = encoder.features(torch.from_numpy(packed))
    assert inputs.shape == (5, encoder.n_features) and inputs.dtype == torch.float32


def test_discrete_numbers_become_one_joint_indicator() -> None:
    encoder = ObservationEncoder(spaces.MultiDiscrete([3, 4], start=[1, 0]))
    inputs = features(encoder, np.array([[1, 0], [3, 2]]))
    assert inputs.shape == (2, 12)
    assert inputs.argmax(axis=1).tolist() == [0, 2 * 4 + 2]
    assert np.array_equal(features(encoder, encoder.all_observations()), np.eye(12))
    index = encoder.index(torch.from_numpy(encoder.pack(encoder.all_observations())))
    assert index.tolist() == list(range(12))


def test_many_discrete_numbers_get_an_indicator_each() -> None:
    encoder = ObservationEncoder(spaces.MultiDiscrete([JOINT_LIMIT, 2]))
    assert encoder.n_features == JOINT_LIMIT + 2 and encoder.n_observations == 2 * JOINT_LIMIT
    inputs = features(encoder, np.array([[5, 1]]))
    assert np.flatnonzero(inputs[0]).tolist() == [5, JOINT_LIMIT + 1]


def test_raw_numbers_stay_as_they_are() -> None:
    encoder = ObservationEncoder(spaces.MultiDiscrete([10, 10]), "raw")
    assert features(encoder, np.array([[8, 3]])).tolist() == [[8.0, 3.0]]
    assert encoder.n_observations == 100


def test_bounded_parts_of_a_box_are_scaled() -> None:
    space = spaces.Box(np.array([0.0, -np.inf]), np.array([4.0, 3.0]), dtype=np.float64)
    assert features(ObservationEncoder(space), np.array([[3.0, 2.0]])).tolist() == [[0.5, 2.0]]
    assert features(ObservationEncoder(space, "raw"), np.array([[3.0, 2.0]])).tolist() == [[3.0, 2.0]]


def test_images_are_kept_as_bytes() -> None:
    encoder = ObservationEncoder(spaces.Box(0, 255, (2, 2), dtype=np.uint8))
    assert encoder.dtype == np.uint8
    assert features(encoder, np.full((1, 2, 2), 255, dtype=np.uint8)).tolist() == [[1.0] * 4]


def test_spaces_without_a_fixed_size_are_refused() -> None:
    with pytest.raises(InvalidArgumentError, match=r"cannot take observations of Sequence.*part \('words',\)"):
        ObservationEncoder(spaces.Dict({"words": spaces.Sequence(spaces.Discrete(2))}))
    with pytest.raises(InvalidArgumentError, match="cannot take observations of Text"):
        ObservationEncoder(spaces.Text(5))
    with pytest.raises(InvalidArgumentError, match="has no numbers"):
        ObservationEncoder(spaces.Dict({"words": spaces.Text(5)}))


def test_observations_that_are_no_numbers_are_refused() -> None:
    encoder = ObservationEncoder(spaces.Box(-1.0, 1.0, (2,)))
    with pytest.raises(InvalidArgumentError, match="NaN or infinite"):
        encoder.pack(np.array([[0.0, np.nan]], dtype=np.float32))
    with pytest.raises(InvalidArgumentError, match="do not fit"):
        encoder.pack(np.zeros((4, 3), dtype=np.float32))


def test_a_number_of_many_values_is_shown_by_its_digits() -> None:
    encoder = ObservationEncoder(spaces.Discrete(1_000_000, start=1))
    assert encoder.n_features == 64 + 64 + 64 + 4 == n_features(encoder.space, "one-hot")
    number = 5 + 64 * (7 + 64 * (63 + 64 * 3))
    inputs = features(encoder, np.array([number + 1]))
    assert np.flatnonzero(inputs[0]).tolist() == [5, 64 + 7, 128 + 63, 192 + 3]


NUMBERED = [
    (spaces.Discrete(4), 4),
    (spaces.Discrete(4097, start=-5), 4097),
    (spaces.MultiDiscrete([70, 70]), 4900),
    (spaces.MultiDiscrete([[2, 3], [1, 2]], start=[[0, 1], [2, 3]]), 12),
    (spaces.MultiBinary([2, 2]), 16),
    (spaces.Box(-2, 3, (2,), dtype=np.int32), 36),
    (spaces.Dict({"x": spaces.Tuple([spaces.Discrete(4)])}), 4),
    (spaces.Dict({"a": spaces.Discrete(5), "b": spaces.Discrete(5, start=2)}), 25),
    (spaces.Tuple([spaces.Text(9), spaces.MultiBinary(2), spaces.Dict({"k": spaces.Discrete(3)})]), 12),
]


@pytest.mark.parametrize(("space", "count"), NUMBERED, ids=str)
def test_all_observations_are_a_batch_of_the_space(space: spaces.Space[Any], count: int) -> None:
    encoder = ObservationEncoder(space)
    assert encoder.discrete and encoder.n_observations == count
    packed = torch.from_numpy(encoder.pack(encoder.all_observations()))
    assert encoder.index(packed).tolist() == list(range(count))
    assert len(torch.unique(packed, dim=0)) == count
    if isinstance(space, spaces.Discrete) and space.n <= JOINT_LIMIT:
        assert (encoder.all_features() == torch.eye(count)).all()


@pytest.mark.parametrize(
    ("space", "discrete"),
    [
        (spaces.Discrete(COUNTED + 1), True),
        (spaces.MultiBinary(60), True),
        (spaces.Box(0, 255, (7, 7, 3), dtype=np.uint8), True),
        (spaces.Box(0, 1, (2,), dtype=np.float32), False),
        (spaces.Box(np.iinfo(np.int64).min, 5, (1,), dtype=np.int64), False),
        (spaces.Dict({"a": spaces.Discrete(5), "b": spaces.Box(0.0, 1.0, (1,))}), False),
    ],
    ids=str,
)
def test_what_is_not_numbered(space: spaces.Space[Any], discrete: bool) -> None:
    encoder = ObservationEncoder(space)
    assert encoder.discrete == discrete and encoder.n_observations == 0


class Mission(spaces.Space[str]):
    """Texts of somebody's own."""

    def __init__(self) -> None:
        super().__init__(dtype=str)


def test_texts_are_left_out() -> None:
    space = spaces.Dict({"goal": spaces.Tuple([Mission(), spaces.Discrete(3)]), "words": spaces.Text(5)})
    encoder = ObservationEncoder(without_texts(space))
    assert encoder.ignored == ["goal.0", "words"] and encoder.width == 1
    assert ObservationEncoder(space).ignored == encoder.ignored
    assert repr(without_texts(Mission())) == repr(spaces.Text(1))
    plain = spaces.Dict({"a": spaces.Discrete(2)})
    assert without_texts(plain) is plain
    batch = {"goal": (("go", "stop"), np.array([2, 0])), "words": ("a", "b")}
    assert encoder.pack(batch).tolist() == [[2], [0]]
