"""The episodes of a suite as scenes, one for every combination that its tables name."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from magicsim.evaluation.suite import PathFrame, SuiteConfig, SuiteLight, SuiteObject, SuitePath, SuitePlace
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.judge.judged import Role
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import ContactSettings, Keyframe, OutputSettings, SceneConfig

NO_OUTPUT = OutputSettings.nothing()


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One episode to simulate."""

    name: str
    """Unique within the suite: `object/path/light/seed`, and the place where it is not the first one."""
    object: str
    role: Role
    path: str
    light: str
    place: str
    scene: SceneConfig


def list_cases(suite: SuiteConfig) -> list[Case]:
    """All simulated episodes of a suite, in the order of its blocks; a combination named twice counts once."""
    objects = {each.name: each for each in suite.objects}
    paths = {each.name: each for each in suite.paths}
    lights = {each.name: each for each in suite.lights}
    places = {each.name: each for each in suite.places}
    sensors = {name: suite.sensor(each) for name, each in places.items()}
    cases: dict[str, Case] = {}
    for block in suite.episodes:
        where = block.places or (suite.places[0].name,)
        for place, seed, path, light, body in product(where, block.seeds, block.paths, block.lights, block.objects):
            case = _case(suite, places[place], sensors[place], objects[body], paths[path], lights[light], seed)
            cases.setdefault(case.name, case)
    return list(cases.values())


def _case(
    suite: SuiteConfig, place: SuitePlace, sensor: tuple[ElastomerDesign, Rig], body: SuiteObject, path: SuitePath,
    light: SuiteLight, seed: int,
) -> Case:  # fmt: skip
    shift = _jitter(suite, body.name, seed)
    keyframes = [_keyframe(each, body, shift) for each in path.frames]
    design, rig = sensor
    elsewhere = "" if place.name == suite.places[0].name else f"/{place.name}"
    return Case(
        name=f"{body.name}/{path.name}/{light.name}/{seed}{elsewhere}",
        object=body.name,
        role="held_out" if "held_out" in (body.role, place.role) else "training",
        place=place.name,
        path=path.name,
        light=light.name,
        scene=SceneConfig(
            schema_version=1, design=design, rig=rig, seed=seed, references=suite.references,
            frames_per_second=suite.frames_per_second, object=parse_object(body.object),
            contact=ContactSettings(friction=path.friction), render=suite.render, output=NO_OUTPUT,
            keyframes=tuple(Keyframe(**each) for each in _lit(keyframes, light)),
        ),
    )  # fmt: skip


def _jitter(suite: SuiteConfig, name: str, seed: int) -> tuple[float, float, float]:
    """Shift along x and y [mm] and twist [degrees] of an object, the same for all its paths and lights."""
    random = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))
    x, y, twist = (random.uniform(-1, 1, 3) * [suite.jitter_mm, suite.jitter_mm, suite.jitter_deg]).round(6).tolist()
    return x, y, twist


def _keyframe(each: PathFrame, body: SuiteObject, shift: tuple[float, float, float]) -> dict[str, Any]:
    light = {"flashlight": each.flashlight, "light_x_mm": each.light_x_mm}
    if not each.has_object:
        return {"frame": each.frame, **light}
    gap = each.gap_mm if each.gap_mm is not None else -(each.press or 0.0) * body.press_mm
    x, y, twist = body.x_mm + shift[0] + each.x_mm, body.y_mm + shift[1] + each.y_mm, shift[2] + each.twist_deg
    return {"frame": each.frame, "gap_mm": gap, "x_mm": x, "y_mm": y, "twist_deg": twist, **light}


def _lit(keyframes: list[dict[str, Any]], light: SuiteLight) -> Iterator[dict[str, Any]]:
    """Keyframes with the light on, and moving, wherever the object is there."""
    held = [each["frame"] for each in keyframes if "gap_mm" in each]
    for each in keyframes:
        if not light.flashlight or "gap_mm" not in each:
            yield each
            continue
        share = (each["frame"] - held[0]) / max(1, held[-1] - held[0])
        place = light.from_x_mm + share * (light.to_x_mm - light.from_x_mm)
        yield each | {"flashlight": True, "light_x_mm": round(place, 9)}
