# Verbs, one line each. `support/bootstrap.py` needs only the standard library: it installs what is missing into the
# interpreter in use (or into .venv where that one is externally managed) and then runs the command.
NEW_ENOUGH = -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null
NAMES = python python3 python3.14 python3.13 python3.12 python3.11 .venv/bin/python
PYTHON ?= $(or $(shell for p in $(NAMES); do $$p $(NEW_ENOUGH) && echo $$p && break; done),python3)
RUN = $(PYTHON) support/bootstrap.py
.PHONY: fmu check test long real bench docs blind thresholds calibrate fuzz faults interpreters cluster parquet mcap rosbags matlab posterior locked sizes licences sbom

fmu: ; $(RUN) -m fmu_build.run
check: ; $(RUN) --dev -m support.check
test: ; $(RUN) --dev -m pytest -m "not long" -n 2 --dist worksteal
long: ; $(RUN) --dev -m pytest -m long -n 2 --dist worksteal
real: ; $(RUN) --dev -m benchmarks.real_machines && $(RUN) --dev -m pytest --real -n 2 --dist worksteal
bench: ; $(RUN) --dev -m benchmarks.run
docs: ; $(RUN) --extra docs -m docs.build
blind: ; $(RUN) -m studies.blind.run
thresholds: ; $(RUN) --extra posterior -m studies.thresholds.run
calibrate: ; $(RUN) --extra posterior -m studies.calibration.run
fuzz: ; $(RUN) --dev -m tests.fuzz.run $(FUZZ)
interpreters: ; bash .ci/wheel && bash .ci/interpreters
faults: ; HAPTID_KILLS=10 $(RUN) --dev -m pytest tests/faults -v

# What few need is installed on demand: an extra of pyproject.toml, in the versions of uv.lock, checked by their hashes.
cluster: ; $(RUN) --extra cluster
parquet: ; $(RUN) --extra parquet
mcap: ; $(RUN) --extra mcap
rosbags: ; $(RUN) --extra rosbags
matlab: ; $(RUN) --extra matlab
posterior: ; $(RUN) --extra posterior
# Files that are made from uv.lock.
locked: ; $(RUN) --dev -m support.installing.supply_chain lock
sizes: ; $(RUN) --dev -m support.installing.supply_chain sizes
licences: ; $(RUN) --dev -m support.installing.supply_chain licences
sbom: ; $(RUN) --dev -m support.installing.supply_chain sbom
