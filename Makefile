# Everything happens in .venv, which is made once, and again whenever setup.py changes.
PYTHON ?= python3
MINUTES ?= 5
WORKERS ?= 2
SOAK_MINUTES ?= 120

# Where a ROS installation is sourced, its rclpy is on PYTHONPATH (-S hides all other packages)
# and is used, together with the system's numpy, which it was built for. Everywhere else ROS
# comes as wheels from PyPI. The stamp tells the two apart: sourcing ROS later makes .venv anew.
ROS := $(shell $(PYTHON) -S -c 'from importlib.util import find_spec as f; \
	print("sourced" if f("rclpy") else "wheels")' 2>/dev/null)
EXTRAS_wheels = ros,record,pictures,study,dataset,viewer,test
EXTRAS_sourced = record,pictures,study,dataset,viewer,test
VENV_sourced = --system-site-packages
READY = .venv/ready-$(ROS)

help:
	@echo 'make demo   film config/gust.yaml into out/demo (another shot: make demo SHOT=name)'
	@echo 'make view   play config/turn.yaml live in a window, where all can be turned and keyed'
	@echo 'make test   run all tests, in WORKERS=$(WORKERS) processes'
	@echo 'make soak   run 2000 random extremes of the cloth for each method that promises to bear them,'
	@echo '            finer grids, statistics of more flights, damaged files, 100000 hostile inputs'
	@echo '            for the nodes, networks that lose and delay, workers that are killed, and then twice the whole graph'
	@echo '            for SOAK_MINUTES=$(SOAK_MINUTES), into out/soak.json (5: an hour in all)'
	@echo 'make bench  measure frames per second, the work on many keys, how time grows with nodes and'
	@echo '            pixels, what the processor allows, what looks, channels and compiling cost, and'
	@echo '            datasets, into out/bench*.json'
	@echo 'make bench-cloth    move the cloth beside other programs, into out/bench-cloth.json'
	@echo 'make bench-drawing  draw frames beside other programs, into out/bench-drawing.json'
	@echo 'make study  measure what accuracy costs here, in MINUTES=$(MINUTES), into out/study/report.md'
	@echo 'make parameters   write docs/parameters.md by the declarations in the code'
	@echo 'make clean  remove .venv, out and all that was built'

# Demos and tests look for nobody beyond this machine (who can reach them: docs/security.md).
demo view test soak bench: export ROS_AUTOMATIC_DISCOVERY_RANGE = LOCALHOST

# An editable install has copies of config/ where `ros2 pkg prefix flag_sim` leads.
COPIED = .venv/config-copied
demo view test soak bench study: $(READY) $(COPIED)

demo:
	@.venv/bin/python -m flag_sim.tools.demo $(if $(SHOT),--shot '$(SHOT)')

view:
	@.venv/bin/python -m flag_sim.tools.view $(if $(SHOT),--shot '$(SHOT)')

test:
	@.venv/bin/python -m pytest -rs -n '$(WORKERS)' --dist worksteal

soak:
	@FLAG_SIM_EXTREMES=2000 FLAG_SIM_SOAK=1 FLAG_SIM_DAMAGED=5000 \
	FLAG_SIM_SOAK_MINUTES='$(SOAK_MINUTES)' .venv/bin/python -m pytest -rsP \
	test/cloth/test_conservation.py test/cloth/test_extremes.py test/cloth/test_refinement.py \
	test/cloth/test_statistics.py test/nodes/test_damaged_files.py test/nodes/test_hosts.py \
	test/nodes/test_fuzz.py test/nodes/test_faults.py test/nodes/test_graph.py \
	test/nodes/test_physics_parameters.py test/ros/test_waiting.py \
	test/drawing/test_again.py test/jit/test_processors.py test/dataset/test_engine.py \
	test/protocol/test_a_take_ends.py \
	test/package/test_benchmarks.py test/tools/test_demo.py \
	test/nodes/test_soak.py

bench:
	@.venv/bin/python test/benchmark/pipeline.py
	@.venv/bin/python test/benchmark/animation.py
	@.venv/bin/python test/benchmark/frame_time.py
	@.venv/bin/python test/benchmark/growth.py
	@.venv/bin/python test/benchmark/roofline.py
	@.venv/bin/python test/benchmark/looks.py
	@.venv/bin/python test/benchmark/compiling.py
	@.venv/bin/python test/benchmark/dataset.py

study:
	@.venv/bin/python -m flag_sim.study --minutes '$(MINUTES)'

parameters: $(READY)
	@.venv/bin/python -m flag_sim.declarations.page > docs/parameters.md

# The peers have an environment of their own; one that cannot be installed is named by the table.
PEERS = moderngl panda3d opencv-python-headless taichi newton mujoco
bench-cloth bench-drawing: .venv-peers/ready
	@PYTHONPATH=. .venv-peers/bin/python test/benchmark/$(@:bench-%=%).py

.venv-peers/ready: setup.py Makefile
	@$(PYTHON) -m venv --clear .venv-peers
	@.venv-peers/bin/python -m pip install -qq --disable-pip-version-check -e .
	@for peer in $(PEERS); do \
	.venv-peers/bin/python -m pip install -qq --disable-pip-version-check $$peer || true; done
	@touch '$@'

$(COPIED): $(READY) $(wildcard config/*)
	@cp config/* .venv/share/flag_sim/config/
	@touch '$@'

clean:
	rm -rf .venv .venv-peers out build install log *.egg-info .pytest_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +

$(READY): setup.py pyproject.toml package.xml
	@$(PYTHON) -c 'import sys, venv, ensurepip; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' 2>/dev/null \
	|| { echo 'flag_sim needs Python 3.10 to 3.13 with its venv module (Debian, Ubuntu: apt install' \
	'python3-venv); "$(PYTHON)" is:' "$$($(PYTHON) --version 2>&1)" >&2; exit 1; }
	@echo 'Installing flag_sim and what it needs in .venv (ROS: $(ROS)); this takes a minute or two.'
	@$(PYTHON) -m venv --clear $(VENV_$(ROS)) .venv
	@.venv/bin/python -m pip install -qq --disable-pip-version-check -e '.[$(EXTRAS_$(ROS))]'
	@.venv/bin/python -c 'import rclpy' \
	|| { echo 'rclpy cannot be imported; a sourced ROS needs its own Python: make PYTHON=/usr/bin/python3' >&2; exit 1; }
	@touch '$@'

.PHONY: help demo view test soak bench bench-cloth bench-drawing study parameters clean
