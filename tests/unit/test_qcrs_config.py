"""`qcrs.variant`: which sigmas a run scores with, and which stages depend on it."""

from __future__ import annotations

import pytest

from pipeline.config.build import make_config
from pipeline.config.schema import Config
from pipeline.errors import ConfigError
from pipeline.stages.all import BY_NAME
from riot.parameters import QCRS_VARIANTS, QcrsParameters


def configured(**qcrs: object) -> Config:
    return make_config({"dataset": {"name": "sample", "kind": "sample"}, "qcrs": qcrs})


def test_a_variant_has_its_own_sigmas_unless_they_are_given() -> None:
    assert configured().qcrs.sigmas == QcrsParameters()
    assert configured(variant="tuned").qcrs.sigmas == QCRS_VARIANTS["tuned"]
    given = configured(variant="tuned", sigma_e=0.2).qcrs.sigmas
    assert given == QcrsParameters(0.2, QCRS_VARIANTS["tuned"].sigma_angle, QCRS_VARIANTS["tuned"].sigma_area)
    assert configured(sigma_area=QCRS_VARIANTS["tuned"].sigma_area).qcrs.sigmas == QCRS_VARIANTS["tuned"]


@pytest.mark.parametrize(
    ("values", "words"),
    [({"variant": "best"}, ["qcrs.variant", "paper, tuned"]), ({"sigma_e": 0.0}, ["qcrs.sigma_e", "greater than 0"])],
)
def test_mistakes_are_named(values: dict[str, object], words: list[str]) -> None:
    with pytest.raises(ConfigError) as caught:
        configured(**values)
    assert all(word in str(caught.value) for word in words)


def test_trunks_depend_on_the_variant_and_not_on_sigmas() -> None:
    usual, tuned = configured(), configured(variant="tuned")
    loose = configured(sigma_area=0.3)
    assert BY_NAME["trunks"].recipe(usual).values != BY_NAME["trunks"].recipe(tuned).values
    assert BY_NAME["trunks"].recipe(usual).values == BY_NAME["trunks"].recipe(loose).values
    assert BY_NAME["qcrs"].recipe(usual).values != BY_NAME["qcrs"].recipe(loose).values
    # Full trunks are the same for both.
    assert BY_NAME["trunks_full"].recipe(usual).values == BY_NAME["trunks_full"].recipe(tuned).values
