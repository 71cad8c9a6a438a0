"""Fits on a running Dask cluster: a scheduler and two workers in processes of their own, reached by address."""

import importlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import dask
import numpy as np
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from distributed import Client

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import initial_state
from haptid.identification.workers.dask_workers import Cluster
from haptid.identification.workers.workers import Here
from haptid.measurement.values.run import Run
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError, NumericalError

ROOT = Path(__file__).parents[3]
SERVE = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, protocol=sys.argv[1]) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@contextmanager
def cluster(folder: Path, path: str, protocol: str = "tcp") -> Iterator[str]:
    """Serve a cluster from ``folder`` whose processes import from ``path``; ends with its standard input."""
    script = folder / "serve.py"
    script.write_text(SERVE, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": path}
    with subprocess.Popen(
        [sys.executable, str(script), protocol], cwd=folder, env=environment, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    ) as served:  # fmt: skip
        try:
            yield served.stdout.readline().strip()
        finally:
            served.stdin.close()
            served.wait(30)


def test_the_same_fit_on_a_cluster_and_here(tmp_path: Path):
    equations = joint_equations(0).with_parameters({id: {"fixed": True} for id in ("Kp", "gravity_cos", "gravity_sin")})
    simulator = KernelSimulator.of(equations)
    t = np.arange(0.0, 3.0, 0.01)
    run = Run(
        file="a", free_joints=(0,), t=t, u=0.01 * np.cos(4 * t)[:, None], y=np.zeros((t.size, 1)),
        noise=np.array([2e-4]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
    )  # fmt: skip
    theta = np.array([q.initial for q in equations.parameters])
    y = simulator.simulate(theta * 1.1, run, x0=initial_state(equations, run)).y
    run = run.but(y=y + 2e-4 * np.random.default_rng(0).standard_normal(y.shape))
    options = FitOptions(starts=3, agree=3)
    here = fit(simulator, [run], options=options, workers=Here())
    with cluster(tmp_path, str(ROOT)) as address, Cluster(address) as workers:
        assert workers.count == 2
        there = fit(simulator, [run], options=options, workers=workers)
    np.testing.assert_array_equal(here.theta, there.theta)
    assert here.simulations == there.simulations


def test_a_cluster_without_haptid_is_refused_in_one_line(tmp_path: Path):
    with (
        cluster(tmp_path, "") as address,
        pytest.raises(InputError, match=r"can import haptid, got tcp.*No module named 'haptid'.*PYTHONPATH"),
    ):
        Cluster(address)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "tls://127.0.0.1:1"])
def test_no_scheduler_at_the_address(address: str, monkeypatch: pytest.MonkeyPatch):
    made = []

    async def start(client: Client, **_: object) -> None:
        made.append(client)
        await begin(client, timeout=0.2)

    begin = Client._start
    monkeypatch.setattr(Client, "_start", start)
    with pytest.raises(InputError, match="the address of a running Dask scheduler"):
        Cluster(address)
    assert [client.status for client in made] == ["closed"], "the collector would close it, and can wait for ever"


@pytest.fixture
def certificate(tmp_path: Path) -> Iterator[None]:
    """One self-made certificate for both sides, in Dask's configuration of this process and of those it starts."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "localhost")])
    day = timedelta(days=1)
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
        .serial_number(1).not_valid_before(now - day).not_valid_after(now + day)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True).sign(key, hashes.SHA256())
    )  # fmt: skip
    encoding, none = serialization.Encoding.PEM, serialization.NoEncryption()
    cert, secret = tmp_path / "cert.pem", tmp_path / "key.pem"
    cert.write_bytes(made.public_bytes(encoding))
    secret.write_bytes(key.private_bytes(encoding, serialization.PrivateFormat.PKCS8, none))
    both = {"cert": str(cert), "key": str(secret)}
    roles = {"ca-file": str(cert), "scheduler": both, "worker": both, "client": both}
    (tmp_path / "dask.yaml").write_text(json.dumps({"distributed": {"comm": {"tls": roles}}}))
    with (
        pytest.MonkeyPatch.context() as patch,
        dask.config.set({f"distributed.comm.tls.{k}": v for k, v in roles.items()}),
    ):
        patch.setenv("DASK_CONFIG", str(tmp_path / "dask.yaml"))
        yield


@pytest.mark.usefixtures("certificate")
def test_an_encrypted_scheduler_is_used_with_the_certificates_of_dasks_configuration(tmp_path: Path, capfd):
    with cluster(tmp_path, str(ROOT), "tls") as address, Cluster(address) as workers:
        assert address.startswith("tls://")
        assert workers.count == 2
        assert workers.submit(pow, 2, 5).result(30) == 32
        with (
            dask.config.set({"distributed.comm.tls.ca-file": None}),
            pytest.raises(InputError, match=r"distributed\.comm\.tls"),
        ):
            Cluster(address)
    assert "not encrypted" not in capfd.readouterr().err


def test_an_unencrypted_scheduler_elsewhere_is_told(capsys: pytest.CaptureFixture[str], monkeypatch):
    monkeypatch.setattr("haptid.identification.workers.dask_client.DaskClient", Unreachable)
    for address, told in (("tcp://lab.example:8786", 1), ("tls://lab.example:8786", 0), ("tcp://127.0.0.1:1", 0)):
        with pytest.raises(InputError):
            Cluster(address)
        assert capsys.readouterr().err.count("is not encrypted") == told


class Unreachable:
    """A client of a host that is not there, without the wait."""

    def __init__(self, *_: object, **__: object) -> None:
        raise OSError("no route")


@pytest.mark.parametrize("address", ["lab.example", "http://lab.example:80", "tcp://lab:x", "tls://:1", "tcp://[::1"])
def test_what_is_no_address_is_refused(address: str):
    with pytest.raises(InputError, match="expected tls://HOST:PORT or tcp://HOST:PORT"):
        Cluster(address)


DEADLY = """
import os
import signal


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_workers_that_die_of_a_task_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "deadly.py").write_text(DEADLY, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    die = importlib.import_module("deadly").die  # made above; the workers import it too

    with (
        cluster(tmp_path, f"{ROOT}{os.pathsep}{tmp_path}") as address,
        Cluster(address) as workers,
        pytest.raises(NumericalError, match="killed by one task again and again"),
    ):
        workers.until(die, [()], lambda results: 1 - len(results))
