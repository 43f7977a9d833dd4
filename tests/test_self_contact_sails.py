"""Contact between the layers of folded sails: what stays apart, and which parts of the scheme that needs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from membrane_rs import Scene, SelfContact, Simulation, UnstableError, scenes
from membrane_rs.analysis.deployment import Corners

CROSS, ROLL = "okuizumi-model-1", "okuizumi-whole"


class Ablated(SelfContact):
    """Contact with other choices of the core's scheme."""

    def core_parameters(self) -> dict[str, Any]:
        return {**super().core_parameters(), "scheme": self.scheme()}

    @staticmethod
    def scheme() -> dict[str, Any]:
        return {}


class WithoutEdges(Ablated):
    @staticmethod
    def scheme() -> dict[str, Any]:
        return {"has_edges": False}


class WithoutPush(Ablated):
    @staticmethod
    def scheme() -> dict[str, Any]:
        return {"share_of_depth": 0.0}


def with_contact(name: str, contact: SelfContact) -> Scene:
    scene = scenes.load(name)
    return replace(scene, laws=[*scene.laws, contact], run=replace(scene.run, integrator="leapfrog"))


def test_the_released_cross_has_no_crossing_and_opens_alike() -> None:
    contact = Simulation(with_contact(CROSS, SelfContact()))
    scene = scenes.load(CROSS)
    own = Simulation(replace(scene, run=replace(scene.run, integrator="leapfrog")))
    rate = Corners(own.assembly).deployment_rate
    # Another program has these rates, with corners of its own.
    for instant, known, crossed in ((0.005, 0.7332, 5000), (0.015, 0.7480, 10_000)):
        contact.reach(instant)
        own.reach(instant)
        assert contact.crossings(limit=0).count == 0
        assert own.crossings(limit=0).count > crossed
        assert rate(contact.positions) == pytest.approx(rate(own.positions), abs=3e-4)
        assert rate(contact.positions) == pytest.approx(known, abs=4e-3)
    assert abs(contact.ledger()["error"]) < 2e-3


@pytest.mark.parametrize(
    ("name", "contact", "until"),
    [(CROSS, WithoutEdges, 0.03), (ROLL, WithoutEdges, 0.005), (ROLL, WithoutPush, 0.015)],
)
def test_without_pairs_of_edges_or_push_layers_cross(name: str, contact: type[Ablated], until: float) -> None:
    simulation = Simulation(with_contact(name, contact(crossing_interval=50)))
    with pytest.raises(UnstableError, match=r"of the film cross|pass through each other"):
        simulation.reach(until)


def test_the_roll_has_no_crossing() -> None:
    simulation = Simulation(with_contact(ROLL, SelfContact()))
    simulation.reach(0.002)
    assert simulation.crossings(limit=0).count == 0
    assert simulation.ledger()["work_by_law"]["self_contact"] < 0.0
