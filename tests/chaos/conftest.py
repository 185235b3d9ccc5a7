from __future__ import annotations

from collections.abc import Iterator

import pytest
from chaos.nursery import Nursery, open_nursery
from chaos.victims import Undisturbed as Undisturbed
from chaos.victims import begun, committed, mine, settings
from integration.small_runs import digests, pictures

from pipeline.store.store import Store


@pytest.fixture(scope="session")
def nursery() -> Iterator[Nursery]:
    with open_nursery() as opened:
        yield opened


@pytest.fixture(scope="session")
def undisturbed(nursery: Nursery, tmp_path_factory: pytest.TempPathFactory) -> Undisturbed:
    where = tmp_path_factory.mktemp("undisturbed")
    root = pictures(where / "pictures", range(7))
    config = settings(root, where)
    assert nursery.call(mine, config, where / "log") == 0
    found = Undisturbed(where, root, digests(where), committed(Store(config.store)))
    assert len(begun(where / "log")) == len(found.artifacts) > 20
    return found
