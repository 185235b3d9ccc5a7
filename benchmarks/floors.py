"""Floors: the least that a step must count, over rates that small probes measure in the same run.

A floor is no promise: it leaves out whatever another method might avoid. It tells how much of a step's time is the
step's own doing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from measure import least_seconds

from riot.kernels.options import kernel
from riot.parameters import QcrsParameters
from riot.scores.qcrs import BlockScores
from riot.scores.trunk_stack import TrunkStack
from riot.scores.trunks import Trunks
from riot.types import FloatArray, IntArray
from riot.units import D_C

CORNER_BYTES = 28
"""Of a trunk's corner in `riot.scores.trunks.Trunks`: vertex, edge, two angles."""

TRUNK_BYTES = 16
"""Of a trunk beside its corners: offset and area."""

PIXEL_RUN = 1 << 23
"""Values that the probe of the memory copies: more than a cache holds."""


@dataclass(frozen=True)
class Rates:
    """What this machine does in a second, on one core."""

    bytes: float
    """Bytes read or written, of arrays larger than the caches."""
    differences: float
    """|a − b| added up, float64, in the first cache, as many at once as the processor can."""
    corners: float
    """Lengths and angles (hypot and arctan2) of a trunk's corner."""


@dataclass(frozen=True)
class Floor:
    """The least milliseconds of an item, what was counted, and in words."""

    ms: float
    counts: dict[str, float]
    says: str


@kernel
def _differences(a: FloatArray, b: FloatArray, x: FloatArray, out: FloatArray, rounds: int) -> None:
    """Eight |a − x| a value, 2 × 4, ``rounds`` times."""
    m = len(out)
    for r in range(rounds):
        x0, x1, x2, x3 = x[r], x[r + 1], x[r + 2], x[r + 3]
        for k in range(m):
            first = abs(a[k] - x0) + abs(a[k] - x1) + abs(a[k] - x2) + abs(a[k] - x3)
            out[k] += first + abs(b[k] - x0) + abs(b[k] - x1) + abs(b[k] - x2) + abs(b[k] - x3)


def measure_rates() -> Rates:
    """Run the probes: a fraction of a second."""
    source, target = np.ones(PIXEL_RUN), np.zeros(PIXEL_RUN)
    copied = least_seconds(lambda: np.copyto(target, source))

    values = np.linspace(0.0, 1.0, 512)
    out, rounds = np.zeros(512), 2000
    x = np.linspace(0.0, 1.0, rounds + 4)
    _differences(values, values[::-1].copy(), x, out, 1)
    added = least_seconds(lambda: _differences(values, values[::-1].copy(), x, out, rounds))

    across = np.linspace(0.1, 1.0, 100_000)
    turned = least_seconds(lambda: (np.hypot(across, values[3]), np.arctan2(across, values[5])))
    return Rates(16.0 * PIXEL_RUN / copied, 8.0 * 512 * rounds / added, len(across) / turned)


def picture_floor(decoding_ms: float, pixels: float, bytes_: float, rates: Rates) -> Floor:
    """Decoding by Pillow, and every pixel read once."""
    counts = {"file_bytes": bytes_, "pixels": pixels}
    says = f"decoding {bytes_ / 1e3:.1f} kB, reading {pixels / 1e3:.0f} k pixels once"
    return Floor(decoding_ms + 1e3 * pixels / rates.bytes, counts, says)


def necks_floor(concave: float, points: float, rates: Rates) -> Floor:
    """The ratio of every concave vertex to every boundary point; counted as four differences."""
    counts = {"ratios": concave * points}
    return Floor(4e3 * concave * points / rates.differences, counts, f"{concave * points:.0f} ratios of distances")


def trunks_floor(shapes: list[Trunks], rates: Rates) -> Floor:
    """Length and angle of every corner that is given back, and its bytes written once."""
    corners = float(np.mean([len(trunks.edges) for trunks in shapes]))
    trunks = float(np.mean([len(trunks) for trunks in shapes]))
    written = CORNER_BYTES * corners + TRUNK_BYTES * trunks
    ms = 1e3 * max(corners / rates.corners, written / rates.bytes)
    counts = {"trunks": trunks, "corners": corners, "bytes": written}
    return Floor(ms, counts, f"{trunks:.0f} trunks: length and angle of {corners:.0f} corners")


def stack_floor(stacks: list[TrunkStack], rates: Rates) -> Floor:
    """The bytes of the stacks, read once and written once."""
    moved = 2.0 * sum(array.nbytes for stack in stacks for array in stack.to_arrays().values())
    moved /= sum(len(stack) for stack in stacks)
    return Floor(1e3 * moved / rates.bytes, {"bytes": moved}, f"{moved / 1e3:.0f} kB read and written")


def brute_floor(a: TrunkStack, pairs: int, rates: Rates) -> Floor:
    """3 n² differences for each trunk pair of one n."""
    trunk_pairs, differences = 0.0, 0.0
    tables = _sizes(a)
    for i in range(len(a)):
        for j in range(i + 1, len(a)):
            both = tables[i] * tables[j]
            trunk_pairs += float(both.sum())
            differences += float((3 * np.arange(len(both)) ** 2 * both).sum())
    counts = {"trunk_pairs": trunk_pairs / pairs, "differences": differences / pairs}
    ms = 1e3 * differences / pairs / rates.differences
    return Floor(
        ms, counts, f"{counts['differences']:.3g} differences (3n² for {counts['trunk_pairs']:.3g} trunk pairs)"
    )


def quick_floor(a: TrunkStack, scores: BlockScores, rates: Rates, parameters: QcrsParameters | None = None) -> Floor:
    """What no exact search is spared: to read both stacks, and at the least distance, once it is known, to compare the
    edges at every shift, n² differences, of the trunk pairs that the bounds do not exclude.

    The bounds are area, perimeter, the sums of β, and edges and angles in ascending order.
    """
    parameters = parameters or QcrsParameters()
    counts = np.zeros(4)
    sizes, starts = np.diff(a.offsets), np.array(a.starts)
    which = np.repeat(np.arange(len(sizes)), sizes)
    edges, alphas, betas = (values[np.lexsort([values, which])] for values in (a.edges, a.alphas, a.betas))
    units = (parameters.sigma_e * D_C, parameters.sigma_angle, parameters.sigma_area)
    with np.errstate(divide="ignore"):
        distance = np.sqrt(-2.0 * np.log(scores.score))
    rows, columns = scores.i.astype(np.int64), scores.j.astype(np.int64)
    trunks = starts, np.array(a.offsets), np.array(a.areas)
    _count_survivors(rows, columns, distance, *trunks, edges, alphas, betas, units, counts)
    trunk_pairs, window, survivors, differences = (float(count) / len(distance) for count in counts)
    stack_bytes = sum(array.nbytes for array in a.to_arrays().values()) / len(a)
    # A block of 32 × 32 shapes reads each stack once for 32 pairs.
    read = 2.0 * stack_bytes / 32
    ms = 1e3 * max(differences / rates.differences, read / rates.bytes)
    says = f"{trunk_pairs:.3g} trunk pairs, {window:.3g} in the area window, {survivors:.3g} no bound excludes"
    counted = {"trunk_pairs": trunk_pairs, "area_window": window, "survivors": survivors}
    return Floor(ms, {**counted, "differences": differences, "bytes": read}, says)


@kernel
def _count_survivors(
    rows: IntArray,
    columns: IntArray,
    distance: FloatArray,
    starts: IntArray,
    offsets: IntArray,
    areas: FloatArray,
    edges: FloatArray,
    alphas: FloatArray,
    betas: FloatArray,
    units: tuple[float, float, float],
    counts: FloatArray,
) -> None:
    """Add to ``counts`` (4,) trunk pairs of one n, those in the area window, those no bound excludes, their n²."""
    for k in range(len(rows)):
        i, j = rows[k], columns[k]
        # A little less than the distance: rounding must not count too many.
        limit = distance[k] * (1.0 - 1e-9)
        for t in range(starts[i], starts[i + 1]):
            x, n = offsets[t], offsets[t + 1] - offsets[t]
            for u in range(starts[j], starts[j + 1]):
                y = offsets[u]
                if offsets[u + 1] - y != n:
                    continue
                counts[0] += 1.0
                if 2.0 * abs(areas[t] + areas[u] - 1.0) >= limit * units[2]:
                    continue
                counts[1] += 1.0
                edge, angle = 0.0, 0.0
                for m in range(n):
                    edge += abs(edges[x + m] - edges[y + m])
                    angle += abs(alphas[x + m] - betas[y + m]) + abs(betas[x + m] - alphas[y + m])
                # The sums of edges and of β are implied: an L1 distance is no less than the difference of sums.
                if edge >= limit * n * units[0] or angle >= limit * 2.0 * n * units[1]:
                    continue
                counts[2] += 1.0
                counts[3] += n * n


def _sizes(a: TrunkStack) -> FloatArray:
    """(shapes, n) how many trunks of n corners each shape has."""
    sizes = np.diff(a.offsets)
    table = np.zeros((len(a), int(sizes.max(initial=0)) + 1))
    for i in range(len(a)):
        own = sizes[a.starts[i] : a.starts[i + 1]]
        table[i, : own.max(initial=0) + 1] = np.bincount(own, minlength=1)
    return table


def distance_of(ms: float, floor: Floor | None) -> float | None:
    """How many times the floor a time is; None without one."""
    if floor is None or not floor.ms > 0.0 or math.isnan(ms):
        return None
    return ms / floor.ms
