# patch: mechanical parts as triangle meshes to packed subdivision cages.
#
#   make -f pipelines/patch.mk IN="part.stl other.off.gz" OUT=dir [TOL=0.1% MAX=1%] [-j2]
#
# makes dir/part.ffx and, on the way, dir/part.STAGE.ply (part: the file's name without its extensions). Every file is
# written whole or not at all. Edit any of them and run the same command again: only what depends on it is made anew.
#   TOL, MAX   bounds of the mean and of the largest distance to the part, as lengths or in % of its longest side
#   EFFORT     0 to 9: how long polish looks for fewer bytes
#   LEVEL      subdivision level at which the result is measured
#   CURV SEGMENT RECTIFY FITCURVES FITPATCH ASSEMBLE POLISH FACEFIX   more options for a stage
TOL ?= 0.1%
MAX ?= 1%
LEVEL ?= 4
EFFORT ?= 5
OUT ?= .
here := $(dir $(lastword $(MAKEFILE_LIST)))
# Tools of the build beside this file, else those on PATH.
BIN ?= $(if $(wildcard $(here)../bin/curv),$(here)../bin/)

# part_of FILE: without folder, .gz and extension
part_of = $(basename $(notdir $(patsubst %.gz,%,$(1))))
# share F LENGTH: that share of a length, with its unit
share = $(shell echo '$(2)' | LC_ALL=C awk -v f=$(1) '{u = sub(/%$$/, "") ? "%" : ""; printf "%.9g%s", f * $$0, u}')

parts := $(foreach f,$(IN),$(call part_of,$(f)))
ifneq ($(words $(sort $(parts))),$(words $(parts)))
$(error two files in IN have the same part name: $(parts))
endif
# The unpacked part is $(OUT)/part.stl: that must not be the part itself.
$(foreach f,$(IN),$(if $(filter $(realpath $(f)),$(realpath $(OUT)/$(call part_of,$(f)).stl)),\
	$(error $(f) would be overwritten by the unpacked part: give another folder as OUT)))

.PHONY: all
all: $(parts:%=$(OUT)/%.report)
.DELETE_ON_ERROR:
.SUFFIXES:
.SECONDARY:

$(OUT):
	mkdir -p $@

# What shapes the result beside the part itself: a change makes the stages that use it run again.
bounds := TOL=$(TOL) MAX=$(MAX) LEVEL=$(LEVEL) EFFORT=$(EFFORT) $(FITCURVES) $(FITPATCH) $(ASSEMBLE) $(POLISH) $(FACEFIX)
$(OUT)/%.bounds: FORCE | $(OUT)
	@echo '$(bounds)' | cmp -s - $@ || echo '$(bounds)' > $@
.PHONY: FORCE
FORCE:

define rules
$(OUT)/$(1).curv.ply: $(2) | $(OUT)
	$(BIN)curv $(CURV) -o $$@ $$<
endef
$(foreach f,$(IN),$(eval $(call rules,$(call part_of,$(f)),$(f))))

$(OUT)/%.segment.ply: $(OUT)/%.curv.ply
	$(BIN)segment $(SEGMENT) -o $@ $<
$(OUT)/%.rectify.ply: $(OUT)/%.segment.ply
	$(BIN)rectify $(RECTIFY) -o $@ $<
# The curves get a share of the bounds, the patches nearly all of it, rounding the rest.
$(OUT)/%.fitcurves.ply: $(OUT)/%.rectify.ply $(OUT)/%.bounds
	$(BIN)fitcurves --tol $(call share,0.4,$(MAX)) --mean $(call share,1,$(TOL)) $(FITCURVES) -o $@ $<
$(OUT)/%.fitpatch.ply: $(OUT)/%.fitcurves.ply $(OUT)/%.rectify.ply
	$(BIN)fitpatch --tol $(call share,0.8,$(MAX)) --mean $(call share,0.8,$(TOL)) $(FITPATCH) --mesh $(OUT)/$*.rectify.ply -o $@ $<
$(OUT)/%.assemble.ply: $(OUT)/%.fitpatch.ply
	$(BIN)assemble $(ASSEMBLE) -o $@ $<
define polish
$(OUT)/$(1).polish.ply: $(OUT)/$(1).assemble.ply $(2)
	$(BIN)polish --mean $(TOL) --max $(MAX) --effort $(EFFORT) --level $(LEVEL) $(POLISH) --mesh $(2) -o $$@ $$<
endef
$(foreach f,$(IN),$(eval $(call polish,$(call part_of,$(f)),$(f))))
$(OUT)/%.ffx: $(OUT)/%.polish.ply
	$(BIN)facefix $(FACEFIX) -o $@ $<

# The error of the stream that was written, against the part that was read.
$(OUT)/%.stl: $(OUT)/%.ffx
	$(BIN)unpack --level $(LEVEL) -o $@ $<
define measure
$(OUT)/$(1).report: $(OUT)/$(1).stl $(2)
	$(BIN)deviate --mean $(TOL) --max $(MAX) -o $$@ $(2) $$<; s=$$$$?; test $$$$s -le 1 && \
	LC_ALL=C awk -F= -v part=$(1) -v bytes=`wc -c < $(OUT)/$(1).ffx` -v within=$$$$s -v tol=$(TOL) -v max=$(MAX) '{v[$$$$1] = $$$$2} \
	END {printf "%s: %d bytes, mean %.4f%%, largest %.4f%% of the longest side: %s (%s, %s)\n", part, bytes, 100 * v["sym_mean_side"], \
	100 * v["sym_max_side"], within ? "MISSES its bounds" : "within its bounds", tol, max}' $$@
endef
$(foreach f,$(IN),$(eval $(call measure,$(call part_of,$(f)),$(f))))
