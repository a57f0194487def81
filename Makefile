# Cagewright: one graph for everything. `make help` lists what can be made.
#
# Variables of the user: CC CXX CFLAGS LDFLAGS PREFIX DESTDIR BUILD SAN DATA.
# BUILD=build/asan SAN=address,undefined builds a sanitized variant beside the default one.

BUILD ?= build
BIN ?= $(if $(SAN),$(BUILD)/bin,bin)
PREFIX ?= /usr/local
CFLAGS ?= -O2 -g
CXXFLAGS ?= $(CFLAGS)

WARN = -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wvla -Wstrict-prototypes -Wmissing-prototypes \
	-Werror=implicit-function-declaration $(WERROR)
# -ffp-contract=off: clang, and gcc with gnu11, fuse a*b+c by default, and the same input must give the same bytes.
all_cflags = -std=c11 -D_GNU_SOURCE -I. $(WARN) -ffp-contract=off -fopenmp -MMD -MP $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer) $(CFLAGS)
all_cxxflags = -std=c++17 -I. -Wall -Wextra $(WERROR) -ffp-contract=off -MMD -MP $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer) $(CXXFLAGS)
all_ldflags = -fopenmp -Wl,--as-needed $(if $(SAN),-fsanitize=$(SAN)) $(LDFLAGS)
OPENMESH = -lOpenMeshTools -lOpenMeshCore
LIBS = $(OPENMESH) -lembree3 -lcholmod -llapacke -lz -lpng -lOSMesa -lGLU -lm

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

.PHONY: all
all: $(TOOLS)
.DELETE_ON_ERROR:
.SECONDARY:

.PHONY: help
help:
	@echo 'all      build every tool into $(BIN)/'
	@echo 'deps     install the Debian packages that are missing (root, or sudo)'
	@echo 'demo     pack a sample part; pictures of every stage in build/demo'
	@echo 'check    every test; check-san: the readers and the decoder under sanitizers'
	@echo 'bench    the pipeline over DATA=folder; build/bench.tsv and build/bench.html'
	@echo 'lint     compiler warnings as errors (gcc, clang), cppcheck, manual pages'
	@echo 'fuzz     the readers under libFuzzer, FUZZ_SECONDS each'
	@echo 'install  into $$(DESTDIR)$(PREFIX)'

# --- packages ----------------------------------------------------------------------------------------------------
BUILD_PACKAGES = gcc g++ make libopenmesh-dev zlib1g-dev libembree-dev libsuitesparse-dev liblapacke-dev libosmesa6-dev libglu1-mesa-dev libpng-dev
CHECK_PACKAGES = libcmocka-dev mandoc perl gzip valgrind
LINT_PACKAGES = clang clang-tidy cppcheck clang-format
missing_of = $(shell for p in $(1); do dpkg-query -W -f='$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || echo $$p; done)
as_root = $(if $(filter 0,$(shell id -u)),,sudo)

# deps installs what is missing and says what it does; deps-NAME are what demo, check and lint call first.
define install_packages
	@missing='$(strip $(1))'; test -z "$$missing" || { \
	if ! command -v apt-get > /dev/null; then echo "make deps: not a Debian system; install: $$missing" >&2; exit 1; fi; \
	if test -n '$(as_root)' && ! command -v sudo > /dev/null; then echo "make deps: neither root nor sudo here; as root run: apt-get install $$missing" >&2; exit 1; fi; \
	echo "make deps: apt-get install $$missing"; \
	$(as_root) apt-get update -q && DEBIAN_FRONTEND=noninteractive $(as_root) apt-get install -qy --no-install-recommends $$missing || \
	{ echo "make deps: could not install: $$missing" >&2; exit 1; }; }
endef
.PHONY: deps deps-build deps-check deps-lint
deps: deps-build deps-check
deps-build:
	$(call install_packages,$(call missing_of,$(BUILD_PACKAGES)))
deps-check: deps-build
	$(call install_packages,$(call missing_of,$(CHECK_PACKAGES)))
deps-lint: deps-check
	$(call install_packages,$(call missing_of,$(LINT_PACKAGES)))

$(BUILD)/%.c.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(all_cflags) -c -o $@ $<
$(BUILD)/%.cpp.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) $(CPPFLAGS) $(all_cxxflags) -c -o $@ $<

# One archive for formats and shared geometry, one for the methods of the stages; each tool pulls what it needs.
$(BUILD)/libcagewright.a: $(LIB_OBJ) $(SHIM_OBJ)
	rm -f $@ && $(AR) rcs $@ $^
$(BUILD)/libstages.a: $(KERNEL_OBJ)
	rm -f $@ && $(AR) rcs $@ $^

# unpack is plain C and needs nothing but libc, libm and zlib: a link that asks for more fails.
LINK = $(CXX)
$(BIN)/unpack: LINK = $(CC)
$(BIN)/unpack: LIBS = -lz -lm
define tool_rule
$(BIN)/$(1): $(BUILD)/stages/$(1)/$(1).c.o $(BUILD)/libstages.a $(BUILD)/libcagewright.a
	@mkdir -p $$(@D)
	$$(LINK) $$(all_ldflags) -o $$@ $$< $(BUILD)/libstages.a $(BUILD)/libcagewright.a $$(LIBS)
endef
$(foreach m,$(MAINS),$(eval $(call tool_rule,$(basename $(notdir $(m))))))

# --- tests -------------------------------------------------------------------------------------------------------
$(BUILD)/tests/%: $(BUILD)/tests/unit/%.c.o $(BUILD)/libstages.a $(BUILD)/libcagewright.a
	@mkdir -p $(@D)
	$(CXX) $(all_ldflags) -o $@ $< $(BUILD)/libstages.a $(BUILD)/libcagewright.a -lcmocka $(LIBS)

# The sample parts of the project: build/parts NAME > part.stl
FIXTURE_OBJ := $(patsubst %,$(BUILD)/%.o,$(filter-out tests/fixtures/parts.c,$(wildcard tests/fixtures/*.c)))
$(BUILD)/libfixtures.a: $(FIXTURE_OBJ)
	rm -f $@ && $(AR) rcs $@ $^
$(BUILD)/parts: $(BUILD)/tests/fixtures/parts.c.o $(BUILD)/libfixtures.a $(BUILD)/libcagewright.a
	$(CXX) $(all_ldflags) -o $@ $^ $(LIBS)
-include $(FIXTURE_OBJ:.o=.d) $(BUILD)/tests/fixtures/parts.c.d
# Unit tests may build parts in memory (tests/fixtures/parts.h).
$(UNITS): $(BUILD)/libfixtures.a
$(UNITS): LIBS := $(BUILD)/libfixtures.a $(BUILD)/libcagewright.a $(LIBS)

.PHONY: unit
unit: $(UNITS)
	CMOCKA_MESSAGE_OUTPUT=TAP prove -e '' $(UNITS)

.PHONY: clean
clean:
	rm -rf build bin

-include $(LIB_OBJ:.o=.d) $(KERNEL_OBJ:.o=.d) $(SHIM_OBJ:.o=.d) $(MAIN_OBJ:.o=.d) $(UNIT_OBJ:.o=.d)
