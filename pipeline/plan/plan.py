"""The plan: which work items a run consists of, by content key, known before anything runs.

Keys are chained (an item's inputs are named by their keys), so that everything up to the selection is planned from the
configuration and the items' digests alone. Full trunks, CRS and construction are planned once the pairs are known,
the paper's method beside them, and motions, once it is known which constructions are certified.
"""

from __future__ import annotations

from collections.abc import Collection as Set
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection
from pipeline.datasets.colours import may_be_coloured
from pipeline.datasets.item import Item
from pipeline.plan.batches import cut
from pipeline.plan.part import Part
from pipeline.stages.registry import STAGES, Recipe, recipe
from pipeline.stages.specs import Place, Refined, Selecting, Starts
from pipeline.store.keys import KeyParts, digest_text

Reference = tuple[str, str]
"""(stage, key) of an artifact."""

Pair = tuple[int, int]
"""Positions of two items in the collection, the smaller first."""

SHARD = 640
"""Mean number of shapes in a part of the index of ``qcrs.mode=topk``, at most twice as many: what a worker holds at
once, about 0.4 MB a shape while it is read. Fewer take longer to search; more would grow with the collection."""


@dataclass(frozen=True)
class WorkItem:
    """One piece of work that makes one artifact.

    ``members`` are the positions of the items in the collection that it concerns: all of a batch, two of a pair.
    """

    parts: KeyParts
    parameters: tuple[Any, ...]
    sources: tuple[Reference, ...]
    spec: Any
    members: tuple[int, ...]

    @property
    def stage(self) -> str:
        """Name of its stage."""
        return self.parts.stage

    @cached_property
    def key(self) -> str:
        """Its content key."""
        return self.parts.key()

    @property
    def reference(self) -> Reference:
        """(stage, key)."""
        return self.stage, self.key


@dataclass(frozen=True)
class Plan:
    """Everything that is known when a run starts: items in canonical order, batches, and the static work items.

    ``qcrs`` scores pairs: the blocks, by their two batches; with ``qcrs.mode=topk`` the searches for partners, by batch
    and shard, after which ``pairs`` collects what they found. Without that mode there are no ``shards``, no ``pairs``.
    """

    config: Config
    items: tuple[Item, ...]
    batches: tuple[range, ...]
    recipes: dict[str, Recipe]
    ingest: tuple[WorkItem, ...]
    reversibility: tuple[WorkItem, ...]
    trunks: tuple[WorkItem, ...]
    qcrs: dict[Pair, WorkItem]
    shards: tuple[WorkItem, ...] = ()
    pairs: WorkItem | None = None

    def place(self, position: int) -> tuple[int, int]:
        """(batch, index within it) of an item."""
        for number, batch in enumerate(self.batches):
            if position in batch:
                return number, position - batch.start
        raise LookupError(f"no item {position} in a collection of {len(self.items)}")


def make_plan(config: Config, collection: Collection) -> Plan:
    """Plan all static work; ``collection.items`` must be in canonical order."""
    recipes = {stage.name: recipe(stage, config) for stage in STAGES}
    items = tuple(collection.items)
    batches = tuple(cut([item.digest for item in items], config.batch))
    ingest = tuple(_ingest(recipes["ingest"], items, batch) for batch in batches)
    reversibility = tuple(_after(recipes["reversibility"], one) for one in ingest)
    trunks = tuple(_after(recipes["trunks"], one) for one in ingest)
    plan = Plan(config, items, batches, recipes, ingest, reversibility, trunks, {})
    if config.qcrs.mode == "topk":
        return plan_search(plan, {item.reference for item in trunks})
    qcrs = {
        (a, b): _block(recipes["qcrs"], trunks[a], trunks[b], same=a == b)
        for a in range(len(batches))
        for b in range(a, len(batches))
    }
    return replace(plan, qcrs=qcrs)


def plan_alone(plan: Plan, position: int) -> dict[str, WorkItem]:
    """The stages of shapes for one item by itself, by name of the stage."""
    ingest = _ingest(plan.recipes["ingest"], plan.items, range(position, position + 1))
    return {
        "ingest": ingest,
        "reversibility": _after(plan.recipes["reversibility"], ingest),
        "trunks": _after(plan.recipes["trunks"], ingest),
    }


def plan_search(plan: Plan, done: Set[Reference]) -> Plan:
    """The plan with the search for partners among the batches whose trunks are done.

    Shards are runs of neighbouring batches, cut by content as batches are, so that a new shape changes its own.
    """
    present = [number for number, item in enumerate(plan.trunks) if item.reference in done]
    breaks = [place for place in range(1, len(present)) if present[place] != present[place - 1] + 1]
    spans: list[Sequence[int]] = []
    for low, high in pairwise([0, *breaks, len(present)]):
        # By the pictures, not by the keys: an edit of code or of a parameter leaves the spans as they are.
        contents = ["".join(plan.ingest[number].parts.inputs) for number in present[low:high]]
        cuts = cut(contents, max(1, SHARD // plan.config.batch))
        spans += [present[low + span.start : low + span.stop] for span in cuts]
    shards = tuple(_shard(plan, span) for span in spans)
    # By shard, so that a worker's tasks follow one another on the same.
    partners = {(b, s): _partners(plan, b, spans[s], shards[s]) for s in range(len(shards)) for b in present}
    plan = replace(plan, qcrs=partners, shards=shards)
    return plan_pairs(plan, {item.reference for item in partners.values()})


def plan_pairs(plan: Plan, done: Set[Reference]) -> Plan:
    """The plan with the collection of what the searches found that are done."""
    found = [(b, s, item.reference) for (b, s), item in plan.qcrs.items() if item.reference in done]
    # The first shape of a batch, and of a shard.
    spec = Starts(tuple((plan.batches[b].start, plan.shards[s].members[0]) for b, s, _ in found))
    of, sources = plan.recipes["pairs"], tuple(reference for *_, reference in found)
    parts = of.parts([key for _, key in sources], digest_text(repr(spec)))
    return replace(plan, pairs=WorkItem(parts, of.parameters, sources, spec, ()))


def whole_part(plan: Plan, place: Pair) -> Part:
    """All of a block, or of a search, of ``plan.qcrs``, as a part of it."""
    a, b = place
    columns = len(plan.batches[b]) if plan.pairs is None else 1
    return Part(plan.qcrs[place].spec, (0, len(plan.batches[a])), (0, columns))


def plan_part(plan: Plan, place: Pair, part: Part) -> WorkItem:
    """A part of a block, or of a search; of its rows and columns it has the members."""
    (a, b), whole = place, plan.qcrs[place]
    members = {plan.batches[a].start + row for row in range(*part.rows)}
    if plan.pairs is None:
        members |= {plan.batches[b].start + column for column in range(*part.columns)}
    of = plan.recipes[whole.stage]
    return WorkItem(of.parts(whole.parts.inputs, part), of.parameters, whole.sources, part, tuple(sorted(members)))


def plan_without(plan: Plan, place: Pair, lost: Sequence[Part]) -> WorkItem:
    """A block, or a search, without some parts: nothing does it at once, it is joined from the others."""
    whole = plan.qcrs[place]
    of = plan.recipes[whole.stage]
    return WorkItem(of.parts(whole.parts.inputs, lost), of.parameters, whole.sources, tuple(lost), whole.members)


def plan_select(plan: Plan, done: Set[Reference]) -> WorkItem:
    """The selection over the blocks that are done; unlike the other keys, its key holds the classes in order.

    With ``qcrs.mode=topk`` it is over the collected pairs, done or not, which number shapes by position, as the first
    batch does. A pair that is among the k best of all is among the k best of both its shapes: what is selected is what
    would be of all pairs as long as neither the limits nor the classes reach below any shape's k best.
    """
    if plan.pairs is None:
        blocks = {ab: item for ab, item in plan.qcrs.items() if item.reference in done}
    else:
        blocks = {(0, 0): plan.pairs} if plan.batches else {}
    rated = [number for number, item in enumerate(plan.reversibility) if item.reference in done]
    sources = [item.reference for item in blocks.values()] + [plan.reversibility[number].reference for number in rated]
    classes = tuple(item.cls for item in plan.items)
    spec = Selecting(classes, tuple(batch.start for batch in plan.batches), tuple(blocks), tuple(rated))
    of = plan.recipes["select"]
    # A digest instead of the spec itself: the manifest need not repeat every class.
    parts = of.parts([key for _, key in sources], digest_text(repr(spec)))
    return WorkItem(parts, of.parameters, tuple(sources), spec, ())


def plan_full_trunks(plan: Plan, pairs: Sequence[Pair]) -> dict[int, WorkItem]:
    """Full trunks of every shape of the pairs, by position."""
    of = plan.recipes["trunks_full"]
    work = {}
    for position in sorted({position for pair in pairs for position in pair}):
        batch, index = plan.place(position)
        # Named after the shape and not after its batch, so that it stays when the batch changes.
        parts = of.parts([shape_key(plan, position)])
        work[position] = WorkItem(parts, of.parameters, (plan.ingest[batch].reference,), index, (position,))
    return work


def plan_crs(plan: Plan, pairs: Sequence[Pair], full: dict[int, WorkItem]) -> list[WorkItem]:
    """CRS of every pair, in order."""
    of = plan.recipes["crs"]
    work = []
    for p, q in pairs:
        (batch_p, index_p), (batch_q, index_q) = plan.place(p), plan.place(q)
        batches = (plan.ingest[batch_p].reference, plan.ingest[batch_q].reference)
        parts = of.parts([full[p].key, full[q].key])
        sources = (*batches, full[p].reference, full[q].reference)
        work.append(WorkItem(parts, of.parameters, sources, (index_p, index_q), (p, q)))
    return work


def plan_refine(plan: Plan, crs: Sequence[WorkItem]) -> list[WorkItem]:
    """Refined trunks of every pair, in order."""
    of = plan.recipes["refine"]
    return [
        WorkItem(of.parts([cross.key]), of.parameters, (*cross.sources[:2], cross.reference), cross.spec, cross.members)
        for cross in crs
    ]


def plan_shortlist(plan: Plan, refined: Sequence[WorkItem]) -> WorkItem:
    """Which of the pairs with refined trunks, all of them done, are constructed."""
    of, sources = plan.recipes["shortlist"], tuple(item.reference for item in refined)
    pairs = tuple((item.members[0], item.members[1]) for item in refined)
    spec = Refined(tuple(item.cls for item in plan.items), pairs)
    parts = of.parts([key for _, key in sources], digest_text(repr(spec)))
    return WorkItem(parts, of.parameters, sources, spec, ())


def plan_construct(plan: Plan, refined: Sequence[WorkItem]) -> list[WorkItem]:
    """Construction of pairs with refined trunks, in order."""
    of = plan.recipes["construct"]
    work = []
    for item in refined:
        p, q = item.members
        names = (plan.items[p].name, plan.items[q].name)
        spec = ((item.spec[0], names[0]), (item.spec[1], names[1]))
        sources = (*item.sources, item.reference)
        work.append(WorkItem(of.parts([item.key], names), of.parameters, sources, spec, (p, q)))
    return work


def plan_paper(plan: Plan, best: Sequence[WorkItem]) -> list[WorkItem]:
    """The paper's method beside certified constructions, in order."""
    return [_after(plan.recipes["paper"], made) for made in best]


def plan_motions(plan: Plan, certified: Sequence[WorkItem]) -> list[WorkItem]:
    """Motion of every certified construction, in order."""
    return [_after(plan.recipes["motion"], made) for made in certified]


def plan_paint(plan: Plan, planned: Sequence[WorkItem]) -> list[WorkItem]:
    """Skins of the transforms with a motion whose inputs may have colours, in order; only of a folder of pictures."""
    work = [_with_pictures(plan, plan.recipes["paint"], motion) for motion in planned]
    return [item for item in work if item.spec is not None]


def plan_fabrications(plan: Plan, planned: Sequence[WorkItem]) -> list[WorkItem]:
    """Puzzles of transforms with a motion, in order; with paperwork, from the pictures that may have colours too."""
    of = plan.recipes["fabricate"]
    if not plan.config.fabricate.paper:
        return [_after(of, motion) for motion in planned]
    return [_with_pictures(plan, of, motion) for motion in planned]


def _ingest(of: Recipe, items: tuple[Item, ...], batch: range) -> WorkItem:
    members = items[batch.start : batch.stop]
    parts = of.parts([item.digest for item in members])
    return WorkItem(parts, of.parameters, (), members, tuple(batch))


def shape_key(plan: Plan, position: int) -> str:
    """The content key of one shape, whatever batch it is in."""
    return plan.recipes["ingest"].parts([plan.items[position].digest]).key()


def _after(of: Recipe, item: WorkItem) -> WorkItem:
    return WorkItem(of.parts([item.key]), of.parameters, (item.reference,), None, item.members)


def _with_pictures(plan: Plan, of: Recipe, motion: WorkItem) -> WorkItem:
    """What comes after a motion and reads the pictures that may have colours, of a folder; `_after` if none has."""
    if plan.config.dataset.kind != "folder":
        return _after(of, motion)
    pictures = [plan.items[position] for position in motion.members]
    spec = tuple(item if may_be_coloured(item) else None for item in pictures)
    if spec == (None, None):
        return _after(of, motion)
    inputs = [motion.key, *(item.digest for item in spec if item is not None)]
    parts = of.parts(inputs, [item is not None for item in spec])
    return WorkItem(parts, of.parameters, (motion.reference,), spec, motion.members)


def _shard(plan: Plan, batches: Sequence[int]) -> WorkItem:
    of, sources = plan.recipes["shards"], tuple(plan.trunks[number].reference for number in batches)
    members = tuple(position for number in batches for position in plan.batches[number])
    return WorkItem(of.parts([key for _, key in sources]), of.parameters, sources, None, members)


def _partners(plan: Plan, batch: int, span: Sequence[int], shard: WorkItem) -> WorkItem:
    of, query, start = plan.recipes["partners"], plan.trunks[batch], plan.batches[batch].start
    place = Place(start - shard.members[0] if batch in span else -1, batch > span[-1])
    parts = of.parts([query.key, shard.key], place)
    return WorkItem(parts, of.parameters, (query.reference, shard.reference), place, query.members)


def _block(of: Recipe, a: WorkItem, b: WorkItem, *, same: bool) -> WorkItem:
    members = a.members if same else a.members + b.members
    sources = (a.reference,) if same else (a.reference, b.reference)
    return WorkItem(of.parts([key for _, key in sources]), of.parameters, sources, same, members)
