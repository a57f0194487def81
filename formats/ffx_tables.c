/* Initial counts, weights and histograms of FFX version 1, written by tests/train/train.c. Do not edit. */
#include "formats/ffx_model.h"

const unsigned char ffx_table_count[2 * FFX_CONTEXTS] = {0};
const short ffx_table_weight[FFX_WEIGHTS] = {[0 ... FFX_WEIGHTS - 1] = 1200};
const unsigned short ffx_table_histogram[FFX_HISTOGRAMS * HISTOGRAM_CLASSES] = {[0 ... FFX_HISTOGRAMS * HISTOGRAM_CLASSES - 1] = 20};
