"""Claims of the paper beside what is simulated, and the experiments whose runs they rest on."""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import files
from math import isfinite
from typing import Any

from layflat.errors import InputError, MachineError
from layflat.experiments.bench import Bench


def texts_of(file: str) -> dict[str, Any]:
    """Return the tables of a file of texts that stands beside this one."""
    return tomllib.loads((files("layflat.experiments") / file).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Quantity:
    """One number of a claim: what is simulated, its unit, and in words what the paper gives for it, where it does."""

    name: str
    value: float
    unit: str = "1"
    paper: str = ""


@dataclass(frozen=True)
class Claim:
    """One claim of the paper, as it was evaluated."""

    id: str  # short name
    where: str  # section, table or figure of the paper
    says: str  # what the paper says, in our words
    criterion: str  # when simulation and paper agree
    quantities: tuple[Quantity, ...] = ()  # what is simulated; none where the claim was not evaluated
    agrees: bool | None = None  # whether the criterion holds; None where the claim was not evaluated
    reason: str = ""  # why it was not evaluated

    @property
    def verdict(self) -> str:
        """The outcome in a word or three."""
        return {None: "not evaluated", True: "agrees", False: "does not agree"}[self.agrees]

    def record(self) -> dict[str, Any]:
        """Return the claim as it stands in claims.json; a value that is not finite becomes null."""
        return {
            "id": self.id,
            "where": self.where,
            "paper": self.says,
            "simulated": self._each([_json(one.value) for one in self.quantities]),
            "unit": self._each([one.unit for one in self.quantities]),
            "paper_value": self._each([one.paper or None for one in self.quantities]),
            "agrees": self.agrees,
            "criterion": self.criterion,
            **({"reason": self.reason} if self.reason else {}),
        }

    def _each(self, values: list[Any]) -> Any:
        """Return one value as it is, several by the names of their quantities."""
        if len(values) <= 1:
            return values[0] if values else None
        return {one.name: value for one, value in zip(self.quantities, values, strict=True)}


def _json(value: float) -> float | None:
    return round(float(value), 6) if isfinite(value) else None


Evaluated = tuple[list[Quantity], bool]  # what a claim's rule computes: its quantities, and whether its criterion holds


@dataclass(frozen=True)
class Rule:
    """A claim that has not been evaluated yet, and how to evaluate it by an experiment."""

    claim: Claim
    evaluate: Callable[[Any], Evaluated]

    def evaluated(self, experiment: "Experiment") -> Claim:
        """Evaluate the claim; where the machine under test lacks what it takes, the claim says so.

        A claim that can't be simulated for any other reason does not agree.
        """
        try:
            quantities, agrees = self.evaluate(experiment)
        except MachineError as error:
            return self.open(f"not applicable: {error.where}: {error.what}")
        except InputError as error:
            return replace(self.open(f"can't be simulated: {error.where}: {error.what}"), agrees=False)
        return replace(self.claim, quantities=tuple(quantities), agrees=bool(agrees))

    def open(self, reason: str) -> Claim:
        """Return the claim as one that is not evaluated, for a reason."""
        return replace(self.claim, reason=reason)


CLAIMS = {key: Claim(key, **texts) for key, texts in texts_of("claims.toml").items()}
"""By their short names, in the order of the paper."""


def claim(identifier: str) -> Callable[[Callable[[Any], Evaluated]], Rule]:
    """Declare a method of an experiment to be the rule of a claim."""
    return lambda evaluate: Rule(CLAIMS[identifier], evaluate)


@dataclass(frozen=True)
class Experiment:
    """Base of the experiments: runs are made when they are first asked for, and claims are methods."""

    bench: Bench

    @classmethod
    def rules(cls) -> list[Rule]:
        """The claims that rest on this experiment."""
        return [member for member in vars(cls).values() if isinstance(member, Rule)]
