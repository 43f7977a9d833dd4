"""What the JSON schema of scene files says beyond the type and the bounds of a key: names, and keys beside each other.

Each rule has its check in the class that it is of, or in `Scene`; the schema refuses nothing that these take.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

from membrane_rs.folding import PATTERNS
from membrane_rs.scene import bodies, members, stage
from membrane_rs.scene.bodies import BODIES
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS
from membrane_rs.scene.run_settings import LONGEST, SHORTEST, RunSettings, known_methods
from membrane_rs.scene.schedule import MOST_KNOTS, Schedule
from membrane_rs.scene.stage import MEASURES, Stage
from membrane_rs.scene.staging import OF_A_STAGE

Rule = Mapping[str, Any]

NAME = {
    "type": "string", "minLength": 1, "maxLength": members.LONGEST_NAME, "pattern": r"^[^/\\\u0000]*$",
    "not": {"enum": [".", ".."]},
}  # fmt: skip
"""A name that a folder may have."""
_OF_BODY = {
    "maxLength": bodies.LONGEST_NAME,
    "pattern": "^[A-Za-z][A-Za-z0-9_]*$",
    "not": {"enum": [*LAWS, *members.OF_PARTS, *members.OF_ENERGY]},
}
_FELT_BY_NONE = {"membrane": {"const": False}, "cords": {"const": False}}
_OF_TIME = {"minimum": SHORTEST, "maximum": LONGEST}
_OF_KNOTS = {"minItems": 1, "maxItems": MOST_KNOTS}
_NONE = {"anyOf": [{"const": 0}, {"type": "string"}]}
"""A number that is 0, or a text, which may be of 0."""
_KEY = r"^(material\.|(laws|parts|bodies)\.[^.]+\."


def _alone(*others: str) -> Rule:
    """That none of other keys stands beside a key."""
    return {"properties": dict.fromkeys(others, False)}


OF_KEYS: Mapping[type, Mapping[str, Rule]] = {
    Schedule: {"times": _OF_KNOTS, "values": _OF_KNOTS},
    Stage: {
        "name": {"minLength": 1, "maxLength": stage.LONGEST_NAME, "pattern": r"^(?=.*\S)[^\u0000-\u001f\u007f]*$"},
        "duration": _OF_TIME,
        "measure": {"enum": list(MEASURES)},
        "without": {"uniqueItems": True},
        "scale": {"propertyNames": {"pattern": _KEY + ")"}},
        "set": {"propertyNames": {"pattern": _KEY + rf"|run\.({'|'.join(OF_A_STAGE)})$)"}},
    },
    RunSettings: {"until": _OF_TIME, "integrator": {"enum": known_methods()}},
    **{part: {"name": {**NAME, "not": {"enum": [".", "..", *LAWS]}}} for part in PARTS.values()},
    **{body: {"name": _OF_BODY, "direction": {"not": {"const": [0, 0, 0]}}} for body in BODIES.values()},
}
"""What is added to a key of a class; where numbers may be texts, to the numbers."""

OF_CLASSES: Mapping[type, Rule] = {
    Stage: {
        "dependencies": {
            "below": ["measure"], "above": ["measure"],
            "measure": {"oneOf": [{"required": ["below"]}, {"required": ["above"]}]},
        }
    },
    LAWS["spin"]: {
        "dependencies": {
            "schedule": {"properties": {"frequency": False, "acceleration": _NONE}},
            "inertia": {"properties": {"schedule": False, "acceleration": _NONE}},
            "torque": ["inertia"],
            "mass": ["inertia", "transverse_inertia"],
            "transverse_inertia": ["inertia", "mass"],
            "tumble": ["mass"],
        }
    },
    PATTERNS["square-sail"]: {
        "dependencies": {"columns": {"properties": {"layout": {"not": {"const": "equilateral"}}}}},
        "if": {"properties": {"stowage": {"const": "wound"}}, "required": ["stowage"]},
        "then": {"properties": {"layout": {"const": "ruled"}, "fillet_radius": False}},
    },
    PARTS["tether"]: {
        "required": ["kind", "start", "segments", "axial_stiffness", "linear_density"],
        "oneOf": [{"required": ["end"], **_alone("wound")}, {"required": ["wound", "length"], **_alone("end")}],
    },
    **{body: {"not": {"properties": _FELT_BY_NONE, "required": [*_FELT_BY_NONE]}} for body in BODIES.values()},
}  # fmt: skip
"""What is added to the table of a class."""


def of_scene() -> Rule:
    """What is said of the tables of a scene together."""
    films = [kind for kind, law in LAWS.items() if law.is_film]
    two_films = [{"required": list(pair)} for pair in combinations(films, 2)]
    nodes_of_a_part = {"contains": {"properties": {"kind": {"const": "tether"}}, "required": ["kind"]}}
    return {
        "dependencies": {"mesh": ["material"]},
        "anyOf": [{"required": ["mesh"]}, {"required": ["parts"], "properties": {"parts": nodes_of_a_part}}],
        "if": {"required": ["stages"], "properties": {"stages": {"minItems": 1}}},
        "then": {"properties": {"run": _alone("until")}},
        "else": {"properties": {"laws": {"not": {"anyOf": two_films}}}},
    }


def of_old_names(renamed: Mapping[str, str]) -> Rule:
    """That a key does not stand beside its old name."""
    return {"dependencies": {old: _alone(new) for old, new in renamed.items()}} if renamed else {}
