"""Files made to harm: each is refused by a limit, with what, where and what to do, in bounded time and memory."""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw

from riot.errors import FormatError, SilhouetteError
from riot.geometry import limits as untrusted
from riot.geometry.limits import TooManyBytes, check_file, read_bytes
from riot.geometry.silhouette import polygon_shape, read
from riot.geometry.svg_outline import outline
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.riot_file import MAX_PIECES, MAX_POINTS, from_json, load, to_json

SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 100 100">'


def refused(path: Path) -> tuple[str, str]:
    """Reason and message with which a file is refused; the message names the file and says what to do."""
    with pytest.raises(SilhouetteError) as caught:
        read(path)
    message = str(caught.value)
    assert path.name in message and ";" in message
    return caught.value.reason, message


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width: int, height: int, data: bytes, *more: bytes) -> bytes:
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + b"".join(more) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def drawing(folder: Path, body: str, head: str = SVG) -> Path:
    path = folder / "drawing.svg"
    path.write_text(f"{head}{body}</svg>", encoding="utf-8")
    return path


@pytest.mark.parametrize("form", ["PNG", "GIF", "TIFF", "BMP"])
def test_a_decompression_bomb_is_refused_by_its_header(tmp_path: Path, form: str) -> None:
    """A blank picture of many more pixels than may be is a small file; its pixels are never decoded."""
    path = tmp_path / f"bomb.{form.lower()}"
    if form == "PNG":
        path.write_bytes(png(100_000, 100_000, zlib.compress(bytes(1000))))
    else:
        options = {"compression": "tiff_deflate"} if form == "TIFF" else {}
        Image.new("1", (100, 100)).save(path, form, **options)
        data = bytearray(path.read_bytes())
        for at, size in {"GIF": ((6, 2), (8, 2)), "BMP": ((18, 4), (22, 4)), "TIFF": ()}[form]:
            data[at : at + size] = (2 ** (8 * size - 1) // (1 if size == 2 else 16_384)).to_bytes(size, "little")
        if form == "TIFF":
            data = tiff_sizes(data, 100_000)
        path.write_bytes(data)
    refusal = refused(path)
    assert refusal[0] == "too-large" and "scale the picture down" in refusal[1]


def tiff_sizes(data: bytearray, side: int) -> bytearray:
    """A little-endian TIFF with another width and height (tags 256 and 257)."""
    (first,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, first)
    for k in range(count):
        at = first + 2 + 12 * k
        if struct.unpack_from("<H", data, at)[0] in (256, 257):
            struct.pack_into("<HII", data, at + 2, 4, 1, side)
    return data


def test_a_picture_that_grows_while_it_is_unpacked_is_cut_off(tmp_path: Path) -> None:
    """Rows and text beyond what the header tells are not unpacked: ten megabytes of zeros are ten kilobytes."""
    zeros = zlib.compress(bytes(10_000_000), 9)
    rows = tmp_path / "rows.png"
    rows.write_bytes(png(16, 16, zeros))
    assert refused(rows)[0] == "one-colour"
    text = tmp_path / "text.png"
    text.write_bytes(png(16, 16, zlib.compress(bytes(48)), chunk(b"zTXt", b"Comment\0\0" + zeros)))
    assert refused(text)[0] == "unreadable"


def test_of_many_frames_the_first_is_the_picture(tmp_path: Path) -> None:
    frames = [Image.new("L", (60, 60)) for _ in range(50)]
    for number, frame in enumerate(frames):
        ImageDraw.Draw(frame).rectangle((10, 10, 49 - number // 2, 29), fill=255)
    shapes = []
    for name, options in (("one.gif", {}), ("all.gif", {"save_all": True, "append_images": frames[1:]})):
        frames[0].save(tmp_path / name, **options)
        shapes.append(read(tmp_path / name))
    assert np.array_equal(shapes[0].points, shapes[1].points)


def test_other_decoders_do_not_run(tmp_path: Path) -> None:
    """Pillow knows more formats, some of them by starting other programs."""
    image = Image.new("L", (60, 60))
    ImageDraw.Draw(image).rectangle((10, 10, 40, 30), fill=255)
    for form in ("TGA", "EPS", "PPM", "ICO", "PDF"):
        path = tmp_path / "picture.png"
        image.save(path, form)
        assert refused(path)[0] == "not-a-picture"


def test_what_is_no_file_is_not_waited_for(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.png"
    os.mkfifo(pipe)
    assert "not a file" in refused(pipe)[1]
    with pytest.raises(SilhouetteError, match="not a file"):
        read("/dev/zero")
    with pytest.raises(OSError, match="not a file"):
        load(pipe)


def test_a_file_of_too_many_bytes_is_not_read(tmp_path: Path) -> None:
    """Sparse files: the sizes are checked before the content."""
    for name, size in (("big.png", untrusted.PICTURE_BYTES), ("big.svg", untrusted.SVG_BYTES)):
        path = tmp_path / name
        path.write_bytes(b"<svg" if name.endswith("svg") else b"\x89PNG")
        os.truncate(path, size + 1)
        reason, message = refused(path)
        assert reason == "too-large" and str(size) in message
    path = tmp_path / "big.riot"
    path.touch()
    os.truncate(path, untrusted.JSON_BYTES + 1)
    with pytest.raises(FormatError, match=rf"big\.riot.*{untrusted.JSON_BYTES}"):
        load(path)


def test_sizes_are_exact(tmp_path: Path) -> None:
    path = tmp_path / "ten"
    path.write_bytes(bytes(10))
    assert read_bytes(path, 10) == bytes(10)
    with pytest.raises(TooManyBytes, match="10 bytes are more than the limit of 9"):
        read_bytes(path, 9)
    with pytest.raises(IsADirectoryError):
        check_file(tmp_path, 10)


LAUGHS = (
    '<?xml version="1.0"?><!DOCTYPE svg [<!ENTITY a "ha">'
    + "".join(f'<!ENTITY {chr(98 + k)} "{f"&{chr(97 + k)};" * 10}">' for k in range(9))
    + "]>"
)
USES = '<g id="g0"><rect width="9" height="9"/></g>' + "".join(
    f'<g id="g{k + 1}">{f"""<use href="#g{k}"/>""" * 10}</g>' for k in range(9)
)


@pytest.mark.parametrize(
    ("body", "head", "expected", "words"),
    [
        ("<text>&j;</text>", LAUGHS + SVG, "unsupported", "DOCTYPE"),
        ("", '<?xml version="1.0"?><!DOCTYPE svg SYSTEM "file:///etc/passwd">' + SVG, "empty", "shows nothing"),
        ("", '<?xml version="1.0"?><?xml-stylesheet href="file:///etc/passwd"?>' + SVG, "unsupported", "another file"),
        ('<image href="file:///etc/passwd"/>', SVG, "unsupported", "embedded picture"),
        ('<use href="http://localhost/a.svg#a"/>', SVG, "unsupported", "another file"),
        (USES, SVG, "too-large", "limit reached"),
        ('<use id="a" href="#b"/><use id="b" href="#a"/>', SVG, "empty", "shows nothing"),
        ("<g>" * 50_000 + "</g>" * 50_000, SVG, "too-large", "deep"),
        ("<g/>" * 100_001, SVG, "too-large", "elements"),
        (f'<rect width="9" height="9" transform="{"rotate(" * 20_000}"/>', SVG, "too-large", "transform"),
        (f"<style>{'a{' * 20_000}</style>", SVG, "too-large", "style sheets"),
        ("<filter id='f'><feTurbulence baseFrequency='.5' numOctaves='99999'/></filter>"
         '<rect width="99" height="99" filter="url(#f)"/>', SVG, "too-large", "takes more than"),
        (f'<polygon points="{("1" * 60 + "x ") * 5_000}"/>', SVG, "empty", "shows nothing"),
        ('<path d="M0 0 L 1e400 5 L 5 5 Z"/>', SVG, "empty", "shows nothing"),
        ('<rect width="9" height="9" transform="scale(1e308) scale(1e308)"/>', SVG, "empty", "shows nothing"),
        ("", SVG.replace("100 100", "1e99 1"), "unreadable", "view box"),
        ("", SVG.replace("viewBox=", "width='1e-9' height='1' v="), "unreadable", "size"),
    ],
)  # fmt: skip
def test_drawings_that_explode(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: str, head: str, expected: str, words: str
) -> None:
    monkeypatch.setattr("riot.geometry.svg_render._SECONDS", 1)
    reason, message = refused(drawing(tmp_path, body, head))
    assert reason == expected and words in message and len(message) < 400


def test_edges_that_cross_everywhere_are_refused_before_they_are_joined(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    corners = np.column_stack([100.0 * (np.arange(600) % 2), 100.0 * rng.random(600)])
    path = drawing(tmp_path, f'<path d="M{" L".join(f"{x:.3f} {y:.3f}" for x, y in corners)}z"/>')
    assert outline(path).rendered
    with pytest.raises(SilhouetteError, match="edges meet more than") as caught:
        polygon_shape(corners)
    assert caught.value.reason == "self-crossing"
    grid = "".join(f'<path d="M0 {k / 9} h100 v.05 h-100z M{k / 9} 0 v100 h.05 v-100z"/>' for k in range(300))
    assert outline(drawing(tmp_path, grid)).rendered


def test_scripts_and_foreign_content_change_nothing(tmp_path: Path) -> None:
    plain = read(drawing(tmp_path, '<path d="M10 10h50v30h-50z"/>'))
    body = (
        '<script>while(true){}</script><metadata><x:y xmlns:x="urn:x"><rect width="99" height="99"/></x:y></metadata>'
        '<x:path xmlns:x="urn:x" d="M0 0h99v99z"/>'
        f'<path onload="alert(1)" xmlns:x="urn:x" x:nodes="{"c" * 9000}" d="M10 10h50v30h-50z"/>'
    )
    assert np.array_equal(read(drawing(tmp_path, body)).points, plain.points)


def test_a_polygon_has_a_greatest_length() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 50_001)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    with pytest.raises(SilhouetteError, match="50001 points, more than 50000; simplify") as caught:
        polygon_shape(circle)
    assert caught.value.reason == "too-large"
    assert len(polygon_shape(circle[::2]).points) > 100


def grown(change: Callable[[dict[str, object]], object]) -> str:
    document = json.loads(to_json(exact_transform(exact_pair(4, 1))))
    change(document)
    return json.dumps(document)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda document: document["pieces"].extend(document["pieces"] * MAX_PIECES), "pieces are more than the limit"),
        (lambda document: document["p"]["points"].extend([[0, 0]] * MAX_POINTS), "points are more than the limit"),
        (lambda document: document["pieces"][0]["lower"].insert(1, [1e400, 0]), "finite"),
        (lambda document: document.update(bound_p=1e400), "finite"),
        (lambda document: document["p"].update(to_source=[[1e400] * 3] * 2), "finite"),
        (lambda document: document["p"].update(feature="all"), "damaged"),
        (lambda document: document.update(history={"pictures": ["a", "b"], "steps": [], "versions": {}}), "digests"),
        (lambda document: document.update(history=[]), "damaged"),
        (lambda document: document.update(p=None), "damaged"),
        (lambda document: document["pieces"][0].update(length=10**400), "damaged"),
    ],
)
def test_transforms_that_ask_for_too_much_or_make_no_sense(
    change: Callable[[dict[str, object]], object], words: str
) -> None:
    with pytest.raises(FormatError, match=words):
        from_json(grown(change), "hostile.riot")
