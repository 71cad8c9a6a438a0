"""The posterior of a joint after other friction laws than LuGre."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.uq.run import main
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.identification.bench_joint import TRUE

COSINES = (
    Cosine(amplitude=0.005, frequency=2.5, duration=2.5),
    Cosine(amplitude=0.004, frequency=4.0, duration=2.5, use="validate"),
)
OF_LAW = {"dahl": ("Fc", "sigma0", "n"), "maxwell_slip": ("Fc", "sigma0", "spread")}
"""Free parameters; all others are fixed at the truth."""
HAS = {
    "dahl": {"sigma0", "n", "sigma2", "Fc"},
    "maxwell_slip": {"sigma0", "spread", "unevenness", "C", "sigma2", "vs", "Fs", "Fc"},
}


@pytest.mark.parametrize("law", OF_LAW)
def test_the_posterior_holds_the_truth(law: str, tmp_path: Path):
    truth = {**TRUE, "Kp": 1.0, "n": 1.4, "C": 0.04, "spread": 2.0, "unevenness": 0.8}
    known = {}
    for id in {"inertia", "gravity_cos", "gravity_sin", "Ks", "epos"} | HAS[law]:
        value = truth.get(id, 0.0)
        free = {"initial": value, "prior": {"mean": value, "std": 0.1 * value}}
        known[id] = free if id in OF_LAW[law] else {"fixed": value}
    sensor = Sensor(noise=2e-4, resolution=0.0)
    make_joint_campaign(tmp_path, 4, truth, COSINES, sensor=sensor, seed=7, friction=law, known=known)
    out = tmp_path / "out"
    done = CliRunner().invoke(main, [str(tmp_path), "--quick", "--out", str(out), "--workers", "1", "--quiet"])
    assert done.exit_code == 0, done.output
    (joint,) = json.loads((out / "posterior.json").read_text())["joints"]
    for id in OF_LAW[law]:
        found = joint["parameters"][id]
        assert abs(found["mean"] - truth[id]) < 4.5 * found["std"]
        assert found["std"] < 0.05 * truth[id]  # half of the prior's width: the data speak
