"""Keys: equal content has equal keys, other content others, whatever the memory layout, the process or the order."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from pipeline.store.keys import KeyParts, SharedText, canonical_value, digest_array

arrays = npst.arrays(
    dtype=st.sampled_from([np.float64, np.float32, np.int64, np.int32, np.int8, np.bool_]),
    shape=npst.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=5),
)
square = npst.arrays(dtype=np.float64, shape=st.integers(2, 5).map(lambda n: (n, n)), elements=st.floats(-9, 9))


def parts(**changes: object) -> KeyParts:
    values: dict[str, object] = {
        "stage": "trunks",
        "parameters": {"trunks": {"tau_s": 0.1, "max_vertices": 8}},
        "inputs": ("aa", "bb"),
        "code": {"riot.scores.trunks": "11", "riot.geometry.shape": "22"},
        "versions": {"numpy": "2.0"},
    }
    return KeyParts(**{**values, **changes})  # type: ignore[arg-type]


@settings(max_examples=40)
@given(arrays)
def test_memory_layout_and_byte_order_do_not_count(array: np.ndarray) -> None:
    expected = digest_array(array)
    assert digest_array(np.asfortranarray(array)) == expected
    assert digest_array(array.astype(array.dtype.newbyteorder(">"))) == expected
    padded = np.zeros((*array.shape, 2), dtype=array.dtype)
    padded[..., 0] = array
    assert digest_array(padded[..., 0]) == expected


@settings(max_examples=40)
@given(square)
def test_a_transposed_square_matrix_is_another_one(array: np.ndarray) -> None:
    assert (digest_array(array) == digest_array(array.T)) == np.array_equal(array, array.T)


@settings(max_examples=40)
@given(npst.arrays(np.float64, st.integers(2, 12), elements=st.floats(-9, 9)), st.data())
def test_a_slice_is_its_values_and_not_its_buffer(array: np.ndarray, data: st.DataObject) -> None:
    cut = data.draw(st.integers(1, len(array) - 1))
    assert digest_array(array[cut:]) == digest_array(array[cut:].copy())
    assert digest_array(array[cut:]) != digest_array(array)


@settings(max_examples=40)
@given(npst.arrays(np.float64, st.integers(1, 8), elements=st.floats(-9, 9)), st.data())
def test_a_changed_value_changes_the_digest(array: np.ndarray, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(array) - 1))
    changed = array.copy()
    changed[at] += 1.0
    assert digest_array(changed) != digest_array(array)


@settings(max_examples=40)
@given(npst.arrays(np.float64, st.tuples(st.integers(3, 8), st.just(2)), elements=st.floats(-9, 9)), st.integers(1, 7))
def test_another_start_vertex_is_another_outline(points: np.ndarray, by: int) -> None:
    turned = np.roll(points, by, axis=0)
    assert (digest_array(turned) == digest_array(points)) == np.array_equal(turned, points)


@settings(max_examples=40)
@given(arrays, arrays)
def test_equal_digests_mean_equal_arrays(a: np.ndarray, b: np.ndarray) -> None:
    same = a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f" and b.dtype.kind == "f")
    assert (digest_array(a) == digest_array(b)) == same


def test_zeros_and_nans_have_one_form_each() -> None:
    quiet, other = np.array([np.nan]), np.array([0x7FF8000000000123], dtype=np.uint64).view(np.float64)
    assert np.isnan(other).all()
    assert digest_array(quiet) == digest_array(other)
    assert digest_array(np.array([-0.0])) == digest_array(np.array([0.0]))
    assert digest_array(np.array([0.0])) != digest_array(np.array([np.nan]))


def test_dtype_and_shape_count() -> None:
    zeros = np.zeros(4)
    assert (
        len({digest_array(a) for a in (zeros, zeros.reshape(2, 2), zeros.astype(np.float32), zeros.astype(np.int64))})
        == 4
    )
    assert digest_array(np.float64(1.0)) != digest_array(np.array([1.0]))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "changes",
    [
        {"stage": "crs"},
        {"parameters": {"trunks": {"tau_s": 0.2, "max_vertices": 8}}},
        {"parameters": {"trunks": {"max_vertices": 8}}},
        {"inputs": ("bb", "aa")},
        {"inputs": ("aab", "b")},
        {"code": {"riot.scores.trunks": "12", "riot.geometry.shape": "22"}},
        {"versions": {"numpy": "2.1"}},
        {"schema": 2},
    ],
)
def test_every_component_counts(changes: dict[str, object]) -> None:
    assert parts(**changes).key() != parts().key()


@pytest.mark.parametrize("inputs", [(), ("aa",), ("bb", 'q"uote')])
def test_text_that_keys_share_changes_no_key(inputs: tuple[str, ...]) -> None:
    shared = SharedText.of(parts(inputs=("others",)))
    assert parts(inputs=inputs, shared=shared).key() == parts(inputs=inputs).key()


def test_the_order_of_names_does_not_count() -> None:
    assert parts(code={"riot.geometry.shape": "22", "riot.scores.trunks": "11"}).key() == parts().key()
    assert parts(parameters={"trunks": {"max_vertices": 8, "tau_s": 0.1}}).key() == parts().key()


def test_keys_are_the_same_in_every_process() -> None:
    script = (
        "import numpy as np; from pipeline.store.keys import KeyParts, digest_array;"
        "p = KeyParts('s', {'x': {'b': 1.5, 'a': None}, 'set': [1, 2]}, ('i',), {'m': 'd'}, {'v': '1'});"
        "print(p.key(), digest_array(np.arange(6.0).reshape(2, 3)))"
    )
    answers = {
        subprocess.run(
            [sys.executable, "-c", script], env={"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
        ).stdout
        for seed in ("0", "1")
    }
    assert len(answers) == 1 and len(answers.pop().split()[0]) == 64


def test_nothing_enters_a_key_by_its_repr() -> None:
    with pytest.raises(TypeError):
        canonical_value({"x": object()})
    with pytest.raises(TypeError):
        canonical_value({1: "x"})
    with pytest.raises(TypeError):
        digest_array(np.array([object()]))
