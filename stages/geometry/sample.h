/* Points spread evenly over a triangle mesh. */
#ifndef CAGEWRIGHT_SAMPLE_H
#define CAGEWRIGHT_SAMPLE_H

#include "formats/memory.h"

/* count points, uniform by area: one in each of count equal shares of the area in triangle order (stratified), placed in
 * its triangle by the R2 low-discrepancy sequence (Roberts 2018), shifted at random by the seed. point: 3 a sample; triangle:
 * the one that each lies on, rising. Returns the whole area; when that is 0 or not finite nothing is written.
 * O(count + triangle_count). */
double sample_surface(double *restrict point, idx_t *restrict triangle, size_t count, const double *restrict xyz,
                      const idx_t *restrict mesh_triangle, size_t triangle_count, uint64_t seed);

#endif
