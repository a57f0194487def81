#include "stages/render/legend.h"

#include <stdio.h>
#include <string.h>

/* Our own digits, five by seven: a row a byte, the highest of five bits left. */
static const struct glyph {
	char letter;
	unsigned char row[7];
} font[] = {
	{'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}}, {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
	{'2', {0x0e, 0x11, 0x01, 0x06, 0x08, 0x10, 0x1f}}, {'3', {0x1e, 0x01, 0x01, 0x0e, 0x01, 0x01, 0x1e}},
	{'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}}, {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
	{'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}}, {'7', {0x1f, 0x01, 0x02, 0x04, 0x04, 0x08, 0x08}},
	{'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}}, {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
	{'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}}, {'-', {0x00, 0x00, 0x00, 0x0e, 0x00, 0x00, 0x00}},
	{'+', {0x00, 0x04, 0x04, 0x1f, 0x04, 0x04, 0x00}}, {'e', {0x00, 0x00, 0x0e, 0x11, 0x1f, 0x10, 0x0e}},
	{'%', {0x18, 0x19, 0x02, 0x04, 0x08, 0x13, 0x03}},
};

static void fill(unsigned char *rgb, int width, int x0, int y0, int w, int h, struct colour colour)
{
	for (int y = y0; y < y0 + h; y++)
		for (int x = x0; x < x0 + w; x++) {
			unsigned char *pixel = rgb + 3 * ((size_t)y * (size_t)width + (size_t)x);
			pixel[0] = colour.red, pixel[1] = colour.green, pixel[2] = colour.blue;
		}
}

/* Text of 6 * scale a letter; the caller has checked that it fits. */
static void write_text(unsigned char *rgb, int width, int x, int y, const char *text, int scale)
{
	for (; *text != '\0'; text++, x += 6 * scale)
		for (size_t g = 0; g < sizeof font / sizeof *font; g++)
			if (font[g].letter == *text)
				for (int i = 0; i < 35; i++)
					if (font[g].row[i / 5] >> (4 - i % 5) & 1)
						fill(rgb, width, x + i % 5 * scale, y + i / 5 * scale, scale, scale, (struct colour){40, 40, 45});
}

void legend_draw(unsigned char *rgb, int width, int height, const struct scene *scene)
{
	const int scale = height >= 500 ? 2 : 1, bar_width = 90 * scale, bar_height = 7 * scale, margin = 6 * scale;
	char low[32], high[32];
	snprintf(low, sizeof low, "%.3g%s", scene->legend_low, scene->legend_unit != NULL ? scene->legend_unit : "");
	snprintf(high, sizeof high, "%.3g%s", scene->legend_high, scene->legend_unit != NULL ? scene->legend_unit : "");
	const int low_width = 6 * scale * (int)strlen(low), high_width = 6 * scale * (int)strlen(high);
	const int whole = 4 * margin + low_width + bar_width + high_width, y = height - margin - bar_height;
	if (!scene->has_legend || whole > width || height < 4 * margin)
		return;
	int x = margin;
	write_text(rgb, width, x, y, low, scale);
	x += low_width + margin / 2;
	fill(rgb, width, x - 1, y - 1, bar_width + 2, bar_height + 2, (struct colour){40, 40, 45});
	for (int i = 0; i < bar_width; i++)
		fill(rgb, width, x + i, y, 1, bar_height, palette_scale(scene->legend_scale, (i + 0.5) / bar_width));
	write_text(rgb, width, x + bar_width + margin, y, high, scale);
}
