/* SPDX-License-Identifier: MIT */
/* The least a CUPS filter can do: read every line of a raster through libcups and write it again.
 * copy_raster 1 writes raw CUPS raster, 3 PWG raster. */
#include <cups/raster.h>

#include <stdlib.h>

int main(int argc, char *argv[])
{
    cups_page_header2_t header;
    cups_raster_t *in = cupsRasterOpen(0, CUPS_RASTER_READ);
    cups_raster_t *out =
        cupsRasterOpen(1, argc > 1 && *argv[1] == '3' ? CUPS_RASTER_WRITE_PWG : CUPS_RASTER_WRITE);
    while (cupsRasterReadHeader2(in, &header)) {
        unsigned char *line = malloc(header.cupsBytesPerLine);
        if (!line || !cupsRasterWriteHeader2(out, &header))
            return 1;
        for (unsigned y = 0; y < header.cupsHeight; y++) {
            cupsRasterReadPixels(in, line, header.cupsBytesPerLine);
            if (!cupsRasterWritePixels(out, line, header.cupsBytesPerLine))
                return 1;
        }
        free(line);
    }
    return 0;
}
