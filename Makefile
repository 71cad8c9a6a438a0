# Five verbs, one line each. `support/bootstrap.py` needs only the standard library: it installs what is missing
# into the interpreter in use (or into .venv where that one is externally managed) and then runs the command.
PYTHON ?= python3
RUN = $(PYTHON) support/bootstrap.py
.PHONY: fmu check test bench docs blind calibrate

fmu: ; $(RUN) -m fmu_build.run
check: ; $(RUN) --dev -m support.check
test: ; $(RUN) --dev -m pytest -n 2 --dist worksteal
bench: ; $(RUN) --dev -m benchmarks.run
docs: ; $(RUN) -m docs.build
blind: ; $(RUN) -m discrepancy.blind
calibrate: ; $(RUN) -m uq.calibrate
