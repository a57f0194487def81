/* What a later stage needs to find the chains of a fitted network again: the options, and which chain is whose. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/number.h"
#include "stages/geometry/border.h"
#include "stages/geometry/vector.h"

static const char options_comment[] = "comment cagewright-border ";

/* The number behind name in text, or otherwise. */
static double option_value(const char *text, const char *name, double low, double high, double otherwise)
{
	const char *found = strstr(text, name);
	double value;
	if (!found)
		return otherwise;
	found += strlen(name);
	return num_parse(found, strcspn(found, " "), &value) && value >= low && value <= high ? value : otherwise;
}

struct border_options border_options_from_ply(const struct ply *ply)
{
	struct border_options options = BORDER_DEFAULTS;
	for (size_t c = 0; c < ply->comment_count; c++) {
		const char *text = ply->comment[c];
		if (strncmp(text, options_comment, sizeof options_comment - 1) != 0)
			continue;
		options.corner_deg = option_value(text, " corner=", 0, 180, options.corner_deg);
		options.smooth_deg = option_value(text, " smooth=", 0, 180, options.smooth_deg);
	}
	return options;
}

void border_options_to_ply(struct ply *ply, struct border_options options)
{
	size_t kept = 0;
	for (size_t c = 0; c < ply->comment_count; c++) {
		if (strncmp(ply->comment[c], options_comment, sizeof options_comment - 1) == 0)
			free(ply->comment[c]);
		else
			ply->comment[kept++] = ply->comment[c];
	}
	ply->comment_count = kept;
	char corner[NUM_TEXT_SIZE], smooth[NUM_TEXT_SIZE];
	num_print(corner, options.corner_deg);
	num_print(smooth, options.smooth_deg);
	ply_comment(ply, "cagewright-border corner=%s smooth=%s", corner, smooth);
}

void border_match(idx_t *chain_of_curve, const struct border_network *border, const struct dense *dense,
		  const struct network *network)
{
	for (size_t c = 0; c < network->curve_count; c++) {
		const struct curve *curve = network->curve + c;
		double best = INFINITY;
		chain_of_curve[c] = NO_INDEX;
		double middle[3] = {0, 0, 0};
		for (size_t i = 0; i < curve->count; i++)
			add_scaled3(middle, 1 / (double)curve->count,
				    network->xyz + 3 * (size_t)network->point[curve->first + i]);
		const double *p = network->xyz + 3 * (size_t)network->point[curve->first];
		const double *q = network->xyz + 3 * (size_t)network->point[curve->first + curve->count - 1];
		for (size_t i = 0; i < border->chain_count; i++) {
			const struct border_chain *chain = border->chain + i;
			const bool same = chain->left == curve->left && chain->right == curve->right,
				   turned = chain->left == curve->right && chain->right == curve->left;
			if ((!same && !turned) || chain->closed != curve->closed)
				continue;
			double centre[3] = {0, 0, 0}, total = 0;
			for (size_t k = 1; k < chain->count + chain->closed; k++) {
				const double *a = dense->xyz + 3 * (size_t)border->vertex[chain->first + k - 1];
				const double *b = dense->xyz + 3 * (size_t)border->vertex[chain->first + k % chain->count];
				const double length = distance3(a, b);
				add_scaled3(centre, length / 2, a);
				add_scaled3(centre, length / 2, b);
				total += length;
			}
			if (total > 0)
				scale3(centre, 1 / total);
			double cost = distance3(middle, centre);
			if (!chain->closed) {
				const double *a =
					dense->xyz + 3 * (size_t)border->vertex[chain->first + (same ? 0 : chain->count - 1)];
				const double *b =
					dense->xyz + 3 * (size_t)border->vertex[chain->first + (same ? chain->count - 1 : 0)];
				cost += distance3(p, a) + distance3(q, b);
			}
			if (cost < best)
				best = cost, chain_of_curve[c] = (idx_t)i;
		}
	}
}
