/* The published segmentation, first half: k-means of principal curvatures and region growing
 * (Lavoue, Dupont, Baskurt, A new CAD mesh segmentation method based on curvature tensor analysis, CAD 37, 2005). */
#ifndef CAGEWRIGHT_CLASSIC_CLUSTER_H
#define CAGEWRIGHT_CLASSIC_CLUSTER_H

#include "stages/segment/curvature_feature.h"
#include "stages/segment/regions.h"

#define CLASSIC_CLUSTERS_MOST 16

/* Cluster of each triangle in [0, count]: 0 is the fixed one of flat triangles. clusters 0: the smallest of 1..8 whose
 * distortion is below 5 % of that of one cluster, or that the next one improves by less than 15 %. Returns count. Only
 * triangles with label NO_INDEX are clustered. Deterministic (k-means++ with a fixed seed, weights by area). */
int classic_cluster(unsigned char *cluster, const struct regions *regions, const struct curvature_feature *feature, int clusters);

/* Free regions of triangles of one cluster, from large triangles on, over edges that are not sharp; flat ones only where
 * the bend is below one degree, directed ones only where directions agree within 30 degrees. Takes every triangle with
 * label NO_INDEX. */
void classic_grow(struct regions *regions, const struct curvature_feature *feature, const unsigned char *cluster);

#endif
