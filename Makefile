# Works on a machine without ROS, with Python 3.10 to 3.14: everything goes into .venv.

PYTHON ?= python3
VENV ?= .venv
SOURCE ?= scene:occlusion
PARAMS ?=
COLOR ?=
TOLERANCE ?=
SECONDS ?= 21
ROBOT ?=
TESTS ?=

# As they were given, whatever quotes and dollars are in the name of a file.
export DEMO_SOURCE := $(value SOURCE)
export DEMO_PARAMS := $(value PARAMS)

# A sourced ROS and another environment's wheels would be mixed into this one. Without bytecode each
# process that the tests start compiles all modules, and each worker rewrites all tests.
RUN = env -u PYTHONDONTWRITEBYTECODE -u PYTHONPATH \
  -u LD_LIBRARY_PATH -u AMENT_PREFIX_PATH -u _ROS_WHEELS_BOOTSTRAP_COMPLETE
PYTHON_IN = $(RUN) $(VENV)/bin/python

# pip 23, as of Python 3.10, would run setup.py, which puts executables where only `ros2 run` looks.
export PIP_USE_PEP517 = 1

UBUNTU = opencv-python-headless==4.6.0.66 numpy==1.26.4 scipy==1.11.4

# What there are wheels of rclpy for: elsewhere pip would end in pages about versions it cannot find.
LIBC_AND_PYTHON = import platform, sys; print(platform.libc_ver()[0], 'Python %d.%d' % sys.version_info[:2])
define environment
	@found="$$(uname -s) $$(uname -m) $$($(PYTHON) -c "$(LIBC_AND_PYTHON)")"; case "$$found" in \
	  'Linux x86_64 glibc Python 3.1'[0-4]) ;; \
	  *) echo "Without ROS this needs Linux x86_64 glibc Python 3.10 to 3.14, here is $$found:" \
	    "use ROS 2 Jazzy from apt and colcon, or an x86-64 container" \
	    "(docker run --platform linux/amd64)." >&2; exit 1;; \
	esac
	$(RUN) $(PYTHON) -m venv $*
endef

BENCHMARKS = $(filter-out %/points.py %/peers.py %/soak.py %/faults.py,$(wildcard benchmark/*.py))

.PHONY: bench soak demo tuner test quick test-ubuntu lint docs doc/demo.webp doc/tuner.webp clean

# With ROBOT=1 a simulated robot that follows a ball, in place of SOURCE.
demo: $(VENV)/demo
	$(if $(filter-out 0,$(ROBOT)),\
	$(PYTHON_IN) -m colortrack_ros.commands tools.robot_demo --seconds='$(SECONDS)',\
	$(PYTHON_IN) -m colortrack_ros.commands tools.demo --source="$$DEMO_SOURCE" --params="$$DEMO_PARAMS" \
		--color='$(COLOR)' --tolerance='$(TOLERANCE)' --seconds='$(SECONDS)')

# A page to tune in, over SOURCE, with PARAMS to begin with and to save to.
tuner: $(VENV)/tuner
	$(RUN) $(VENV)/bin/tuner $(if $(PARAMS),--params-file="$$DEMO_PARAMS") -- "$$DEMO_SOURCE"

# More at once than there are cores, since nodes mostly wait; when they are done, one after the other
# those that measure time. TESTS=... instead of all.
define run_tests
	$(RUN) $(1) -m pytest $(or $(TESTS),--numprocesses 4 -m 'not alone' test)
	$(if $(TESTS),,$(RUN) $(1) -m pytest -m alone test)
endef

test: $(VENV)/test
	$(call run_tests,$(VENV)/bin/python)

# What a change is tried with while it is made: the rooms, without what takes long.
quick: $(VENV)/test
	$(PYTHON_IN) -m pytest --numprocesses 2 --ignore test/ros -m 'not slow and not alone' test

# The same tests with the versions that Ubuntu 24.04 has.
test-ubuntu: .venv-ubuntu/test
	$(call run_tests,.venv-ubuntu/bin/python)

# Tables on the terminal, the same numbers as JSON in out/.
# Those that need data say so, and end with 2.
bench: .venv-bench/bench
	for script in $(BENCHMARKS); do \
		$(RUN) .venv-bench/bin/python $$script || [ $$? -eq 2 ] || exit 1; done

# 30 minutes' worth of frames: memory, threads and files of the pipeline stay what they are.
soak: .venv-bench/bench
	$(RUN) .venv-bench/bin/python benchmark/soak.py

# With tools of its own, in the versions of .ci/lint.txt.
lint: .venv-lint/lint
	.venv-lint/bin/ruff format --check .
	.venv-lint/bin/ruff check .
	$(RUN) .venv-lint/bin/python -m mypy colortrack_ros

.venv-lint/lint: .ci/lint.txt
	$(RUN) $(PYTHON) -m venv .venv-lint
	$(RUN) .venv-lint/bin/python -m pip install --quiet --disable-pip-version-check -r .ci/lint.txt
	touch $@

%/demo: setup.py
	$(environment)
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check -e '.[standalone,demo,replay]'
	touch $@

%/tuner: setup.py
	$(environment)
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check \
		-e '.[standalone,demo,replay,tuner]'
	touch $@

%/test: setup.py
	$(environment)
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check \
		-e '.[standalone,demo,replay,test]' $(if $(findstring ubuntu,$*),$(UBUNTU))
	touch $@

# The pages of doc/ as HTML, in build/html.
docs: $(VENV)/docs
	$(PYTHON_IN) doc/parameter_pages.py
	$(PYTHON_IN) -m sphinx -W --keep-going --quiet --builder html doc build/html

# The moving picture of the README; needs ffmpeg.
doc/demo.webp: $(VENV)/demo
	mkdir -p build
	$(RUN) $(VENV)/bin/replay 'scene:occlusion?width=480&height=270&noise=0&duration=11' \
		--params-file params/colortrack.yaml --output build/demo --video build/demo.mp4 --force
	ffmpeg -v error -y -ss 5 -i build/demo.mp4 -vf fps=12 -loop 0 -quality 50 $@

# The moving picture of the tuner's page; needs ffmpeg and chromium.
doc/tuner.webp: $(VENV)/test
	rm -rf build/tuner
	$(PYTHON_IN) doc/tuner_film.py build/tuner
	ffmpeg -v error -y -framerate 6 -i build/tuner/%04d.png -vf scale=800:-1 -loop 0 -quality 40 $@

%/docs: setup.py
	$(environment)
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check \
		-e '.[standalone,docs]'
	touch $@

# norfair asks for NumPy 1, which the newest OpenCV does not work with; it works with NumPy 2.
%/bench: setup.py benchmark/requirements.txt
	$(environment)
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check -e '.[standalone,demo,replay]'
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check \
		-r benchmark/requirements.txt
	$(RUN) $*/bin/python -m pip install --quiet --disable-pip-version-check --no-deps norfair
	touch $@

clean:
	rm -rf $(VENV) .venv-lint .venv-ubuntu .venv-bench build install log out
