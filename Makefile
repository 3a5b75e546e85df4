# SPDX-License-Identifier: Apache-2.0
# make demo, make test: both set up whatever is missing in .venv first.  make help: all commands.

PYTHON ?= python3
VENV := $(if $(SPIRAL_WITHOUT_ROS),.venv-without-ros,.venv)
BIN := $(VENV)/bin
STEP := sh packaging/step.sh
LOGS := .make

# What is compiled or copied at installation; Python sources are used in place (pip install -e).
INSTALL_SOURCES := pyproject.toml LICENSE $(wildcard packaging/*.cmake packaging/ros_metadata.py packaging/ros2_run_stub.sh) \
  $(wildcard */package.xml */resource/* spiral_gripper_ros/config/* spiral_gripper_ros/launch/*.py spiral_gripper_ros/rviz/* spiral_gripper_ros/security/* spiral_gripper_ros/systemd/* spiral_gripper_ros/urdf/*) \
  $(wildcard spiral_gripper_msgs/CMakeLists.txt spiral_gripper_msgs/msg/* spiral_gripper_msgs/srv/* spiral_gripper_msgs/action/*)
INSTALLED := $(VENV)/.installed
INSTALLED_DEV := $(VENV)/.installed-dev
# numba keeps what it has compiled beside the sources.
KERNELS := packaging/compile_kernels.py $(wildcard spiral_core/spiral_core/numerics/kernel.py spiral_core/spiral_core/wrap/_*.py \
  spiral_core/spiral_core/rod/_*.py spiral_core/spiral_core/rod/types.py spiral_core/spiral_core/rod/contact/_*.py spiral_core/spiral_core/rod/motion/_*.py)
COMPILED := $(VENV)/.compiled$(NUMBA_CPU_NAME)

# Another Python's or another ROS installation's settings must not reach our environment.
unexport PYTHONHOME PYTHONPATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH
ifneq ($(ROS_DISTRO)$(_ROS_WHEELS_BOOTSTRAP_COMPLETE),)
unexport LD_LIBRARY_PATH
endif
unexport ROS_DISTRO _ROS_WHEELS_BOOTSTRAP_COMPLETE
# Else every worker and every process that a test starts would compile all Python sources anew.
unexport PYTHONDONTWRITEBYTECODE

# yes where the node can run: Linux x86-64, and not SPIRAL_WITHOUT_ROS=1
WITH_ROS = $(shell $(BIN)/python packaging/ros_metadata.py)
WITHOUT_ROS = tests/edge tests/core spiral_core/spiral_core spiral_gripper/spiral_gripper
TESTS = $(if $(filter yes,$(WITH_ROS)),,$(WITHOUT_ROS))
VERSION = $(shell $(BIN)/python -c 'import sys; print("%d.%d" % sys.version_info[:2])')
TYPED = $(if $(filter yes,$(WITH_ROS)),,-p spiral_core -p spiral_gripper)

.PHONY: fuzz cycles grip-tables kilted docs help demo test test-fast test-slow test-generic lint check colcon pure lower-bounds format figures validation bench bench-ros install clean distclean
.DELETE_ON_ERROR:

help:
	@echo 'make demo          start the node, send it good and bad radii, show its answers'
	@echo 'make test          format check, lint, types, tests, doctests'
	@echo 'make test-fast     the same without ROS processes and without the files of tests that compute for long'
	@echo 'make test-slow     the tests that compute for long'
	@echo 'make test-generic  test and test-slow, the kernels compiled for no processor in particular'
	@echo 'make check         what .ci/run does: test, test-slow, docs, pure and colcon'
	@echo 'make pure          build and test the mechanics alone, where there is no ROS'
	@echo 'make colcon        colcon build (isolated, merged, symlinked) and a smoke check of each'
	@echo 'make kilted        build against the wheels of ROS 2 Kilted, and test the node with them'
	@echo 'make lower-bounds  tests with the oldest dependencies that pyproject.toml allows'
	@echo 'make format        format the sources as make test requires'
	@echo 'make docs          the documentation as a site, in docs/_site'
	@echo 'make figures       draw the pictures of the documentation'
	@echo 'make grip-tables   compute the tables of grips of the shipped grippers (some ten minutes)'
	@echo 'make validation    compute docs/validation.md and validation_grip.md: what the paper states, what we compute'
	@echo 'make bench         measure the figures that the documentation states (ONLY="solves wraps": some)'
	@echo 'make bench-ros     measure the node: latency, load, endurance, start (some eight minutes)'
	@echo 'make cycles        1,000 times wrap, lift, release with faults at random: no unsafe command (some minutes)'
	@echo 'make fuzz          random sequences against the control logic and a live node (some 20 minutes)'
	@echo 'make install       set up .venv only (an editable installation), with its kernels compiled'
	@echo 'make clean         remove logs, caches and scratch workspaces; make distclean: .venv too'
	@echo
	@echo 'PYTHON=python3.12 chooses the interpreter (3.10 or newer), SPIRAL_WITHOUT_ROS=1 leaves ROS out.'

# pip is the last thing that venv installs: an interrupted environment is made again.
$(BIN)/pip:
	@sh packaging/check_tools.sh $(PYTHON)
	@$(STEP) $(LOGS)/venv.log "Creating the virtual environment $(VENV)" $(PYTHON) -m venv $(VENV)

$(INSTALLED): $(INSTALL_SOURCES) | $(BIN)/pip
	@sh packaging/check_tools.sh $(BIN)/python
	@$(STEP) $(LOGS)/install.log "Installing the dependencies and compiling the ROS 2 messages (1 to 3 minutes)" \
	  $(BIN)/python -m pip install -e '.[plot]'
	@touch $@

# The installed distribution is found first, so that only what the extra adds is installed.
$(INSTALLED_DEV): $(INSTALLED)
	@$(STEP) $(LOGS)/install-dev.log "Installing the tools for tests, lint and types" \
	  $(BIN)/python -m pip install 'spiral-gripper[dev]'
	@touch $@

$(COMPILED): $(KERNELS) | $(INSTALLED)
	@$(STEP) $(LOGS)/compile.log "Compiling the numerical kernels, once (some 20 s on two free cores)" \
	  $(BIN)/python packaging/compile_kernels.py
	@touch $@

install: $(INSTALLED) $(COMPILED)

demo: $(INSTALLED)
	@[ "$(WITH_ROS)" = yes ] || { echo 'The demo needs ROS 2: Linux x86-64, Python 3.10 to 3.13,' \
	  'SPIRAL_WITHOUT_ROS not set.' >&2; exit 1; }
	@trap ':' INT; $(BIN)/spiral_gripper_demo

# Tests of one file share their node, so a file stays with one worker; those of the node, which take
# longest, come first. They mostly wait: two workers for each core; slow ones compute: one.
CORES := $(shell getconf _NPROCESSORS_ONLN)
JOBS ?= $(shell echo $$((2 * $(CORES))))
PYTEST = $(BIN)/pytest --numprocesses=$(JOBS) --dist=loadfile --no-loadscope-reorder

test: lint $(COMPILED)
	$(PYTEST) -m 'not slow' $(TESTS)

test-fast: lint $(COMPILED)
	$(PYTEST) -m 'not slow and not long' $(WITHOUT_ROS)

test-slow: JOBS = $(CORES)
test-slow: $(INSTALLED_DEV) $(COMPILED)
	$(PYTEST) -m slow $(TESTS)

lint: $(INSTALLED_DEV)
	$(BIN)/ruff format --check . || { echo 'make format fixes this.'; exit 1; }
	$(BIN)/ruff check .
	$(if $(filter 3.10,$(VERSION)),@echo 'types: checked with Python 3.11 and newer only; numpy and scipy for 3.10 come with older ones',$(BIN)/mypy $(TYPED))

format: $(INSTALLED_DEV)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# Answers must not depend on how a processor rounds; numba keeps both kinds of kernels.
test-generic:
	NUMBA_CPU_NAME=generic $(MAKE) test test-slow

check: test test-slow docs pure colcon

pure:
	@PYTHON="$(PYTHON)" sh packaging/pure_check.sh

colcon:
	@PYTHON="$(PYTHON)" bash packaging/colcon_check.sh

kilted:
	@PYTHON="$(PYTHON)" sh packaging/kilted_check.sh $(ONLY)

lower-bounds:
	@PYTHON="$(PYTHON)" sh packaging/pure_check.sh lower-bounds

figures: $(INSTALLED_DEV)
	$(BIN)/python docs/figures.py
	$(BIN)/python docs/section_figures.py
	$(BIN)/python docs/derivation_figures.py
	PYTHONPATH=. $(BIN)/python docs/contact_figures.py

grip-tables: $(INSTALLED)
	for file in spiral_gripper/spiral_gripper/config/*.yaml; do $(BIN)/spiral-gripper grip $$file --table || exit; done

docs: $(INSTALLED_DEV)
	@$(STEP) $(LOGS)/install-docs.log "Installing Sphinx" $(BIN)/python -m pip install 'spiral-gripper[docs]'
	$(BIN)/sphinx-build -q -W --keep-going docs docs/_site
	@echo 'written: docs/_site/index.html'

validation: $(INSTALLED_DEV)
	$(BIN)/python docs/validation.py
	$(BIN)/python docs/validate_grip.py

# Peers are optional: where they cannot be installed their tables say so.
bench: $(INSTALLED_DEV)
	-@$(STEP) $(LOGS)/install-bench.log "Installing peers to compare with" \
	  $(BIN)/python -m pip install 'spiral-gripper[bench]'
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks $(ONLY)

bench-ros: $(INSTALLED_DEV)
	$(BIN)/python -m benchmarks.ros $(ONLY)

# More than 100,000 steps of the control logic, more than 10,000 of a live node.
cycles: $(INSTALLED_DEV)
	$(BIN)/python -m benchmarks.ros.cycles $(ONLY)

fuzz: $(INSTALLED_DEV)
	$(BIN)/pytest tests/ros/test_control_machine.py tests/ros/test_live_machine.py --hypothesis-profile=fuzz

clean:
	rm -rf $(LOGS) docs/_site docs/reference docs/gallery.rst docs/figures/gallery .colcon .hypothesis .mypy_cache .pytest_cache .ruff_cache build install log dist
	find spiral_core spiral_gripper spiral_gripper_ros tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf .venv .venv-without-ros
