"""Claims of the paper, their simulated quantities, and the experiments whose runs they are evaluated from."""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import files
from math import isfinite
from typing import Any

from layflat.errors import InputError, MachineError
from layflat.experiments.bench import ReproductionBench


def read_texts(file: str) -> dict[str, Any]:
    """Return the tables of a TOML file of texts in this package."""
    return tomllib.loads((files("layflat.experiments") / file).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class ClaimQuantity:
    """One number of a claim: its simulated value, its unit, and the paper's value in words, where there is one."""

    name: str
    value: float
    unit: str = "1"
    paper: str = ""


@dataclass(frozen=True)
class Claim:
    """One claim of the paper, with the result of its evaluation."""

    id: str  # short name
    where: str  # section, table or figure of the paper
    says: str  # statement of the paper, in our words
    criterion: str  # when simulation and paper agree
    quantities: tuple[ClaimQuantity, ...] = ()  # simulated; none where the claim was not evaluated
    agrees: bool | None = None  # whether the criterion holds; None where the claim was not evaluated
    reason: str = ""  # why it was not evaluated

    @property
    def verdict(self) -> str:
        """Verdict in words: "agrees", "does not agree" or "not evaluated"."""
        return {None: "not evaluated", True: "agrees", False: "does not agree"}[self.agrees]

    def record(self) -> dict[str, Any]:
        """Return the claim's entry in claims.json: values rounded to 6 decimals, null if not finite."""
        return {
            "id": self.id,
            "where": self.where,
            "paper": self.says,
            "simulated": self._each([_json_number(one.value) for one in self.quantities]),
            "unit": self._each([one.unit for one in self.quantities]),
            "paper_value": self._each([one.paper or None for one in self.quantities]),
            "agrees": self.agrees,
            "criterion": self.criterion,
            **({"reason": self.reason} if self.reason else {}),
        }

    def _each(self, values: list[Any]) -> Any:
        """Return a single value as it is, several by the names of their quantities."""
        if len(values) <= 1:
            return values[0] if values else None
        return {one.name: value for one, value in zip(self.quantities, values, strict=True)}


def _json_number(value: float) -> float | None:
    return round(float(value), 6) if isfinite(value) else None


Evaluation = tuple[
    list[ClaimQuantity], bool
]  # result of a claim's rule: its quantities, and whether its criterion holds


@dataclass(frozen=True)
class ClaimRule:
    """Claim that has not been evaluated yet, with the function of an experiment that evaluates it."""

    claim: Claim
    evaluate: Callable[[Any], Evaluation]

    def evaluate_claim(self, experiment: "Experiment") -> Claim:
        """Evaluate the claim; where the machine under test lacks a required part, the claim's reason says so.

        A claim that can't be simulated for any other reason does not agree.
        """
        try:
            quantities, agrees = self.evaluate(experiment)
        except MachineError as error:
            return self.unevaluated(f"not applicable: {error.where}: {error.what}")
        except InputError as error:
            return replace(self.unevaluated(f"can't be simulated: {error.where}: {error.what}"), agrees=False)
        return replace(self.claim, quantities=tuple(quantities), agrees=bool(agrees))

    def unevaluated(self, reason: str) -> Claim:
        """Return the claim without a verdict, with the reason for that."""
        return replace(self.claim, reason=reason)


PAPER_CLAIMS = {key: Claim(key, **texts) for key, texts in read_texts("claims.toml").items()}
"""By their short names, in the order of the paper."""


def claim(identifier: str) -> Callable[[Callable[[Any], Evaluation]], ClaimRule]:
    """Declare a method of an experiment as the evaluation of a claim, by the claim's short name."""
    return lambda evaluate: ClaimRule(PAPER_CLAIMS[identifier], evaluate)


@dataclass(frozen=True)
class Experiment:
    """Base of the experiments: runs are simulated when they are first read, and claims are methods."""

    bench: ReproductionBench

    @classmethod
    def rules(cls) -> list[ClaimRule]:
        """Return the rules of the claims that this experiment evaluates."""
        return [member for member in vars(cls).values() if isinstance(member, ClaimRule)]
