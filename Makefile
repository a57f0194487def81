# Cagewright: one graph for everything. `make help` lists what can be made.
#
# Variables of the user: CC CXX CFLAGS LDFLAGS PREFIX DESTDIR BUILD BIN SAN JOBS DATA CLUSTER V.
# BUILD=build/asan SAN=address,undefined builds a sanitized variant beside the default one.

BUILD ?= build
BIN ?= $(if $(SAN),$(BUILD)/bin,bin)
PREFIX ?= /usr/local
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
CFLAGS ?= -O3 -g
CXXFLAGS ?= $(CFLAGS)
OPENMP ?= -fopenmp

WARN = -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wvla -Wstrict-prototypes -Wmissing-prototypes \
	-Werror=implicit-function-declaration $(WERROR)
# -ffp-contract=off: clang, and gcc with gnu11, fuse a*b+c by default, and the same input must give the same bytes.
all_cflags = -std=c11 -D_GNU_SOURCE -I. $(WARN) -ffp-contract=off $(OPENMP) -MMD -MP $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer) $(CFLAGS)
all_cxxflags = -std=c++17 -I. -Wall -Wextra $(WERROR) -ffp-contract=off -MMD -MP $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer) $(CXXFLAGS)
all_ldflags = $(OPENMP) -Wl,--as-needed $(if $(SAN),-fsanitize=$(SAN)) $(LDFLAGS)
OPENMESH = -lOpenMeshTools -lOpenMeshCore
LIBS = $(OPENMESH) -lembree3 -lcholmod -llapacke -lz -lpng -lOSMesa -lm

# What is done in one short line; V=1 shows the commands whole.
say = $(if $(V),,@echo '  $(1)' && )

STAGES := $(filter-out geometry tool,$(notdir $(patsubst %/,%,$(wildcard stages/*/))))
MAINS := $(foreach s,$(STAGES),$(wildcard stages/$(s)/$(s).c))
LIB_C := $(wildcard formats/*.c stages/geometry/*.c stages/tool/*.c)
KERNEL_C := $(filter-out $(MAINS),$(foreach s,$(STAGES),$(wildcard stages/$(s)/*.c)))
SHIM_CPP := $(wildcard formats/shim/*.cpp)
UNIT_C := $(wildcard tests/unit/test_*.c)

LIB_OBJ := $(LIB_C:%=$(BUILD)/%.o)
KERNEL_OBJ := $(KERNEL_C:%=$(BUILD)/%.o)
SHIM_OBJ := $(SHIM_CPP:%=$(BUILD)/%.o)
MAIN_OBJ := $(MAINS:%=$(BUILD)/%.o)
UNIT_OBJ := $(UNIT_C:%=$(BUILD)/%.o)
TOOLS := $(foreach m,$(MAINS),$(BIN)/$(basename $(notdir $(m))))
UNITS := $(UNIT_C:tests/unit/%.c=$(BUILD)/tests/%)

ifeq ($(findstring -j,$(MAKEFLAGS))$(findstring jobserver,$(MAKEFLAGS)),)
MAKEFLAGS += -j$(JOBS)
endif

.PHONY: all
all: $(TOOLS)
.DELETE_ON_ERROR:
.SECONDARY:

.PHONY: help
help:
	@echo 'all        build every tool into $(BIN)/'
	@echo 'deps       install the Debian packages that are missing (root, or sudo)'
	@echo 'demo       pack a sample part; pictures of every stage in build/demo'
	@echo 'check      every test; with DATA=folder also the list of well-known parts in it'
	@echo 'unit       the unit tests alone'
	@echo 'check-san  the readers and the decoder under sanitizers (SAN=address,undefined)'
	@echo 'bench      the pipeline over DATA=folder; build/bench.tsv and build/bench.html'
	@echo 'bench-segmentation  how well segment finds the faces of the sample parts'
	@echo 'bench-scaling  time and memory of one part from 1,000 to 1,000,000 triangles; build/scaling.tsv and .svg'
	@echo 'bench-peers  our bytes against edge collapse and Draco; build/peers.tsv and build/peers.html'
	@echo 'bench-decode  how fast streams become cages and surfaces; build/decode.tsv'
	@echo 'lint       compiler warnings as errors (gcc, clang), cppcheck, shellcheck, manual pages'
	@echo 'fuzz       the readers under libFuzzer, FUZZ_SECONDS each'
	@echo 'install    into $$(DESTDIR)$(PREFIX); uninstall'
	@echo 'clean      remove build/ and bin/'

# --- packages ----------------------------------------------------------------------------------------------------
BUILD_PACKAGES = gcc g++ make libopenmesh-dev zlib1g-dev libembree-dev libsuitesparse-dev liblapacke-dev libosmesa6-dev libpng-dev
CHECK_PACKAGES = libcmocka-dev mandoc perl gzip valgrind
LINT_PACKAGES = clang clang-tidy cppcheck clang-format shellcheck
# A small cluster for tests/cli/batch.t, which does without. These packages bring services that a running systemd would
# start: there only with CLUSTER=1.
CLUSTER_PACKAGES = munge slurmctld slurmd slurm-client
have_dpkg := $(shell command -v dpkg-query)
missing_of = $(filter-out $(shell dpkg-query -W -f='$${Package} $${Status}\n' $(1) 2>/dev/null | sed -n 's/ install ok installed$$//p'),$(1))
as_root = $(if $(filter 0,$(shell id -u)),,sudo)

# demo, check, lint and the rest install what they miss before anything is compiled. Where there is no dpkg the libraries are
# taken to be there; `make deps` says which they are.
goal_packages = $(if $(filter demo check unit check-san bench bench-peers bench-decode lint fuzz,$(MAKECMDGOALS)),$(BUILD_PACKAGES)) \
	$(if $(filter check unit check-san bench lint,$(MAKECMDGOALS)),$(CHECK_PACKAGES)) $(if $(filter lint fuzz,$(MAKECMDGOALS)),$(LINT_PACKAGES))
ifneq ($(strip $(goal_packages)),)
ifneq ($(have_dpkg),)
goal_missing := $(strip $(call missing_of,$(sort $(goal_packages))))
ifneq ($(and $(filter check,$(MAKECMDGOALS)),$(or $(CLUSTER),$(if $(wildcard /run/systemd/system),,1))),)
goal_offered := $(strip $(call missing_of,$(CLUSTER_PACKAGES)))
endif
endif
endif
ifneq ($(goal_missing)$(goal_offered),)
deps_first = deps-goal
endif

# install_packages LIST: say what is done, or exactly what is missing.
define install_packages
	@missing='$(strip $(1))'; test -z "$$missing" || { \
	if ! command -v apt-get > /dev/null; then echo "make deps: not a Debian system; install the libraries of: $$missing" >&2; exit 1; fi; \
	if test -n '$(as_root)' && ! command -v sudo > /dev/null; then echo "make deps: neither root nor sudo here; as root run: apt-get install $$missing" >&2; exit 1; fi; \
	echo "make deps: apt-get install $$missing"; \
	{ $(as_root) apt-get update -q && $(as_root) env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends $$missing; } < /dev/null || \
	{ echo "make deps: could not install: $$missing" >&2; exit 1; }; }
endef
# install_offered LIST: where that is possible without asking; nothing depends on it.
define install_offered
	@missing='$(strip $(1))'; test -z "$$missing" || { echo "make deps: apt-get install $$missing"; \
	{ $(if $(as_root),sudo -n true &&) timeout 120 $(as_root) sh -c 'apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends "$$@"' \
	sh $$missing; } < /dev/null || echo "make deps: the tests that need $$missing will be skipped"; }
endef
.PHONY: deps deps-lint deps-goal
deps:
	$(call install_packages,$(call missing_of,$(BUILD_PACKAGES) $(CHECK_PACKAGES)))
deps-lint:
	$(call install_packages,$(call missing_of,$(BUILD_PACKAGES) $(CHECK_PACKAGES) $(LINT_PACKAGES)))
deps-goal:
	$(call install_packages,$(goal_missing))
	$(call install_offered,$(goal_offered))

$(BUILD)/%.c.o: %.c | $(deps_first)
	@mkdir -p $(@D)
	$(call say,$(CC) $<)$(CC) $(CPPFLAGS) $(all_cflags) -c -o $@ $<
$(BUILD)/%.cpp.o: %.cpp | $(deps_first)
	@mkdir -p $(@D)
	$(call say,$(CXX) $<)$(CXX) $(CPPFLAGS) $(all_cxxflags) -c -o $@ $<

# One archive for formats and shared geometry, one for the methods of the stages; each tool pulls what it needs.
$(BUILD)/libcagewright.a: $(LIB_OBJ) $(SHIM_OBJ)
	$(call say,$(AR) $@)rm -f $@ && $(AR) rcs $@ $^
$(BUILD)/libstages.a: $(KERNEL_OBJ)
	$(call say,$(AR) $@)rm -f $@ && $(AR) rcs $@ $^

# unpack is plain C and needs nothing but libc, libm and zlib: a link that asks for more fails.
LINK = $(CXX)
$(BIN)/unpack: LINK = $(CC)
$(BIN)/unpack: LIBS = -lz -lm
define tool_rule
$(BIN)/$(1): $(BUILD)/stages/$(1)/$(1).c.o $(BUILD)/libstages.a $(BUILD)/libcagewright.a
	@mkdir -p $$(@D)
	$$(call say,link $$@)$$(LINK) $$(all_ldflags) -o $$@ $$< $(BUILD)/libstages.a $(BUILD)/libcagewright.a $$(LIBS)
endef
$(foreach m,$(MAINS),$(eval $(call tool_rule,$(basename $(notdir $(m))))))

# --- tests -------------------------------------------------------------------------------------------------------
# The sample parts of the project: build/parts NAME > part.stl
FIXTURE_MAINS = tests/fixtures/parts.c tests/fixtures/ffxfiles.c
FIXTURE_OBJ := $(patsubst %,$(BUILD)/%.o,$(filter-out $(FIXTURE_MAINS),$(wildcard tests/fixtures/*.c)))
$(BUILD)/libfixtures.a: $(FIXTURE_OBJ)
	$(call say,$(AR) $@)rm -f $@ && $(AR) rcs $@ $^
$(BUILD)/parts: $(BUILD)/tests/fixtures/parts.c.o $(BUILD)/libfixtures.a $(BUILD)/libcagewright.a
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $^ $(LIBS)
# Writes the streams under tests/formats/ffx; to be run again when the tables of the coder change.
$(BUILD)/ffxfiles: $(BUILD)/tests/fixtures/ffxfiles.c.o $(BUILD)/libcagewright.a
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $^ -lcmocka $(LIBS)
# Trains these tables: build/train cages > build/ffx_tables.c. corpus makes cages of dense meshes, descend puts them on grids.
TRAINERS = train corpus descend
$(TRAINERS:%=$(BUILD)/%): $(BUILD)/%: $(BUILD)/tests/train/%.c.o $(BUILD)/libcagewright.a
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $^ $(LIBS)

$(BUILD)/tests/%: $(BUILD)/tests/unit/%.c.o $(BUILD)/libfixtures.a $(BUILD)/libstages.a $(BUILD)/libcagewright.a
	@mkdir -p $(@D)
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $< $(BUILD)/libfixtures.a $(BUILD)/libstages.a $(BUILD)/libcagewright.a -lcmocka $(LIBS)

# The longest first, so that both ends of the run are busy.
SCRIPTS := $(wildcard tests/property/*.t tests/cli/*.t tests/golden/*.t)
# tests/tools/run starts a test in a clean environment, bounded in time, with BIN and PARTS in it.
PROVE = BIN=$(abspath $(BIN)) PARTS=$(abspath $(BUILD)/parts) DATA='$(abspath $(DATA))' prove -j$(JOBS) -e 'sh tests/tools/run'

.PHONY: check unit check-san san-run
check: $(TOOLS) $(UNITS) $(BUILD)/parts | $(deps_first)
	@$(PROVE) $(SCRIPTS) $(UNITS)
unit: $(UNITS) | $(deps_first)
	@$(PROVE) $(UNITS)

# What reads foreign bytes, and the decoder with what it calls.
SAN_UNITS := $(filter $(foreach t,number input output ply mesh dense network cage conformance export rangecoder facefixer ffx ffxangle ffxdamage \
	repair subdivide half,$(BUILD)/tests/test_$(t)),$(UNITS))
check-san: | $(deps_first)
	@$(MAKE) --no-print-directory BUILD=build/san SAN=address,undefined san-run
san-run: $(SAN_UNITS) $(TOOLS) $(BUILD)/parts
	@$(PROVE) $(SAN_UNITS) $(wildcard tests/cli/damage.t)

# --- demo and bench ----------------------------------------------------------------------------------------------
.PHONY: demo bench
DEMO_PART ?= flange
DEMO_SIZE ?= 640x480
demo: $(TOOLS) $(BUILD)/parts | $(deps_first)
	@BIN=$(BIN)/ PARTS=$(BUILD)/parts SIZE=$(DEMO_SIZE) sh tests/tools/demo $(DEMO_PART) build/demo
# The pictures of README.md.
PICTURES = part segment network cage refined deviation
.PHONY: pictures
pictures: DEMO_SIZE = 480x360
pictures: demo
	mkdir -p man/pictures
	for p in $(PICTURES); do cp build/demo/$$p.png man/pictures/ || exit 1; done
PART_SECONDS ?= 60
PART_MIB ?= 2048
# Two programs of the bench use CGAL, which is C++ headers: built where libcgal-dev is, done without elsewhere.
CGAL_MAINS := $(if $(wildcard /usr/include/CGAL/Surface_mesh.h /usr/local/include/CGAL/Surface_mesh.h),crossings simplify)
CGAL_OBJ := $(CGAL_MAINS:%=$(BUILD)/tests/bench/%.cpp.o)
# Exact predicates need the rounding that they set. CGAL's checks of its own are left out; they cost half the time.
$(CGAL_OBJ): CXXFLAGS += -frounding-math -DNDEBUG
$(CGAL_MAINS:%=$(BUILD)/%): $(BUILD)/%: $(BUILD)/tests/bench/%.cpp.o $(BUILD)/libcagewright.a
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $^ -lgmp -lmpfr $(LIBS)
crossings := $(if $(CGAL_MAINS),$(BUILD)/crossings)
simplify := $(if $(CGAL_MAINS),$(BUILD)/simplify)
bench: $(TOOLS) $(crossings) | $(deps_first)
	@BIN=$(abspath $(BIN)) CROSSINGS=$(abspath $(crossings)) PART_SECONDS=$(PART_SECONDS) PART_MIB=$(PART_MIB) \
	sh tests/bench/bench '$(DATA)' $(BUILD)
# PARTS=names for some alone; ours at each bound of PEER_TOLS.
PEER_TOLS ?= 0.1%
PEER_MAX ?= 1%
PEER_TRIANGLES ?= 50000
.PHONY: bench-peers
bench-peers: $(TOOLS) $(simplify) | $(deps_first)
	@BIN=$(abspath $(BIN)) SIMPLIFY=$(abspath $(simplify)) PART_SECONDS=$(PART_SECONDS) PART_MIB=$(PART_MIB) PARTS='$(PARTS)' \
	PEER_TOLS='$(PEER_TOLS)' PEER_MAX='$(PEER_MAX)' PEER_TRIANGLES='$(PEER_TRIANGLES)' sh tests/bench/bench-peers '$(DATA)' $(BUILD)
# The adjusted Rand index of the sample parts, whose true faces are known: build/segmentation.tsv.
.PHONY: bench-segmentation
bench-segmentation: $(TOOLS) $(BUILD)/parts $(BUILD)/rand_index | $(deps_first)
	@BIN=$(abspath $(BIN)) PARTS=$(abspath $(BUILD)/parts) RAND_INDEX=$(abspath $(BUILD)/rand_index) \
	sh tests/bench/segmentation $(BUILD)
# One sample part at SCALING_SIZES triangles.
SCALING_PART ?= flange
SCALING_SIZES ?= 1000 3000 10000 30000 100000 300000 1000000
.PHONY: bench-scaling
bench-scaling: $(TOOLS) $(BUILD)/parts | $(deps_first)
	@BIN=$(abspath $(BIN)) PARTS=$(abspath $(BUILD)/parts) PART_SECONDS=$(PART_SECONDS) PART_MIB=$(PART_MIB) \
	SCALING_PART='$(SCALING_PART)' SCALING_SIZES='$(SCALING_SIZES)' sh tests/bench/scaling $(BUILD)
# The streams of the sample parts, or of the parts of DATA (PARTS=names for some alone), packed in little time. Beside OpenSubdiv
# where libosd-dev is.
DECODE_EFFORT ?= 1
DECODE_ROUNDS ?= 101
OSD := $(firstword $(wildcard /usr/include/opensubdiv/far/primvarRefiner.h /usr/local/include/opensubdiv/far/primvarRefiner.h))
.PHONY: bench-decode
bench-decode: $(TOOLS) $(BUILD)/parts $(BUILD)/decode | $(deps_first)
	@BIN=$(abspath $(BIN)) SAMPLES=$(abspath $(BUILD)/parts) DECODE=$(abspath $(BUILD)/decode) PARTS='$(PARTS)' \
	DECODE_EFFORT=$(DECODE_EFFORT) DECODE_ROUNDS=$(DECODE_ROUNDS) sh tests/bench/bench-decode '$(DATA)' $(BUILD)
$(BUILD)/decode: $(BUILD)/tests/bench/decode.c.o $(if $(OSD),$(BUILD)/tests/bench/decode_opensubdiv.cpp.o) $(BUILD)/libcagewright.a
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $^ $(if $(OSD),-losdCPU) $(LIBS)
$(BUILD)/rand_index: $(BUILD)/tests/bench/rand_index.c.o $(BUILD)/libcagewright.a
	$(call say,link $@)$(CXX) $(all_ldflags) -o $@ $^ $(LIBS)

# --- fuzz --------------------------------------------------------------------------------------------------------
FUZZ_SECONDS ?= 30
FUZZ_C := $(wildcard tests/fuzz/fuzz_*.c)
FUZZ_TARGETS := $(FUZZ_C:tests/fuzz/%.c=build/fuzz/%)
FUZZ_FLAGS = -fsanitize=fuzzer-no-link,address,undefined
.PHONY: fuzz
fuzz: | $(deps_first)
	@$(MAKE) --no-print-directory CC=clang CXX=clang++ BUILD=build/fuzz/objects OPENMP=-Wno-unknown-pragmas \
	CFLAGS='-O1 -g $(FUZZ_FLAGS)' CXXFLAGS='-O1 -g $(FUZZ_FLAGS)' fuzz-build
	@for t in $(FUZZ_TARGETS); do sh tests/tools/fuzz $$t $(FUZZ_SECONDS) || exit 1; done
.PHONY: fuzz-build
fuzz-build: $(FUZZ_TARGETS)
build/fuzz/fuzz_%: build/fuzz/objects/tests/fuzz/fuzz_%.c.o build/fuzz/objects/libcagewright.a
	$(CXX) -fsanitize=fuzzer,address,undefined -Wl,--as-needed -o $@ $^ -lcmocka $(LIBS)

# --- lint --------------------------------------------------------------------------------------------------------
LINT_C := $(sort $(wildcard formats/*.c stages/*/*.c tests/unit/*.c tests/fixtures/*.c tests/train/*.c tests/bench/*.c tests/fuzz/*.c))
LINT_SH := $(sort .ci/run $(filter-out %.txt,$(wildcard tests/tools/*)) $(wildcard tests/cli/*.t tests/golden/*.t tests/property/*.t tests/bench/bench* tests/bench/segmentation tests/bench/scaling pipelines/batch-*))
LINT_PAGES := $(sort $(wildcard man/man*/*))
.PHONY: lint lint-gcc lint-clang lint-cppcheck lint-sh lint-man
lint: lint-gcc lint-clang lint-cppcheck lint-sh lint-man
	@echo 'lint: clean'
# -O1: some warnings need data flow, none needs more.
lint-gcc: $(LINT_C:%=build/lint/gcc/%.o) $(SHIM_CPP:%=build/lint/gcc/%.o)
lint-clang: $(LINT_C:%=build/lint/clang/%.o) $(SHIM_CPP:%=build/lint/clang/%.o)
build/lint/gcc/%.c.o: CC = gcc
build/lint/gcc/%.cpp.o: CXX = g++
build/lint/clang/%.c.o: CC = clang
build/lint/clang/%.cpp.o: CXX = clang++
build/lint/%.o: CFLAGS = -O1
build/lint/%.o: WERROR = -Werror
build/lint/gcc/%.c.o build/lint/clang/%.c.o: %.c | $(deps_first)
	@mkdir -p $(@D)
	$(call say,$(CC) $<)$(CC) $(CPPFLAGS) $(all_cflags) -c -o $@ $<
build/lint/gcc/%.cpp.o build/lint/clang/%.cpp.o: %.cpp | $(deps_first)
	@mkdir -p $(@D)
	$(call say,$(CXX) $<)$(CXX) $(CPPFLAGS) $(all_cxxflags) -c -o $@ $<
# The unit tests are left to the compilers: they take longest, and cannot harm a user.
lint-cppcheck: | $(deps_first)
	@mkdir -p build/lint/cppcheck
	cppcheck -q -j$(JOBS) --cppcheck-build-dir=build/lint/cppcheck --error-exitcode=1 --std=c11 --language=c -I. -D_GNU_SOURCE --inline-suppr \
	--enable=warning,performance,portability --suppressions-list=tests/tools/cppcheck.txt $(filter-out tests/fuzz/% tests/unit/% tests/train/%,$(LINT_C))
lint-sh: | $(deps_first)
	shellcheck -s sh -S warning -e SC3013 $(LINT_SH)
lint-man: | $(deps_first)
	mandoc -T lint -W warning $(LINT_PAGES)
-include $(wildcard build/lint/*/*/*.d build/lint/*/*/*/*.d)

# --- install -----------------------------------------------------------------------------------------------------
bindir = $(DESTDIR)$(PREFIX)/bin
mandir = $(DESTDIR)$(PREFIX)/share/man
datadir = $(DESTDIR)$(PREFIX)/share/cagewright
docdir = $(DESTDIR)$(PREFIX)/share/doc/cagewright
.PHONY: install uninstall
install: $(TOOLS)
	mkdir -p $(bindir) $(datadir) $(docdir) $(mandir)/man1 $(mandir)/man5 $(mandir)/man7
	install -m 755 $(TOOLS) $(bindir)
	install -m 644 $(wildcard pipelines/*) $(datadir)
	install -m 644 README.md LICENSE NEWS.md $(docdir)
	for n in 1 5 7; do install -m 644 man/man$$n/*.$$n $(mandir)/man$$n || exit 1; done
uninstall:
	rm -f $(foreach t,$(TOOLS),$(bindir)/$(notdir $(t))) $(foreach p,$(wildcard man/man*/*),$(mandir)/$(notdir $(patsubst %/,%,$(dir $(p))))/$(notdir $(p)))
	rm -rf $(datadir) $(docdir)

.PHONY: clean
clean:
	rm -rf build bin

-include $(LIB_OBJ:.o=.d) $(KERNEL_OBJ:.o=.d) $(SHIM_OBJ:.o=.d) $(MAIN_OBJ:.o=.d) $(UNIT_OBJ:.o=.d) $(FIXTURE_OBJ:.o=.d)
-include $(FIXTURE_MAINS:%=$(BUILD)/%.d) $(TRAINERS:%=$(BUILD)/tests/train/%.c.d) $(CGAL_OBJ:.o=.d)
