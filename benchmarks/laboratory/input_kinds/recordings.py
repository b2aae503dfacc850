"""A user's recordings: frames, tables, clocks, references and units of `dataset import`, `detect`, `evaluate --on`.

The sensor is drawn: dark dots on colours that run across the picture, and a ball that presses a bright disk.
"""

import logging
import re
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from laboratory.input_kinds.registry import Attempt, variation
from magicsim.dataset.frames import FrameTable, open_frames
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.inspection import inspect_real
from magicsim.dataset.real.writing import write_real
from magicsim.detectors.source import read_source
from magicsim.errors import MagicsimError
from magicsim.judge.recorded import read_episode

Image = npt.NDArray[np.uint8]
FORCES_N = [0.0] * 8 + [0.3, 0.6, 0.9, 1.0, 0.6, 0.0]
"""Of the press, frame by frame, at 10 frames a second."""
LOSS, END, TURNED = "loses detail", "the rest is damaged or missing", "are turned"


def draw(force_n: float = 0.0, number: int = 0) -> Image:
    """RGB, shape (60, 80, 3): red from the left, green from above, dots, a disk that grows with the force, noise."""
    rows, columns = np.mgrid[0:60, 0:80]
    image = np.stack([180 - 1.6 * columns, 150 - 1.5 * rows, 40 + 1.0 * columns], 2)
    image[((rows % 12 - 6) ** 2 + (columns % 12 - 6) ** 2) < 8] *= 0.2
    if force_n > 0.05:
        image[(rows - 30) ** 2 + (columns - 40) ** 2 < 100 * force_n] = (235, 140, 60)
    noise = np.random.default_rng(number).normal(0, 0.4, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


PRESS = [draw(force, number) for number, force in enumerate(FORCES_N)]
REST = [draw(0.0, 90 + number) for number in range(6)]


def save(folder: Path, images: Sequence[Image], name: str = "{:04d}.png") -> None:
    """Writes images into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, image in enumerate(images):
        cv2.imwrite(str(folder / name.format(number)), image[..., ::-1])


def film(
    path: Path, images: Sequence[Image] = PRESS, *, times_s: Sequence[float] | None = None, codec: str = "ffv1"
) -> None:
    """A video with time stamps, of 10 frames a second by default, from PyAV."""
    import av

    pixels, options = {"ffv1": ("bgr0", {}), "libx264rgb": ("rgb24", {"qp": "0"}), "mjpeg": ("yuvj420p", {})}[codec]
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, rate=10, options=options)
        stream.width, stream.height, stream.pix_fmt = images[0].shape[1], images[0].shape[0], pixels
        stream.codec_context.time_base = Fraction(1, 1000)
        for number, image in enumerate(images):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="rgb24").reformat(format=pixels)
            frame.pts, frame.time_base = round(1000 * (times_s[number] if times_s else number / 10)), Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def cut(path: Path, share: float = 0.6) -> None:
    """Takes the end of a file away."""
    content = path.read_bytes()
    path.write_bytes(content[: round(share * len(content))])


def turn_track(path: Path) -> None:
    """Writes half a turn into the track header of an MP4 (ISO 14496-12, 8.3.2)."""
    content = bytearray(path.read_bytes())
    at = content.find(b"tkhd") + 44
    struct.pack_into(">5i", content, at, -0x10000, 0, 0, 0, -0x10000)
    path.write_bytes(content)


def with_orientation(content: bytes, value: int) -> bytes:
    """A PNG or a JPEG with an Exif orientation."""
    tiff = struct.pack("<2sHIHHHIHHI", b"II", 42, 8, 1, 0x0112, 3, 1, value, 0, 0)
    if content.startswith(b"\xff\xd8"):
        body = b"Exif\x00\x00" + tiff
        return content[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + content[2:]
    body = b"eXIf" + tiff
    return content[:33] + struct.pack(">I", len(tiff)) + body + struct.pack(">I", zlib.crc32(body)) + content[33:]


class Heard(logging.Handler):
    """Keeps what is logged."""

    def __init__(self) -> None:
        """Begins with nothing."""
        super().__init__()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keeps a line."""
        self.lines.append(record.getMessage())


@contextmanager
def listening() -> Iterator[list[str]]:
    """What the package logs meanwhile."""
    handler, log = Heard(), logging.getLogger("magicsim")
    log.addHandler(handler)
    propagates, log.propagate = log.propagate, False
    try:
        yield handler.lines
    finally:
        log.removeHandler(handler)
        log.propagate = propagates


def says(lines: Sequence[str], *words: str) -> str | None:
    """What is wrong where no line holds all of some patterns."""
    holds = any(all(re.search(word, line) for word in words) for line in lines)
    return None if holds else f"no line with {words} in {list(lines)}"


def refuses(attempt: Callable[[], object], *words: str) -> str | None:
    """What is wrong where an attempt is not refused in one line with some patterns."""
    try:
        attempt()
    except MagicsimError as error:
        return says([str(error)], *words)
    return "not refused"


def read(source: Path) -> tuple[list[Image], list[str]]:
    """Frames of a source, and what is said of it."""
    with listening() as lines:
        return [each.image for each in read_source(source)], lines


def same(found: Sequence[Image], wanted: Sequence[Image], most: float = 0.0) -> str | None:
    """What is wrong where frames are not those that are wanted, up to a mean difference [grey levels]."""
    if len(found) != len(wanted):
        return f"{len(found)} of {len(wanted)} frames"
    apart = [float(np.abs(one.astype(int) - other).mean()) for one, other in zip(found, wanted, strict=True)]
    return f"frames differ by {max(apart):.2f}" if max(apart) > most else None


def describe(folder: Path, columns: str, *lines: str, rows: Sequence[Mapping[str, Any]] = (), text: str = "") -> Path:
    """A description of one recording, and its table."""
    head = ",".join(rows[0]) if rows else ""
    body = [",".join(map(str, row.values())) for row in rows]
    if rows or text:
        (folder / "labels.csv").write_text(text or "\n".join([head, *body, ""]), encoding="utf-8")
        lines = (*lines, 'labels = "labels.csv"')
    path = folder / "mine.toml"
    path.write_text("\n".join(["schema_version = 1", f"columns = {{{columns}}}", "[[recordings]]", *lines, ""]))
    return path


def images(
    folder: Path, rows: Sequence[Mapping[str, Any]] = (), *lines: str, text: str = "", columns: str = ""
) -> Path:
    """The press as images with a table, and a folder of the untouched sensor."""
    save(folder / "images", PRESS)
    save(folder / "rest", REST)
    columns = columns or 'force_n = "f"'
    return describe(folder, columns, 'frames = "images"', *(lines or ('untouched = "rest"',)), rows=rows, text=text)


def forces(changed: Mapping[int, object] | None = None) -> list[dict[str, object]]:
    """Rows of the press, some with another force."""
    values: list[object] = list(FORCES_N)
    for number, value in (changed or {}).items():
        values[number] = value
    return [{"image_name": f"{number:04d}.png", "f": value} for number, value in enumerate(values)]


def told(path: Path) -> list[str]:
    """What import says of a description."""
    return inspect_real(load_real(path)).told


def written(path: Path, *columns: str) -> FrameTable:
    """The dataset of a description."""
    out = path.parent / "set"
    write_real(load_real(path), out)
    return open_frames(out, (*columns, "is_reference"), keep=path.parent / "kept")


def clocked(folder: Path, clock: Callable[[float], float], *, times_s: Sequence[float] | None = None) -> Path:
    """The press as a video, and a table of four rows a frame on a clock of its own."""
    film(folder / "press.mkv", times_s=times_s)
    save(folder / "rest", REST)
    at = np.arange(0, 1.3001, 0.025)
    values = np.interp(at, np.arange(14) / 10, FORCES_N)
    rows = [{"t": f"{clock(time_s):.4f}", "f": f"{value:.4f}"} for time_s, value in zip(at, values, strict=True)]
    return describe(folder, 'time_s = "t", force_n = "f"', 'frames = "press.mkv"', 'untouched = "rest"', rows=rows)


def presses(path: Path) -> list[float]:
    """Forces of the frames of a dataset that are no references [N]."""
    frames = written(path, "force_n")
    return [round(float(each), 3) for each in frames.column("force_n")[~frames.column("is_reference")][:, 2]]


def truth(folder: Path, *rows: str) -> Path:
    """A folder with a truth.csv."""
    save(folder, [draw(0.0, number) for number in range(len(rows))], "{}.png")
    heading = "file,is_reference,gap_mm,force_n,flashlight"
    (folder / "truth.csv").write_text(
        "\n".join([heading, *(f"{number}.png,{row}" for number, row in enumerate(rows)), ""])
    )
    return folder


def kind(name: str, **attempts: tuple[str, Attempt]) -> None:
    """Registers variations of a kind: by name, what is expected and the attempt."""
    for each, (expected, attempt) in attempts.items():
        variation(f"recordings: {name}", each.replace("_", " "), expected=expected)(attempt)


def _turned_video(folder: Path) -> str | None:
    film(folder / "a.mp4", codec="libx264rgb")
    turn_track(folder / "a.mp4")
    found, lines = read(folder / "a.mp4")
    return same(found, [np.rot90(each, 2) for each in PRESS]) or says(lines, TURNED, "180")


def _turned_import(folder: Path) -> str | None:
    film(folder / "a.mp4", codec="libx264rgb")
    turn_track(folder / "a.mp4")
    save(folder / "rest", REST)
    path = describe(folder, "", 'frames = "a.mp4"', 'untouched = "rest"')
    return says(told(path), TURNED, "180") or says(told(path), "only when they are turned by 180 degrees")


def _turned_picture(folder: Path) -> str | None:
    save(folder, PRESS[:3])
    for each in folder.iterdir():
        each.write_bytes(with_orientation(each.read_bytes(), 6))
    found, lines = read(folder)
    return same(found, [np.rot90(each, 3) for each in PRESS[:3]]) or says(lines, TURNED, "Exif orientation 6")


kind(
    "turned as the file says",
    track_of_an_MP4_in_detect=("frames upright, and a line that says it", _turned_video),
    track_of_an_MP4_in_import=("a line of the turn, and of references that are not turned", _turned_import),
    Exif_of_a_PNG=("frames upright, and a line that says it", _turned_picture),
)


def _stack(folder: Path) -> Path:
    cv2.imwritemulti(str(folder / "a.tif"), [each[..., ::-1] for each in PRESS])
    return folder / "a.tif"


def _stack_of_references(folder: Path) -> str | None:
    save(folder / "images", PRESS)
    cv2.imwritemulti(str(folder / "rest.tif"), [each[..., ::-1] for each in REST])
    path = describe(folder, "", 'frames = "images"', 'untouched = "rest.tif"')
    return None if inspect_real(load_real(path)).recordings[0].references == len(REST) else "references are left out"


def _stack_of_a_table(folder: Path) -> str | None:
    path = images(folder, [{"image_name": "a.tif", "f": 0}, *forces()[1:]])
    _stack(folder).rename(folder / "images" / "a.tif")
    return refuses(lambda: written(path, "image"), "a.tif' holds 14 pictures; must hold one here")


kind(
    "several pictures in a file",
    TIFF_in_detect=("all frames", lambda folder: same(read(_stack(folder))[0], PRESS)),
    TIFF_of_references=("all references", _stack_of_references),
    TIFF_in_a_table_of_images=("refused: holds 14 pictures", _stack_of_a_table),
)


def _short(name: str, codec: str = "ffv1") -> Attempt:
    def attempt(folder: Path) -> str | None:
        film(folder / name, codec=codec)
        cut(folder / name)
        found, lines = read(folder / name)
        return same(found, PRESS[: len(found)]) or says(lines, END)

    return attempt


def _short_import(folder: Path) -> str | None:
    path = clocked(folder, lambda time_s: time_s)
    cut(folder / "press.mkv")
    return says(told(path), END)


kind(
    "a video that ends early",
    AVI_in_detect=("whole frames, and a line", _short("a.avi")),
    Matroska_in_detect=("whole frames, and a line", _short("a.mkv")),
    Matroska_in_import=("a line", _short_import),
)

GAPPED = [0.0, 0.1, 0.2, *(0.5 + each / 10 for each in range(11))]
"""Times of the press with two frames dropped [s]."""


def _dropped(name: str, codec: str, start_s: float = 0.0) -> Attempt:
    def attempt(folder: Path) -> str | None:
        film(folder / name, times_s=[start_s + each for each in GAPPED], codec=codec)
        found, lines = read(folder / name)
        damage = [each for each in lines if "damaged" in each]
        return same(found, PRESS) or (f"said: {damage}" if damage else None)

    return attempt


kind(
    "dropped frames with right stamps",
    Matroska=("all frames, nothing said of damage", _dropped("a.mkv", "ffv1")),
    MP4=("all frames, nothing said of damage", _dropped("a.mp4", "libx264rgb")),
    Matroska_from_2_s=("all frames, nothing said of damage", _dropped("a.mkv", "ffv1", 2.0)),
)


def _lossy(name: str, code: str) -> Attempt:
    def attempt(folder: Path) -> str | None:
        writer = cv2.VideoWriter(str(folder / name), cv2.VideoWriter.fourcc(*code), 10, (80, 60))
        for each in PRESS:
            writer.write(np.ascontiguousarray(each[..., ::-1]))
        writer.release()
        with listening() as lines:
            read_source(folder / name).close()
        return says(lines, LOSS, "judged Touched")

    return attempt


def _lossy_pictures(folder: Path) -> str | None:
    save(folder, PRESS, "{:04d}.jpg")
    return says(read(folder)[1], LOSS, "judged Touched")


kind(
    "a codec that loses detail",
    MJPG=("named before the first frame", _lossy("a.avi", "MJPG")),
    mp4v=("named before the first frame", _lossy("a.mp4", "mp4v")),
    JPEG=("named", _lossy_pictures),
)


def _unpadded(folder: Path) -> str | None:
    save(folder, PRESS, "frame_{}.png")
    found, lines = read(folder)
    return same(found, PRESS) or says(lines, "order of the numbers in their names")


def _newest_first(folder: Path) -> str | None:
    rows = [{**row, "t": number / 10} for number, row in enumerate(forces())][::-1]
    path = images(folder, rows, columns='force_n = "f", time_s = "t"')
    found = presses(path)
    return (None if found == FORCES_N else f"forces {found}") or says(told(path), "in the order of their times")


def _set_back(folder: Path) -> str | None:
    rows = [{**row, "t": number / 10 - (number > 7)} for number, row in enumerate(forces())]
    path = images(folder, rows, columns='force_n = "f", time_s = "t"')
    return refuses(lambda: told(path), "line 10: time_s falls")


kind(
    "order of frames",
    frame_10_before_frame_2=("by number, and a line", _unpadded),
    newest_row_first=("by time, and a line", _newest_first),
    clock_set_back=("refused: line 10", _set_back),
)


def _late(folder: Path) -> str | None:
    path = clocked(folder, lambda time_s: time_s + 2, times_s=[2 + each / 10 for each in range(14)])
    return (None if presses(path) == FORCES_N else "other forces") or says(told(path), "at 2 s in its first frame")


def _milliseconds(folder: Path) -> str | None:
    return says(told(clocked(folder, lambda time_s: 1000 * time_s)), r"of 14 frames have no labels", r"= 0.001")


def _unix(folder: Path) -> str | None:
    path = clocked(folder, lambda time_s: time_s + 1764181390)
    return refuses(lambda: told(path), "no frame has labels", "from 0 to 1.3 s", "offset_s = 1764181390")


kind(
    "two clocks",
    container_from_2_s=("right forces, and a line", _late),
    milliseconds=("frames without labels are counted, with both spans", _milliseconds),
    Unix_time=("refused with both spans", _unix),
)


def _table(text: str, *words: str) -> Attempt:
    return lambda folder: refuses(lambda: told(images(folder, text=text)), *words)


kind(
    "tables that are not clear",
    decimal_commas=(
        "refused: 3 cells",
        _table("image_name,f\n0000.png,0,5\n", "line 2: 3 cells; must be 2"),
    ),
    twin_headings=("refused: two columns", _table("image_name,f,f\n0000.png,0,9\n", "2 columns are called 'f'")),
    semicolons=("refused: ';'", _table("image_name;f\n0000.png;0\n", "separated by ';'")),
    repeated_image=(
        "refused: both lines",
        _table("image_name,f\n0000.png,0\n0000.png,1\n", "line 3: .* stands in line 2 too"),
    ),
    cut_row=("refused: 1 cell", _table("image_name,f\n0000.png,0\n0001.p\n", "line 3: 1 cells; must be 2")),
    underscore=("refused: no number", _table("image_name,f\n0000.png,1_0\n", "f = '1_0' is not allowed")),
)


def _unknown_force(folder: Path) -> str | None:
    frames = written(images(folder, forces({10: ""})), "frame_class", "force_n")
    scored = ~frames.column("is_reference")
    classes, force = frames.column("frame_class")[scored].tolist(), frames.column("force_n")[scored][10]
    return None if classes[9:12] == ["Contact", "", "Contact"] and np.isnan(force).all() else f"{classes}, {force}"


def _unknown_contact(folder: Path) -> str | None:
    path = images(folder, forces({10: "nan"}))
    return refuses(lambda: written(path, "contact"), "contact") or says(told(path), "of 1 frames no label tells")


def _unknown_truth(folder: Path) -> str | None:
    found = read_episode(truth(folder, "1,,0,0", "0,,,0", "0,-0.5,,0", "0,1.5,,0", "0,,0,0"))
    classes = [str(each or "") for each in found.classes]
    return None if classes == ["", "", "Near", "Clear"] else str(classes)


kind(
    "an empty force",
    class_in_import=("unknown, not scored", _unknown_force),
    contact_in_import=("no column contact, and a line", _unknown_contact),
    truth_csv=("unknown, not scored", _unknown_truth),
)


def _black(folder: Path) -> str | None:
    path = images(folder, forces())
    save(folder / "rest", [0 * REST[0]] * 2)
    lines = told(path)
    return says(lines, "reference frames 0, 1 are black") or ("gain" if "gain" in str(lines) else None)


def _contact_reference(folder: Path) -> str | None:
    path = images(folder, forces({3: 0.8}), "untouched_first = 6")
    return refuses(lambda: told(path), "reference '0003.png' is a contact of 0.8 N")


def _known_reference(folder: Path) -> str | None:
    frames = written(images(folder, forces({3: -0.02}), "untouched_first = 6"), "force_n")
    found = float(frames.column("force_n")[3, 2])
    return None if found == -0.02 else f"{found} N"


kind(
    "references that are none",
    black_first_frames=("named, and no gain advised", _black),
    contact_by_its_label=("refused by name", _contact_reference),
    known_force=("kept", _known_reference),
    contact_in_truth_csv=(
        "refused by line",
        lambda folder: refuses(lambda: read_episode(truth(folder, "1,-1,3,0", "0,,0,0")), "line 2: a reference has"),
    ),
)


def _against(change: Callable[[Image], Image], way: str) -> Attempt:
    def attempt(folder: Path) -> str | None:
        path = images(folder, forces())
        save(folder / "rest", [np.ascontiguousarray(change(each)) for each in REST])
        return says(told(path), "look like their references only when they are", way)

    return attempt


def _alike(folder: Path) -> str | None:
    columns = np.mgrid[0:60, 0:80][1]
    image = np.stack([200 - 2 * columns, 20 + 0 * columns, 40 + 2 * columns], 2).astype(np.uint8)
    save(folder / "images", [np.ascontiguousarray(image[:, ::-1])] * 6)
    save(truth(folder / "like", "1,,0,0", "1,,0,0", "0,,0,0"), [image] * 3, "{}.png")
    path = describe(folder, "", 'frames = "images"', "untouched_first = 3")
    path.write_text(f'like = "like"\n{path.read_text()}')
    return says(told(path), "several settings fit alike", "rotate_deg = 180", "mirror = true", "color_order")


kind(
    "orientation",
    references_half_turned=("told", _against(lambda image: image[::-1, ::-1], "turned by 180 degrees")),
    references_with_red_and_blue_exchanged=("told", _against(lambda image: image[..., ::-1], "red and blue exchanged")),
    a_sensor_that_is_alike_from_two_sides=("all that fit, none advised", _alike),
)


def _metres(folder: Path) -> str | None:
    with listening() as lines:
        read_episode(truth(folder, "1,,0,0", "0,-0.001,2,0", "0,-0.0015,3,0"))
    return says(lines, "gap_mm reaches a depth of 0.0015 mm", "metres")


kind(
    "units",
    forces_in_mN=(
        "told",
        lambda folder: says(told(images(folder, forces({11: 1000}))), "force_n reaches 1000 N", "mN"),
    ),
    gaps_in_metres_in_truth_csv=("told", _metres),
    not_tared=(
        "told",
        lambda folder: says(
            told(images(folder, forces({number: 0.3 + force for number, force in enumerate(FORCES_N)}))),
            "force_n is 0.3 N from the first frame on",
        ),
    ),
)


def _apple(part: str) -> Attempt:
    def attempt(folder: Path) -> str | None:
        path = images(folder)
        (folder / part / "._0000.png").write_bytes(b"\x00\x05\x16\x07")
        found = inspect_real(load_real(path))
        return says(found.told, r"1 file\(s\) of macOS", r"\._0000.png")

    return attempt


def _apple_detect(folder: Path) -> str | None:
    save(folder, PRESS)
    (folder / "._0000.png").write_bytes(b"\x00\x05\x16\x07")
    found, lines = read(folder)
    return same(found, PRESS) or says(lines, r"1 file\(s\) of macOS")


kind(
    "files of macOS",
    in_detect=("passed over with a word", _apple_detect),
    among_frames=("passed over with a word", _apple("images")),
    among_references=("passed over with a word", _apple("rest")),
)
