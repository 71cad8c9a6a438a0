"""From the fitted configurations to the whole device: consistent links, values of the full model, and how sure they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from identification.sequence import links_of
from identification.step import Step
from model.device import Device
from model.inertial import standard_ids, to_standard
from model.inertial_belief import LinkBelief
from model.link_estimate import LinkEstimates, consistent_links, pseudo_inertia

DRAWS = 20
TRIES = 50


@dataclass(frozen=True, slots=True, kw_only=True)
class Whole:
    """Values of the full model by id, draws of them from their uncertainty, and the links."""

    values: Mapping[str, float]
    draws: tuple[Mapping[str, float], ...]
    links: LinkEstimates


def whole_device(device: Device, steps: Sequence[Step], *, seed: int = 0, draws: int = DRAWS) -> Whole:
    """Combine all steps: links by semidefinite least squares, joint parameters from the last test that had them."""
    measurements = links_of(tuple(steps), device)
    links = consistent_links(device, measurements)
    belief = LinkBelief.from_device(device)
    for one in measurements:
        belief = belief.update(one.coefficients, one.values, one.covariance)
    rng = np.random.default_rng([seed, 23])
    drawn = []
    for _ in range(draws):
        pi = _physical_draw(device, links, belief, rng)
        standard = to_standard(device, pi)
        inertial = dict(zip(standard_ids(device), standard.tolist(), strict=True))
        drawn.append(inertial | _joint_parameters(steps, rng))
    return Whole(values=dict(links.standard) | _joint_parameters(steps, None), draws=tuple(drawn), links=links)


def _physical_draw(
    device: Device, links: LinkEstimates, belief: LinkBelief, rng: np.random.Generator
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Draw π around the links until every link is physical; the links themselves where that does not happen."""
    values, vectors = np.linalg.eigh(belief.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    n = 10 * len(device.massive)
    for _ in range(TRIES):
        pi = links.pi + root @ rng.standard_normal(links.pi.size)
        bodies = [np.linalg.eigvalsh(pseudo_inertia(pi[i : i + 10]))[0] for i in range(0, n, 10)]
        if min(bodies) > 0 and bool(np.all(pi[n:] >= 0)):
            return pi
    return links.pi


def _joint_parameters(steps: Sequence[Step], rng: np.random.Generator | None) -> dict[str, float]:
    """Return springs and friction by id with the joint's number; drawn from each fit's covariance where rng is given."""
    result: dict[str, float] = {}
    for step in steps:
        result |= _of_step(step, rng)
    return result


def _of_step(step: Step, rng: np.random.Generator | None) -> dict[str, float]:
    fit, joints = step.fit, step.configuration.free_joints
    values = fit.values
    if rng is not None:
        values |= dict(zip(fit.free, _drawn(step, rng), strict=True))
    if len(joints) == 1:
        rigid = ("inertia", "gravity_cos", "gravity_sin")
        return {f"{id}_{joints[0]}": v for id, v in values.items() if id not in rigid}
    tails = tuple(f"_{j}" for j in joints)
    return {id: v for id, v in values.items() if id.endswith(tails) and id[0] not in "MV"}


def _drawn(step: Step, rng: np.random.Generator) -> list[float]:
    fit = step.fit
    std = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    values, vectors = np.linalg.eigh(fit.covariance / np.outer(std, std))
    shift = std * (vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(values.size)))
    centre = [fit.values[id] for id in fit.free]
    quantities = [fit.equations.parameter(id) for id in fit.free]
    return [float(np.clip(c + d, q.lower, q.upper)) for c, d, q in zip(centre, shift, quantities, strict=True)]
