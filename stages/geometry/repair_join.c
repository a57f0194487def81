#include "stages/geometry/repair_internal.h"
void soup_weld_border(struct soup *soup, double distance) { (void)soup; (void)distance; }
void soup_split_junctions(struct soup *soup, double distance) { (void)soup; (void)distance; }
