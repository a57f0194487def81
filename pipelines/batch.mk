# batch: any pipeline over a collection of parts, on one machine or on a cluster, resumable.
#
#   make -f pipelines/batch.mk IN="folder list.txt part.stl" OUT=dir [-j8] [LAUNCH='srun -Q -n1 -N1']
#
# makes dir/part/ for each part, whole or not at all, and dir/batch.tsv and dir/batch.html of all. A part that fails is
# recorded with its message and does not stop the rest. The same command again does what is missing or stale.
#   IN         folders (all files of KINDS in them), lists (a path a line, # comments), parts
#   PIPELINE   patch, or the path of a makefile with the same interface: IN= OUT=
#   KEEP       what stays of a part beside log and row: endings of files, or all
#   RETRY=1    those that failed once more; FRESH=1: everything
#   PART_SECONDS PART_MIB THREADS    bounds for each part
#   LAUNCH     what runs a command elsewhere; LAUNCHES: how often, when it fails to
#   SHARE=i/n  every n-th part alone, for job arrays; `table` as goal: only the table of what is there
# All other variables of the command line are the pipeline's: TOL=0.2% FITPATCH=...
# Four scripts do the work: batch-plan once, batch-launch and batch-part for each part, batch-table at the end.
PIPELINE ?= patch
KINDS ?= stl off obj ply om
KEEP ?= ffx scode report
PART_SECONDS ?= 600
PART_MIB ?= 2048
THREADS ?= 1
LAUNCHES ?= 5
here := $(abspath $(dir $(lastword $(MAKEFILE_LIST))))/
# Tools of the build beside this file, else those on PATH.
BIN ?= $(if $(wildcard $(here)../bin/curv),$(here)../bin/)
pipeline := $(abspath $(if $(findstring /,$(PIPELINE))$(filter %.mk,$(PIPELINE)),$(PIPELINE),$(here)$(PIPELINE).mk))

# quoted TEXT: one word for the shell
quoted = '$(subst ','\'',$(1))'
own := IN OUT PIPELINE KINDS KEEP RETRY FRESH PART_SECONDS PART_MIB THREADS LAUNCH LAUNCHES SHARE BIN
blank := $(subst ,, )
given := $(foreach v,$(filter-out $(own),$(.VARIABLES)),$(if $(filter command_line,$(subst $(blank),_,$(origin $(v)))),$(v)))
options := $(foreach v,$(sort $(given)),$(call quoted,$(v)=$($(v))))

run := $(shell $(foreach v,IN OUT PIPELINE KINDS KEEP RETRY FRESH PART_SECONDS PART_MIB THREADS LAUNCH LAUNCHES SHARE BIN options pipeline here,\
	$(v)=$(call quoted,$($(v)))) MAKE_PID=$$PPID sh $(here)batch-plan)
ifneq ($(.SHELLSTATUS),0)
$(error nothing is done)
endif
todo := $(shell cat $(run)/todo)

.PHONY: all parts table
.SUFFIXES:
all: table
# After the parts, when both are to be made. A share of the parts makes no table: the shares end at different times.
table: $(if $(filter table,$(MAKECMDGOALS)),,parts)
	@sh $(here)batch-table $(run)

jobs := $(todo:%=part-%)
.PHONY: $(jobs)
parts: $(jobs)
# --tied: should make be killed, the part ends with it. -: should the launch itself fail, the others go on.
$(jobs): part-%:
	@-exec $(BIN)bounded --tied -- sh $(here)batch-launch $(run) $*
