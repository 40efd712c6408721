"""From a raw scan to its meaningful regions: meshmser on NumPy arrays.

On arrays of a mesh and a scalar of one value a vertex:

    surface = meshmser.Surface(positions, triangles)            # n x 3 doubles, m x 3 int32: used in place
    tree = meshmser.build_component_tree(surface, values, levels=64)
    regions = meshmser.label_triangles([tree], [meshmser.select_mser(surface, tree)])
    borders = meshmser.extract_borders(surface, regions)

A whole configuration, from its file or as a dictionary:

    result = meshmser.run("scan.yaml", set={"mser.min_area": "2 mm2"})
    result.stage("mesh").artifact()["positions"]                # memory-mapped from the cache
"""

import json as _json
import os as _os
import re as _re

import numpy as _np

from ._core import (
    Borders,
    CacheError,
    Cancelled,
    ComponentTree,
    ConfigError,
    Error,
    InputError,
    Regions,
    StageError,
    Surface,
    UsageError,
    build_component_tree,
    build_tree_of_shapes,
    describe_regions,
    extract_borders,
    extract_label_borders,
    label_triangles,
    select_mser,
    stability,
)
from ._core import _run

__all__ = [
    "Borders",
    "CacheError",
    "Cancelled",
    "ComponentTree",
    "ConfigError",
    "Error",
    "InputError",
    "Regions",
    "Run",
    "Stage",
    "StageError",
    "Surface",
    "UsageError",
    "build_component_tree",
    "build_tree_of_shapes",
    "describe_regions",
    "extract_borders",
    "extract_label_borders",
    "label_triangles",
    "run",
    "select_mser",
    "stability",
]


def _load(folder, stored):
    """A field of an artifact as it is stored: arrays memory-mapped, the rest as it stands in artifact.json."""
    if isinstance(stored, dict):
        if set(stored) == {"array"}:
            path = _os.path.join(folder, stored["array"])
            try:
                return _np.load(path, mmap_mode="r")
            except ValueError:  # an empty array cannot be mapped
                return _np.load(path)
        if set(stored) == {"records", "columns"}:
            return _load(folder, stored["columns"])
        return {name: _load(folder, field) for name, field in stored.items()}
    if isinstance(stored, list):
        return [_load(folder, field) for field in stored]
    return stored


class Stage:
    """What became of one stage of a run."""

    def __init__(self, record):
        self.__dict__.update(record)

    def artifact(self, port=None):
        """What the stage made, from the cache: a dictionary of fields, arrays memory-mapped. `port`: where the stage
        makes several."""
        if port is None and len(self.outputs) != 1:
            raise ValueError(f"{self.name} makes {', '.join(self.outputs) or 'nothing'}: name one")
        folder = self.outputs[next(iter(self.outputs)) if port is None else port]
        with open(_os.path.join(folder, "artifact.json"), encoding="utf-8") as file:
            return _load(folder, _json.load(file)["content"])

    def __repr__(self):
        return f"<Stage {self.name}: {self.outcome}>"


class Run:
    """A finished run: its stages in order, the folders of its results and of its cache."""

    def __init__(self, stages, out, cache):
        self.stages = [Stage(record) for record in stages]
        self.out = out
        self.cache = cache

    def stage(self, name):
        for stage in self.stages:
            if stage.name == name:
                return stage
        raise KeyError(f"no stage {name}; there are {', '.join(stage.name for stage in self.stages)}")

    @property
    def files(self):
        return [file for stage in self.stages for file in stage.files]


def _yaml(value):
    """A value as YAML in one line. Words stand without quotes where they can: `'2 mm2'` in quotes is no area."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_yaml(str(key))}: {_yaml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    if isinstance(value, _np.generic):
        value = value.item()
    if isinstance(value, _os.PathLike):
        value = _os.fspath(value)
    if isinstance(value, str) and _re.fullmatch(r"-?[\w./+]([\w .%+/-]*[\w.%+/-])?", value, _re.ASCII):
        return value
    return _json.dumps(value)


def _configuration(given):
    """The text of a configuration, a line for each stage, so that messages have something to point at."""
    lines = []
    for key, value in given.items():
        if key == "stages" and isinstance(value, (list, tuple)):
            stages = [_yaml(stage)[1:-1] if isinstance(stage, dict) else _yaml(stage) for stage in value]
            lines += ["stages:"] + [f"  - {stage}" for stage in stages]
        else:
            lines.append(f"{_yaml(str(key))}: {_yaml(value)}")
    return "\n".join(lines) + "\n"


def run(config, *, set=None, out=None, cache=None, until=None, force=False, threads=0, quiet=True):
    """Runs a configuration: the path of a YAML file, or the same as a dictionary (paths in it relative to the current
    folder). `set`: {"stage.key": value}. What the cache holds is not made again. Ctrl-C ends it; stages that finished
    are cached."""
    text = None
    if isinstance(config, dict):
        text, config = _configuration(config), _os.path.join(_os.getcwd(), "meshmser.yaml")
    changes = [f"{key}={_yaml(value)}" for key, value in (set or {}).items()]
    folders = ["" if folder is None else _os.fspath(folder) for folder in (out, cache)]
    return Run(*_run(_os.fspath(config), text, changes, *folders, until or "", force, threads, quiet))
