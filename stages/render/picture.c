#include "stages/render/picture.h"

#include <png.h>

/* A write that fails stays noted in the stream, and output_commit says why. */
static void write_bytes(png_struct *png, png_byte *bytes, size_t size)
{
	fwrite(bytes, 1, size, png_get_io_ptr(png));
}

static void flush_nothing(png_struct *png)
{
	(void)png;
}

bool picture_write(FILE *file, const unsigned char *rgb, int width, int height, struct fault *fault)
{
	png_struct *png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
	png_info *info = png != NULL ? png_create_info_struct(png) : NULL;
	if (info == NULL) {
		png_destroy_write_struct(&png, NULL);
		return fault_set(fault, EX_SYSTEM, "libpng has no memory");
	}
	if (setjmp(png_jmpbuf(png)) != 0) { /* nothing local changes after this line */
		png_destroy_write_struct(&png, &info);
		return fault_set(fault, EX_SYSTEM, "the picture could not be written");
	}
	png_set_write_fn(png, file, write_bytes, flush_nothing);
	png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
	             PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
	png_write_info(png, info);
	for (int y = 0; y < height; y++)
		png_write_row(png, rgb + 3 * (size_t)y * (size_t)width);
	png_write_end(png, info);
	png_destroy_write_struct(&png, &info);
	return true;
}
