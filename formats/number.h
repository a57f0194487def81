/* Numbers as text, without locale: the whole field or nothing. */
#ifndef CAGEWRIGHT_NUMBER_H
#define CAGEWRIGHT_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

/* Parse text[0..length) as one decimal number (C syntax without hex; "nan" and "inf" in any case are accepted and
 * given as such). False when anything is left over or the field is empty. Out of double's range gives +-HUGE_VAL. */
bool num_parse(const char *text, size_t length, double *value);

/* Parse a whole integer within [low, high]. */
bool num_parse_integer(const char *text, size_t length, long long low, long long high, long long *value);

/* Longest text that the printers below make, with its final 0. */
#define NUM_TEXT_SIZE 32

/* The shortest decimal text that reads back as exactly this double (or float); returns its length.
 * Integers below 1e15 are written without exponent; -0 is written "-0". */
size_t num_print(char text[NUM_TEXT_SIZE], double value);
size_t num_print_float(char text[NUM_TEXT_SIZE], float value);

#endif
