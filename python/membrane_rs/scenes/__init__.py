"""The built-in scenes, one TOML file each."""

from __future__ import annotations

import itertools
from importlib import resources
from pathlib import Path

from membrane_rs._files import path_of
from membrane_rs._validation import nearest, show
from membrane_rs.errors import SceneError
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import has_free_hub

__all__ = ["describe", "for_any_method", "load", "names", "scene_of", "text"]


def names() -> list[str]:
    """The names of the built-in scenes, in alphabetical order.

    Returns
    -------
    list of str
        As `load` takes them.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> "okuizumi-model-1" in scenes.names()
    True
    """
    files = resources.files(__name__).iterdir()
    return sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))


def for_any_method() -> list[str]:
    """The names of those that each method of time integration can run: without stages, without a step of their own, and
    without a free hub.

    A step that a scene gives is one for its own method, and a free hub is moved by leapfrog and rk4 alone.

    Returns
    -------
    list of str
        In alphabetical order.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> "okuizumi-model-1" in scenes.for_any_method(), "okuizumi-model-1-fast" in scenes.for_any_method()
    (True, False)
    """
    loaded = {name: load(name) for name in names()}
    return [name for name, scene in loaded.items() if not (scene.stages or scene.run.dt or has_free_hub(scene))]


def describe(name: str) -> str:
    """One line about a built-in scene: the first sentence of its file.

    Parameters
    ----------
    name : str
        Of the scene.

    Returns
    -------
    str
        A sentence.

    Raises
    ------
    SceneError
        No scene of that name.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> print(scenes.describe("single-crease"))
    Two panels joined by one crease: one is held, the other is folded over it and springs open to flat.
    """
    comment = itertools.takewhile(lambda line: line.startswith("#"), text(name).splitlines())
    words = " ".join(line.removeprefix("#").strip() for line in comment)
    sentence, end, _ = words.partition(". ")
    return sentence + end.strip()


def load(name: str) -> Scene:
    """A built-in scene by its name.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    Scene
        As its file says.

    Raises
    ------
    SceneError
        No scene of that name.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> scenes.load("hanging-strip").counts()["triangles"]
    84
    """
    text(name)
    with resources.as_file(resources.files(__name__) / f"{name}.toml") as path:
        return Scene.from_toml(path)


def scene_of(scene: Scene | str | Path) -> Scene:
    """A scene as it is; else a built-in one by its name, or that of a file by its path (ending or slash).

    Parameters
    ----------
    scene : Scene, str or path
        A scene, a name or a path.

    Returns
    -------
    Scene
        The one that is meant.

    Raises
    ------
    SceneError
        No scene of that name, or anything in the file that is wrong.
    MissingFileError
        No such file.
    InputError, InputTypeError
        Neither a scene nor a name or a path.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> scenes.scene_of("spinning-disc").name
    'spinning-disc'
    """
    if isinstance(scene, Scene):
        return scene
    path = path_of(scene, "scene")
    if str(scene) not in names():
        _refuse_folder(path)
    if isinstance(scene, Path) or path.suffix == ".toml" or "/" in str(scene) or path.is_file():
        return Scene.from_toml(path)
    return load(str(scene))


def text(name: str) -> str:
    """The file of a built-in scene, with its comments.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    str
        In TOML.

    Raises
    ------
    SceneError
        No scene of that name.
    InputError, InputTypeError
        A text that is no name of anything.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> scenes.text("single-crease").splitlines()[0]
    '# Two panels joined by one crease: one is held, the other is folded over it and springs open to flat.'
    """
    known = names()
    if not isinstance(name, str) or name not in known:
        if isinstance(name, str) and name.strip():
            _refuse_folder(path_of(name, "scene"))
        meant = nearest(str(name), known)
        file = " A file" if meant.endswith("?") else "; a file"
        raise SceneError(f"scene {show(name)}: is not built in; {meant}{file} is named by its path, with .toml")
    return (resources.files(__name__) / f"{name}.toml").read_text(encoding="utf-8")


def _refuse_folder(path: Path) -> None:
    """Raise SceneError for a folder, which may be that of a run."""
    if path.is_dir():
        raise SceneError(f"scene {show(str(path))}: is a folder; name a scene file, such as {path}/scene.toml of a run")
