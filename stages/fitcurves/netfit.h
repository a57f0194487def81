/* The whole network: one fitted curve a border chain, rules that later stages rely on (the patch method's section 4.6). */
#ifndef CAGEWRIGHT_NETFIT_H
#define CAGEWRIGHT_NETFIT_H

#include "stages/geometry/border.h"

struct netfit_options {
	double max, mean; /* distances allowed for curves, model units */
	bool free_counts; /* do not give opposite curves the same number of points */
};

struct netfit_report {
	size_t nodes, curves, points, closed, straight;
	size_t contracted; /* curves shorter than max / 2 that became one node */
	size_t harmonised; /* curves fitted again for the sake of their opposite */
	size_t uncrossed;  /* points added because a control polygon cut another on the same plane */
	size_t relaxed;    /* borders without a place of their own, drawn taut on the surface first */
	size_t smoothed;   /* other curves along staircases of triangles */
	size_t split;      /* inner points added so that no two curves make a double edge and no patch a face of two vertices */
	size_t missed;     /* curves outside their tolerance, and the worst of them */
	double worst;
	double error; /* largest error of any curve, model units */
};

/* dense and border as border_extract left them. The network is the caller's to free. */
void netfit(struct network *network, struct netfit_report *report, const struct dense *dense, const struct border_network *border,
	    struct netfit_options options);

#endif
